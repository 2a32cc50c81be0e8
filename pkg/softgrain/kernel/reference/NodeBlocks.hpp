// Nodes in *blocks* of four side by side: sums over their vectors, and what is computed with a
// weight for each node, four numbers at a time.
#pragma once

#include "Vector.hpp"
#include "material/FourNumbers.hpp"

#include <cstdint>
#include <vector>

namespace softgrain {

constexpr int nodesPerBlock = 4, numbersPerBlock = 2 * nodesPerBlock;

/// The same in space.
constexpr int numbersPerSpaceBlock = 3 * nodesPerBlock;

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

/// v += w J of the four nodes of a block in space, of which `first` is the first number.
struct BlockPush {
	FourNumbers xyzx, yzxy, zxyz; ///< components of J, as they follow one another

	explicit BlockPush(const Vec<3>& J)
		: xyzx { J[0], J[1], J[2], J[0] }
		, yzxy { J[1], J[2], J[0], J[1] }
		, zxyz { J[2], J[0], J[1], J[2] }
	{
	}
	void operator()(double* first, const FourNumbers& weights) const
	{
		const FourNumbers low = __builtin_shuffle(weights, FourPlaces { 0, 0, 0, 1 });
		const FourNumbers middle = __builtin_shuffle(weights, FourPlaces { 1, 1, 2, 2 });
		const FourNumbers high = __builtin_shuffle(weights, FourPlaces { 2, 3, 3, 3 });
		fourAt(first) += low * xyzx;
		fourAt(first + nodesPerBlock) += middle * yzxy;
		fourAt(first + 2 * nodesPerBlock) += high * zxyz;
	}
};

/// Calls with each block of a segment that is in the set, by its number.
template <class Set, class Visit> void forEachBlock(Set blocks, Visit&& visit)
{
	for (unsigned left = blocks; left != 0; left &= left - 1)
		visit(__builtin_ctz(left));
}

/// Some of the blocks of a body's nodes, by segments of `perSegment`.
class MarkedBlocks {
public:
	using Segment = std::uint16_t; ///< a set: a bit for each of its blocks
	static constexpr int perSegment = 16, nodesPerSegment = perSegment * nodesPerBlock;

	static std::size_t segmentsOf(std::size_t nodes)
	{
		return (nodes + nodesPerSegment - 1) / nodesPerSegment;
	}

	void clear(std::size_t nodes) { marks_.assign(segmentsOf(nodes), 0); }
	void mark(int node) { marks_[node / nodesPerSegment] |= blockOf(node); }
	/// The set of the block of a node alone.
	static Segment blockOf(int node)
	{
		return static_cast<Segment>(1 << node % nodesPerSegment / nodesPerBlock);
	}
	Segment of(int segment) const { return marks_[segment]; }

private:
	std::vector<Segment> marks_;
};

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
