#include "reference/NodeRows.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace softgrain {

BlockRows::BlockRows(const SparseRows<double>& rows, int nodes)
{
	if (nodes < nodesPerBlock)
		throw std::invalid_argument("a grain needs four background nodes at least");
	for (int row = 0; row < rows.rows(); ++row) {
		std::vector<std::pair<int, double>> entries; // node, weight
		for (int k = rows.begin(row); k < rows.end(row); ++k)
			entries.emplace_back(rows.column[k], rows.value[k]);
		std::sort(entries.begin(), entries.end());
		int block = 0, end = 0; // of the row; node behind the last block
		for (const auto& [node, weight] : entries) {
			if (block == 0 || node >= end) {
				const int first = std::min(node, nodes - nodesPerBlock);
				if (block % 2 == 0)
					pair_.push_back(Pair { Lanes {}, { first, first } });
				pair_.back().node[block % 2] = first;
				end = first + nodesPerBlock;
				++block;
			}
			const int place = (block - 1) % 2;
			Pair& pair = pair_.back();
			pair.weight[place * nodesPerBlock + node - pair.node[place]] += weight;
		}
		begin_.push_back(static_cast<int>(pair_.size()));
	}
}

} // namespace softgrain
