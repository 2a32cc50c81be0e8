// Rows of a table over the background nodes, laid out for nodal fields of one grain: sums over the
// nodes of a row, and what is spread over them.
#pragma once

#include "Vector.hpp"
#include "reference/NodeBlocks.hpp"
#include "reference/SparseRows.hpp"

#include <type_traits>

namespace softgrain {

/// 2D: nodes of a row of the grid follow one another, so that the nodes of a stencil are some
/// blocks.
class BlockRows {
public:
	BlockRows() = default;
	/// Of a grain of so many nodes, at least four.
	BlockRows(const SparseRows<double>& rows, int nodes);

	int rows() const { return static_cast<int>(begin_.size()) - 1; }
	/// sum_I w_I f_I
	Vec<2> sum(int row, const Vec<2>* field) const;
	/// f_I += w_I J
	void spread(int row, const Vec<2>& J, Vec<2>* field) const;

private:
	struct Block {
		BlockWeights weight;
		int node; ///< first one
	};

	std::vector<int> begin_ { 0 }; ///< of the blocks of each row
	std::vector<Block> block_;
};

/// 3D: node by node.
class PlainRows {
public:
	PlainRows() = default;
	PlainRows(SparseRows<double> rows, int /*nodes*/)
		: rows_(std::move(rows))
	{
	}
	int rows() const { return rows_.rows(); }
	Vec<3> sum(int row, const Vec<3>* field) const
	{
		Vec<3> sum = Vec<3>::Zero();
		for (int k = rows_.begin(row); k < rows_.end(row); ++k)
			addScaled<3>(sum, rows_.value[k], field[rows_.column[k]]);
		return sum;
	}
	void spread(int row, const Vec<3>& J, Vec<3>* field) const
	{
		for (int k = rows_.begin(row); k < rows_.end(row); ++k)
			addScaled<3>(field[rows_.column[k]], rows_.value[k], J);
	}

private:
	SparseRows<double> rows_;
};

template <int dim> using NodeRows = std::conditional_t<dim == 2, BlockRows, PlainRows>;

// --- inline, since it is called for every contact node and step ----------------------------------

inline Vec<2> BlockRows::sum(int row, const Vec<2>* field) const
{
	const double* f = field[0].data();
	FourNumbers sum[2] = {};
	for (int k = begin_[row]; k < begin_[row + 1]; ++k) {
		const Block& block = block_[k];
		forTwoNodes(block.weight.all(), [&](int place, const FourNumbers& weight) {
			sum[place / nodesPerBlock] += weight * fourAt(f + 2 * block.node + place);
		});
	}
	sum[0] += sum[1];
	return { sum[0][0] + sum[0][2], sum[0][1] + sum[0][3] };
}

inline void BlockRows::spread(int row, const Vec<2>& J, Vec<2>* field) const
{
	const FourNumbers both = { J[0], J[1], J[0], J[1] };
	double* f = field[0].data();
	for (int k = begin_[row]; k < begin_[row + 1]; ++k) {
		const Block& block = block_[k];
		forTwoNodes(block.weight.all(), [&](int place, const FourNumbers& weight) {
			fourAt(f + 2 * block.node + place) += weight * both;
		});
	}
}

} // namespace softgrain
