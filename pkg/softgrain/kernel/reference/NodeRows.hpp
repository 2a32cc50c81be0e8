// Rows of a table over the background nodes, laid out for nodal fields of one grain: sums over the
// nodes of a row, and what is spread over them. Nodes of a row of the grid follow one another, so
// that the nodes of a stencil are some blocks.
#pragma once

#include "lanes/NodeBlocks.hpp"
#include "reference/SparseRows.hpp"

namespace softgrain {

template <int dim> class NodeRows {
public:
	NodeRows() = default;
	/// Of a grain of so many nodes, at least four.
	NodeRows(const SparseRows<double>& rows, int nodes);

	int rows() const { return static_cast<int>(begin_.size()) - 1; }
	/// sum_I w_I f_I
	Vec<dim> sum(int row, const Vec<dim>* field) const;
	/// f_I += w_I J
	void spread(int row, const Vec<dim>& J, Vec<dim>* field) const;

private:
	struct Block {
		BlockWeights weight;
		int node; ///< first one
	};

	std::vector<int> begin_ { 0 }; ///< of the blocks of each row
	std::vector<Block> block_;
};

// --- inline, since it is called for every contact node and step ----------------------------------

template <int dim> Vec<dim> NodeRows<dim>::sum(int row, const Vec<dim>* field) const
{
	BlockSum<dim> sum;
	for (int k = begin_[row]; k < begin_[row + 1]; ++k)
		sum.add(field[block_[k].node].data(), block_[k].weight.all());
	return sum.value();
}

template <int dim> void NodeRows<dim>::spread(int row, const Vec<dim>& J, Vec<dim>* field) const
{
	const BlockPush<dim> push(J);
	for (int k = begin_[row]; k < begin_[row + 1]; ++k)
		push(field[block_[k].node].data(), block_[k].weight.all());
}

} // namespace softgrain
