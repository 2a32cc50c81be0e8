#include "contact/CommonGrid.hpp"

#include <cmath>
#include <map>

namespace softgrain {

template <int dim> int GridNode<dim>::name() const
{
	constexpr int bits = 30 / dim;
	int packed = 0;
	for (int a = 0; a < dim; ++a)
		packed = (packed << bits) | (index[a] & ((1 << bits) - 1));
	return packed;
}

namespace {

/// Adds a point to the 2^dim nodes about it.
template <int dim>
void addPoint(int p, const Vec<dim>& x, double mass, double spacing,
	      std::map<std::array<int, dim>, GridNode<dim>>& nodes)
{
	std::array<int, dim> cell;
	Vec<dim> local; // in [0, 1)
	for (int a = 0; a < dim; ++a) {
		const double place = x[a] / spacing;
		cell[a] = static_cast<int>(std::floor(place));
		local[a] = place - cell[a];
	}
	for (int corner = 0; corner < (1 << dim); ++corner) {
		std::array<int, dim> index = cell;
		double N = 1;
		Vec<dim> gradient = Vec<dim>::Constant(1 / spacing);
		for (int a = 0; a < dim; ++a) {
			const bool upper = corner >> a & 1;
			const double value = upper ? local[a] : 1 - local[a];
			index[a] += upper;
			N *= value;
			for (int b = 0; b < dim; ++b)
				gradient[b] *= a == b ? (upper ? 1. : -1.) : value;
		}
		if (N == 0) continue;
		GridNode<dim>& node = nodes[index];
		node.index = index;
		node.mass += mass * N;
		node.gradient += mass * gradient;
		node.centre += mass * N * x;
		node.share.emplace_back(p, mass * N);
	}
}

} // namespace

template <int dim>
std::vector<GridNode<dim>> nodesOnGrid(const GridPoints<dim>& points, double spacing)
{
	std::map<std::array<int, dim>, GridNode<dim>> nodes;
	for (std::size_t p = 0; p < points.position.size(); ++p)
		addPoint<dim>(static_cast<int>(p), points.position[p], points.mass[p], spacing,
			      nodes);
	std::vector<GridNode<dim>> sorted;
	for (auto& [index, node] : nodes) {
		node.centre /= node.mass;
		for (auto& [point, share] : node.share)
			share /= node.mass;
		sorted.push_back(std::move(node));
	}
	return sorted;
}

template <int dim>
SparseRows<double> pointShares(const std::vector<GridNode<dim>>& nodes,
			       const std::vector<char>& used)
{
	SparseRows<double> rows;
	for (std::size_t J = 0; J < nodes.size(); ++J) {
		if (used[J])
			for (const auto& [p, share] : nodes[J].share)
				rows.append(p, share);
		rows.closeRow();
	}
	return rows;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template struct GridNode<dim>;                                                             \
	template std::vector<GridNode<dim>> nodesOnGrid<dim>(const GridPoints<dim>&, double);      \
	template SparseRows<double> pointShares<dim>(const std::vector<GridNode<dim>>&,            \
						     const std::vector<char>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
