#include "reference/NodeRows.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace softgrain {

template <int dim> NodeRows<dim>::NodeRows(const SparseRows<double>& rows, int nodes)
{
	if (nodes < nodesPerBlock)
		throw std::invalid_argument("a grain needs four background nodes at least");
	for (int row = 0; row < rows.rows(); ++row) {
		std::vector<std::pair<int, double>> entries; // node, weight
		for (int k = rows.begin(row); k < rows.end(row); ++k)
			entries.emplace_back(rows.column[k], rows.value[k]);
		std::sort(entries.begin(), entries.end());
		int end = 0; // node behind the last block of the row
		for (const auto& [node, weight] : entries) {
			if (node >= end) {
				const int first = std::min(node, nodes - nodesPerBlock);
				block_.push_back({ {}, first });
				end = first + nodesPerBlock;
			}
			Block& block = block_.back();
			block.weight.of[node - block.node] += weight;
		}
		begin_.push_back(static_cast<int>(block_.size()));
	}
}

template class NodeRows<2>;
template class NodeRows<3>;

} // namespace softgrain
