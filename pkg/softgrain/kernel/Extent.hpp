// What all vectors of a grain take part in: the box that holds them, the farthest of them, and all
// of them made unit vectors. In the plane four at a time (reference/NodeBlocks.hpp), with the bits
// of one by one.
#pragma once

#include "Vector.hpp"

#include <vector>

namespace softgrain {

/// Smallest and largest components of some vectors.
template <int dim> struct Extent {
	Vec<dim> low, high;

	Vec<dim> middle() const { return 0.5 * (low + high); }
};

/// Of one vector at least.
template <int dim> Extent<dim> extentOf(const std::vector<Vec<dim>>& vectors);

/// Largest distance of a vector from `centre`; there is one at least.
template <int dim>
double farthestFrom(const Vec<dim>& centre, const std::vector<Vec<dim>>& vectors);

/// Largest way from a vector to its counterpart, less that of all `together`.
template <int dim>
double farthestWay(const std::vector<Vec<dim>>& from, const std::vector<Vec<dim>>& to,
		   const Vec<dim>& together);

/// Zero stays.
template <int dim> void normalizeAll(std::vector<Vec<dim>>& vectors);

/// Velocities of some nodes: none differs from `middle` by more than `spread`, m/s.
template <int dim> struct VelocityRange {
	Vec<dim> middle = Vec<dim>::Zero();
	double spread = 0;

	double fastest() const { return middle.norm() + spread; }
};

/// The middle is that of the box of the vectors; there is at least one.
template <int dim> VelocityRange<dim> rangeOf(const std::vector<Vec<dim>>& vectors)
{
	const Vec<dim> middle = extentOf(vectors).middle();
	return { middle, farthestFrom<dim>(middle, vectors) };
}

} // namespace softgrain
