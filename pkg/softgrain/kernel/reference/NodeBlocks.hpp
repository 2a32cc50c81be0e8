// Nodes of the plane in *blocks* of four side by side: sums over their vectors, and what is
// computed with a weight for each node, two nodes (FourNumbers) at a time.
#pragma once

#include "Vector.hpp"
#include "material/FourNumbers.hpp"

namespace softgrain {

constexpr int nodesPerBlock = 4, numbersPerBlock = 2 * nodesPerBlock;

/// Of the nodes of a block.
struct BlockWeights {
	double of[nodesPerBlock] = {};

	const FourNumbers& all() const { return fourAt(of); }
};

/// Calls `use(place of the first number of two nodes in their block, their weights by component)`.
template <class Use> void forTwoNodes(const FourNumbers& weights, Use&& use)
{
	use(0, FourNumbers(__builtin_shuffle(weights, FourPlaces { 0, 0, 1, 1 })));
	use(nodesPerBlock, FourNumbers(__builtin_shuffle(weights, FourPlaces { 2, 2, 3, 3 })));
}

/// Vectors of the nodes of a block, component by component, or four sums of vectors.
struct BlockVectors {
	FourNumbers x = {}, y = {};

	BlockVectors less(const Vec<2>& v) const { return { x - v[0], y - v[1] }; }
	FourNumbers dot(const BlockVectors& v) const { return x * v.x + y * v.y; }
	FourNumbers cross(const BlockVectors& v) const { return x * v.y - y * v.x; }
	void add(const FourNumbers& m, const BlockVectors& v)
	{
		x += m * v.x;
		y += m * v.y;
	}
	Vec<2> sum() const { return { sumOf(x), sumOf(y) }; }
};

/// From the k-th of `count` vectors on; zero behind their end.
inline BlockVectors vectorsOf(const Vec<2>* vectors, int k, int count)
{
	const double* numbers = vectors[0].data();
	const FourNumbers low = fourOf(numbers, 2 * k, 2 * count),
			  high = fourOf(numbers, 2 * k + nodesPerBlock, 2 * count);
	return { __builtin_shuffle(low, high, FourPlaces { 0, 2, 4, 6 }),
		 __builtin_shuffle(low, high, FourPlaces { 1, 3, 5, 7 }) };
}

} // namespace softgrain
