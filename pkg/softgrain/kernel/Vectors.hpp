// Many vectors at a time: the box that holds them, the longest and the farthest of them, all of
// them made unit vectors. In the plane four at a time, with the bits of one by one.
#pragma once

#include "Vector.hpp"

#include <vector>

namespace softgrain {

template <int dim> struct Box {
	Vec<dim> low = Vec<dim>::Zero(), high = Vec<dim>::Zero();

	bool overlaps(const Box& other) const
	{
		return (low.array() <= other.high.array()).all() &&
		       (other.low.array() <= high.array()).all();
	}
	/// (Without branches: no processor foresees which of many vectors are inside.)
	bool contains(const Vec<dim>& x) const
	{
		return (x - low).cwiseMin(high - x).minCoeff() >= 0;
	}
	/// Whether another box is inside, with so much room before the faces across each axis.
	bool contains(const Box& other, const Vec<dim>& room) const
	{
		return ((other.low - low).cwiseMin(high - other.high) - room).minCoeff() >= 0;
	}
	Box grown(double margin) const { return { low.array() - margin, high.array() + margin }; }
	Vec<dim> centre() const { return 0.5 * (low + high); }
};

/// Of the numbers below `count` those that pass, in their order.
template <class Passes> std::vector<int> numbersThat(int count, Passes&& passes)
{
	std::vector<int> found(count);
	int last = 0;
	for (int k = 0; k < count; ++k) {
		found[last] = k;
		last += passes(k);
	}
	found.resize(last);
	return found;
}

/// Of one vector at least.
template <int dim> Box<dim> boxOf(const std::vector<Vec<dim>>& vectors);

/// Largest distance of a vector from `centre`.
template <int dim>
double farthestFrom(const Vec<dim>& centre, const std::vector<Vec<dim>>& vectors);
/// Makes them unit vectors; zero stays.
template <int dim> void normalizeAll(std::vector<Vec<dim>>& vectors);

/// Of some vectors none differs from `middle` by more than `spread`.
template <int dim> struct VectorRange {
	Vec<dim> middle = Vec<dim>::Zero();
	double spread = 0;

	/// No vector is longer.
	double largestNorm() const { return middle.norm() + spread; }
};

/// The middle is that of the box of the vectors; there is at least one.
template <int dim> VectorRange<dim> rangeOf(const std::vector<Vec<dim>>& vectors)
{
	const Vec<dim> middle = boxOf(vectors).centre();
	return { middle, farthestFrom<dim>(middle, vectors) };
}
/// The same of the ways from vectors to their counterparts.
template <int dim>
VectorRange<dim> rangeOfWays(const std::vector<Vec<dim>>& from, const std::vector<Vec<dim>>& to);

} // namespace softgrain
