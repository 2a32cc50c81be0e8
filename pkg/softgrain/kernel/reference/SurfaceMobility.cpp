#include "reference/SurfaceMobility.hpp"

#include <algorithm>

namespace softgrain {

namespace {

double entry(const SparseRows<double>& table, int row, int column)
{
	for (int k = table.begin(row); k < table.end(row); ++k)
		if (table.column[k] == column) return table.value[k];
	return 0;
}

std::vector<double> diagonal(const SparseRows<double>& table)
{
	std::vector<double> own;
	for (int s = 0; s < table.rows(); ++s)
		own.push_back(entry(table, s, s));
	return own;
}

template <std::size_t n>
std::array<std::array<double, n>, n> block(const SparseRows<double>& table,
					   const std::array<int, n>& node)
{
	std::array<std::array<double, n>, n> W;
	for (std::size_t i = 0; i < n; ++i)
		for (std::size_t j = 0; j < n; ++j)
			W[i][j] = entry(table, node[i], node[j]);
	return W;
}

/// Columns of the rows of some nodes, each once, in ascending order.
template <class Nodes>
std::vector<int> commonColumns(const SparseRows<double>& table, const Nodes& nodes)
{
	std::vector<int> columns;
	for (int node : nodes)
		columns.insert(columns.end(), table.column.begin() + table.begin(node),
			       table.column.begin() + table.end(node));
	std::sort(columns.begin(), columns.end());
	columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
	return columns;
}

/// Blocks of a ring side by side.
struct Arc {
	int begin, length;
};

/// The shortest that holds all of these blocks (in ascending order): it begins behind the widest
/// gap.
Arc arcAround(const std::vector<int>& block, int blocks)
{
	int widest = 0, begin = 0;
	for (std::size_t k = 0; k < block.size(); ++k) {
		const int before = k > 0 ? block[k - 1] : block.back() - blocks;
		if (block[k] - before <= widest) continue;
		widest = block[k] - before;
		begin = block[k];
	}
	return { begin, blocks - widest + 1 };
}

} // namespace

OutlineMobility::OutlineMobility(const OutlineMesh<2>& mesh, const SparseRows<double>& delassus)
	: blocks_((delassus.rows() + nodesPerBlock - 1) / nodesPerBlock)
	, ownOfNode_(diagonal(delassus))
{
	const int nodes = delassus.rows();
	std::vector<std::array<int, carriers>> carrier;
	int longest = 0;
	auto place = [&](const auto& of, std::vector<int>& begin) {
		std::vector<int> met = commonColumns(delassus, of);
		for (int& column : met)
			column /= nodesPerBlock;
		const Arc arc = arcAround(met, blocks_);
		begin.push_back(arc.begin);
		longest = std::max(longest, arc.length);
	};
	for (int s = 0; s < nodes; ++s)
		place(std::array<int, 1> { s }, beginOfNode_);
	for (std::size_t f = 0; f < mesh.facet.size(); ++f) {
		carrier.push_back(mesh.carriers(static_cast<int>(f)));
		ownOfFacet_.push_back(block(delassus, carrier.back()));
		place(carrier.back(), beginOfFacet_);
	}
	width_ = longest;

	// Of the k-th block of a row; places without a node are zero.
	auto entries = [&](int node, int begin, int k) {
		BlockWeights W;
		for (int i = 0; i < nodesPerBlock; ++i) {
			const int column = (begin + k) % blocks_ * nodesPerBlock + i;
			if (column < nodes) W.of[i] = entry(delassus, node, column);
		}
		return W;
	};
	for (int s = 0; s < nodes; ++s)
		for (int k = 0; k < width_; ++k)
			rowOfNode_.push_back(entries(s, beginOfNode_[s], k));
	for (std::size_t f = 0; f < carrier.size(); ++f)
		for (int k = 0; k < width_; ++k)
			for (int node : carrier[f])
				rowOfFacet_.push_back(entries(node, beginOfFacet_[f], k));
}

FacetMobility::FacetMobility(const OutlineMesh<3>& mesh, const SparseRows<double>& delassus)
	: segments_(static_cast<int>(segmentsOf(delassus.rows())))
	, weights_(blocksPerSegment)
	, ownOfNode_(diagonal(delassus))
{
	for (int s = 0; s < delassus.rows(); ++s) {
		Stretch* row = &*stretch_.insert(stretch_.end(), segments_, Stretch {});
		for (int k = delassus.begin(s); k < delassus.end(s); ++k) {
			const int column = delassus.column[k], place = column % nodesPerSegment;
			Stretch& stretch = row[column / nodesPerSegment];
			if (stretch.blocks == 0) {
				stretch.begin = static_cast<int>(weights_.size());
				weights_.resize(weights_.size() + blocksPerSegment);
			}
			stretch.blocks |= blockOf(column);
			weights_[stretch.begin + place / nodesPerBlock].of[place % nodesPerBlock] =
				delassus.value[k];
		}
	}
	for (std::size_t f = 0; f < mesh.facet.size(); ++f) {
		carriersOfFacet_.push_back(mesh.carriers(static_cast<int>(f)));
		ownOfFacet_.push_back(block(delassus, carriersOfFacet_.back()));
	}
}

int FacetMobility::padding() const
{
	const int nodes = static_cast<int>(ownOfNode_.size());
	return (nodesPerBlock - nodes % nodesPerBlock) % nodesPerBlock;
}

} // namespace softgrain
