// Nodes in *blocks* of four side by side: sums over their vectors, and what is computed with a
// weight for each node, four numbers at a time.
#pragma once

#include "Vector.hpp"
#include "lanes/Parts.hpp"

#include <cstdint>
#include <vector>

namespace softgrain {

constexpr int nodesPerBlock = 4;

/// From the k-th of `count` numbers on; zero behind their end.
inline FourNumbers fourOf(const double* numbers, int k, int count)
{
	return numbersFrom<HalfLanes>(numbers, k, count);
}

/// Of the vectors of a block.
template <int dim> constexpr int numbersPerBlock = dim * nodesPerBlock;

/// Of the nodes of a block.
struct BlockWeights {
	double of[nodesPerBlock] = {};

	const FourNumbers& all() const { return fourAt(of); }
};

/// Calls `use(k, weights of the numbers 4 k to 4 k + 3)` for the numbers of a block, which follow
/// one another component by component, node by node.
template <int dim, class Use> void forFourNumbers(const FourNumbers& weights, Use&& use)
{
	if constexpr (dim == 2) {
		use(0, FourNumbers(__builtin_shuffle(weights, FourPlaces { 0, 0, 1, 1 })));
		use(1, FourNumbers(__builtin_shuffle(weights, FourPlaces { 2, 2, 3, 3 })));
	} else {
		use(0, FourNumbers(__builtin_shuffle(weights, FourPlaces { 0, 0, 0, 1 })));
		use(1, FourNumbers(__builtin_shuffle(weights, FourPlaces { 1, 1, 2, 2 })));
		use(2, FourNumbers(__builtin_shuffle(weights, FourPlaces { 2, 3, 3, 3 })));
	}
}

/// f += w J of the four nodes of a block, of which `first` is the first number. J's components have
/// to stay in registers: written number by number and read four at a time they would go through
/// memory, and the first block wait for them.
template <int dim> class BlockPush;

template <> class BlockPush<2> {
public:
	explicit BlockPush(const Vec<2>& J)
		: repeated_(repeat(J))
	{
	}
	void operator()(double* first, const FourNumbers& weights) const
	{
		forFourNumbers<2>(weights, [&](int k, const FourNumbers& w) {
			fourAt(first + 4 * k) += w * repeated_;
		});
	}

private:
	static FourNumbers repeat(const Vec<2>& J)
	{
		const FourNumbers four { J[0], J[1], J[0], J[1] };
		return four;
	}

	const FourNumbers repeated_;
};

template <> class BlockPush<3> {
public:
	explicit BlockPush(const Vec<3>& J)
		: J_(J)
	{
	}
	void operator()(double* first, const FourNumbers& weights) const
	{
		forFourNumbers<3>(weights, [&](int k, const FourNumbers& w) {
			fourAt(first + 4 * k) += w * components(k);
		});
	}

private:
	/// Of J, those that go with the k-th four numbers.
	FourNumbers components(int k) const
	{
		return FourNumbers { J_[k], J_[(k + 1) % 3], J_[(k + 2) % 3], J_[k] };
	}

	const Vec<3>& J_;
};

/// sum of w f over the nodes of blocks.
template <int dim> class BlockSum {
public:
	void add(const double* first, const FourNumbers& weights)
	{
		forFourNumbers<dim>(weights, [&](int k, const FourNumbers& w) {
			sum_[k] += w * fourAt(first + 4 * k);
		});
	}
	/// The block from the k-th of `count` vectors on, as far as there are.
	void add(const Vec<dim>* vectors, int k, int count, const FourNumbers& weights)
	{
		forFourNumbers<dim>(weights, [&](int i, const FourNumbers& w) {
			sum_[i] += w * fourOf(vectors->data(), dim * k + 4 * i, dim * count);
		});
	}
	Vec<dim> value() const;

private:
	FourNumbers sum_[dim] = {};
};

template <> inline Vec<2> BlockSum<2>::value() const
{
	const FourNumbers xyxy = sum_[0] + sum_[1];
	return { xyxy[0] + xyxy[2], xyxy[1] + xyxy[3] };
}
template <> inline Vec<3> BlockSum<3>::value() const
{
	const auto& [xyzx, yzxy, zxyz] = sum_;
	return { (xyzx[0] + xyzx[3]) + (yzxy[2] + zxyz[1]),
		 (xyzx[1] + yzxy[0]) + (yzxy[3] + zxyz[2]),
		 (xyzx[2] + yzxy[1]) + (zxyz[0] + zxyz[3]) };
}

/// Of the 16 blocks of a *segment* of nodes, some: a bit for each.
using BlockSet = std::uint16_t;
constexpr int blocksPerSegment = 16, nodesPerSegment = blocksPerSegment * nodesPerBlock;

inline std::size_t segmentsOf(std::size_t nodes)
{
	return (nodes + nodesPerSegment - 1) / nodesPerSegment;
}
/// The block of a node, alone.
inline BlockSet blockOf(int node)
{
	return static_cast<BlockSet>(1 << node % nodesPerSegment / nodesPerBlock);
}
/// Calls with the number of each block of the set.
template <class Set, class Visit> void forEachBlock(Set blocks, Visit&& visit)
{
	for (unsigned left = blocks; left != 0; left &= left - 1)
		visit(__builtin_ctz(left));
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
