// W of the surface of a template, laid out for the sweeps: what an impulse on a contact node, or on
// a place over a facet, does to the velocities of the contact nodes.
#pragma once

#include "lanes/NodeBlocks.hpp"
#include "reference/Outline.hpp"
#include "reference/SparseRows.hpp"

#include <array>
#include <type_traits>

namespace softgrain {

/// 2D: nodes that feel each other follow one another along the outline, so that what an impulse
/// moves are some blocks side by side, the first block following the last one:
/// where the number of nodes is no multiple of four, velocities have room for those that are
/// missing in the last block (`padding`).
class OutlineMobility {
public:
	using Shares = std::array<double, mostPartners<2>>;

	OutlineMobility() = default;
	OutlineMobility(const OutlineMesh<2>& mesh, const SparseRows<double>& delassus);

	int padding() const
	{
		return blocks_ * nodesPerBlock - static_cast<int>(ownOfNode_.size());
	}
	double ofNode(int node) const { return ownOfNode_[node]; } ///< W_ss
	/// W of a place that the nodes of the facet bear with these shares.
	double ofPlace(int facet, const Shares& share) const;
	/// W of a node, and of such a place, with a node.
	double between(int node, int other) const;
	double between(int facet, const Shares& share, int other) const;
	/// v_s' += W_s's J.
	void push(Vec<2>* v, int node, const Vec<2>& J) const;
	void push(Vec<2>* v, int facet, const Shares& share, const Vec<2>& J) const;

private:
	static constexpr int carriers = mostPartners<2>;

	template <class Row> void pushRow(Vec<2>* v, int begin, const Vec<2>& J, Row&& row) const;
	/// Which block of a row that begins with block `begin` a node is in; it may be none.
	int blockInRow(int begin, int node) const
	{
		const int k = node / nodesPerBlock - begin;
		return k < 0 ? k + blocks_ : k;
	}

	int blocks_ = 0;                              ///< of the ring
	int width_ = 0;                               ///< of a row, in blocks
	std::vector<int> beginOfNode_, beginOfFacet_; ///< first block of the row
	std::vector<BlockWeights> rowOfNode_;         ///< [node][block]
	std::vector<BlockWeights> rowOfFacet_;        ///< [facet][block][carrier]
	std::vector<double> ownOfNode_;
	std::vector<std::array<std::array<double, carriers>, carriers>> ownOfFacet_;
};

/// 3D: an impulse moves most nodes of a ball, and sweeps ask for few of them. So rows are dense,
/// but for segments in which they are zero, and pushes move the nodes of marked blocks only, one
/// BlockSet for each segment: what the velocities of others are afterwards means nothing.
/// Velocities have room for whole blocks (`padding`).
class FacetMobility {
public:
	using Shares = std::array<double, mostPartners<3>>;

	FacetMobility() = default;
	FacetMobility(const OutlineMesh<3>& mesh, const SparseRows<double>& delassus);

	int padding() const;
	double ofNode(int node) const { return ownOfNode_[node]; }
	double ofPlace(int facet, const Shares& share) const;
	double between(int node, int other) const
	{
		const Stretch& row = stretch(node, other / nodesPerSegment);
		const int place = other % nodesPerSegment;
		return weights(row)[place / nodesPerBlock].of[place % nodesPerBlock];
	}
	double between(int facet, const Shares& share, int other) const
	{
		const auto& [a, b, c] = carriersOfFacet_[facet];
		return share[0] * between(a, other) + share[1] * between(b, other) +
		       share[2] * between(c, other);
	}
	void push(Vec<3>* v, const BlockSet* marked, int node, const Vec<3>& J) const;
	void push(Vec<3>* v, const BlockSet* marked, int facet, const Shares& share,
		  const Vec<3>& J) const;

private:
	static constexpr int carriers = mostPartners<3>;

	/// What a row has in a segment: the blocks in which it is not zero, and its weights there.
	struct Stretch {
		BlockSet blocks = 0;
		int begin = 0; ///< in `weights_`
	};
	const Stretch& stretch(int node, int segment) const
	{
		return stretch_[static_cast<std::size_t>(node) * segments_ + segment];
	}
	const BlockWeights* weights(const Stretch& stretch) const
	{
		return &weights_[stretch.begin];
	}

	int segments_ = 0;
	std::vector<Stretch> stretch_;      ///< [node][segment]
	std::vector<BlockWeights> weights_; ///< a segment of zeros, and those of the stretches
	std::vector<std::array<int, carriers>> carriersOfFacet_;
	std::vector<double> ownOfNode_;
	std::vector<std::array<std::array<double, carriers>, carriers>> ownOfFacet_;
};

template <int dim>
using SurfaceMobility = std::conditional_t<dim == 2, OutlineMobility, FacetMobility>;

// --- inline, since sweeps consist of it ----------------------------------------------------------

namespace detail {

/// sum_ij w_i w_j W_ij
template <std::size_t n>
double quadraticForm(const std::array<std::array<double, n>, n>& W, const std::array<double, n>& w)
{
	double sum = 0;
	for (std::size_t j = 0; j < n; ++j) {
		double row = 0;
		for (std::size_t i = 0; i < n; ++i)
			row += w[i] * W[i][j];
		sum += w[j] * row;
	}
	return sum;
}

} // namespace detail

inline double OutlineMobility::ofPlace(int facet, const Shares& share) const
{
	return detail::quadraticForm(ownOfFacet_[facet], share);
}

inline double FacetMobility::ofPlace(int facet, const Shares& share) const
{
	return detail::quadraticForm(ownOfFacet_[facet], share);
}

/// row(k) is the row of W at the k-th of its blocks. (Most rows do not meet the end of the ring,
/// and in these nothing is asked from block to block.)
template <class Row>
void OutlineMobility::pushRow(Vec<2>* v, int begin, const Vec<2>& J, Row&& row) const
{
	const BlockPush<2> add(J);
	const int blocks = blocks_, width = width_;
	double* ring = v[0].data();
	if (begin + width <= blocks)
		for (int k = 0; k < width; ++k)
			add(ring + (begin + k) * numbersPerBlock<2>, row(k));
	else
		for (int k = 0; k < width; ++k) {
			const int block = begin + k < blocks ? begin + k : begin + k - blocks;
			add(ring + block * numbersPerBlock<2>, row(k));
		}
}

inline double OutlineMobility::between(int node, int other) const
{
	const int k = blockInRow(beginOfNode_[node], other);
	return k < width_ ? rowOfNode_[node * width_ + k].of[other % nodesPerBlock] : 0;
}

inline double OutlineMobility::between(int facet, const Shares& share, int other) const
{
	const int k = blockInRow(beginOfFacet_[facet], other);
	if (k >= width_) return 0;
	const BlockWeights* W = &rowOfFacet_[(facet * width_ + k) * carriers];
	double sum = 0;
	for (int i = 0; i < carriers; ++i)
		sum += share[i] * W[i].of[other % nodesPerBlock];
	return sum;
}

inline void OutlineMobility::push(Vec<2>* v, int node, const Vec<2>& J) const
{
	const BlockWeights* W = &rowOfNode_[node * width_];
	pushRow(v, beginOfNode_[node], J, [W](int k) { return W[k].all(); });
}

inline void OutlineMobility::push(Vec<2>* v, int facet, const Shares& share, const Vec<2>& J) const
{
	const BlockWeights* W = &rowOfFacet_[facet * width_ * carriers];
	const double a = share[0], b = share[1], c = share[2], d = share[3]; // pushes change none
	pushRow(v, beginOfFacet_[facet], J, [=](int k) {
		const BlockWeights* of = W + k * carriers;
		return FourNumbers((a * of[0].all() + b * of[1].all()) +
				   (c * of[2].all() + d * of[3].all()));
	});
}

inline void FacetMobility::push(Vec<3>* v, const BlockSet* marked, int node, const Vec<3>& J) const
{
	const BlockPush<3> add(J);
	for (int s = 0; s < segments_; ++s) {
		const Stretch& row = stretch(node, s);
		const BlockWeights* W = weights(row);
		double* first = v[s * nodesPerSegment].data();
		forEachBlock(marked[s] & row.blocks,
			     [&](int k) { add(first + k * numbersPerBlock<3>, W[k].all()); });
	}
}

inline void FacetMobility::push(Vec<3>* v, const BlockSet* marked, int facet, const Shares& share,
				const Vec<3>& J) const
{
	const BlockPush<3> add(J);
	const auto& [a, b, c] = carriersOfFacet_[facet];
	for (int s = 0; s < segments_; ++s) {
		const Stretch &A = stretch(a, s), &B = stretch(b, s), &C = stretch(c, s);
		const BlockWeights *Wa = weights(A), *Wb = weights(B), *Wc = weights(C);
		double* first = v[s * nodesPerSegment].data();
		forEachBlock(marked[s] & (A.blocks | B.blocks | C.blocks), [&](int k) {
			add(first + k * numbersPerBlock<3>, share[0] * Wa[k].all() +
								    share[1] * Wb[k].all() +
								    share[2] * Wc[k].all());
		});
	}
}

} // namespace softgrain
