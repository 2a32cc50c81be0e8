// What contact nodes of an updated-Lagrangian grain are to each other in this step.
#include "grain/GridRows.hpp"
#include "grain/UpdatedGrain.hpp"

#include <algorithm>

namespace softgrain {

namespace {

/// N_I(x_s) on carrying nodes: what a tied node has goes to those that it follows.
template <int dim, int order>
SparseRows<double> shapesOfContactNodes(const UpdatedGrain<dim>& grain)
{
	SparseRows<double> shapes;
	shapes.column.reserve(grain.contactX.size() * 2 * GridRows<dim, order>::count * rowWidth);
	shapes.value.reserve(shapes.column.capacity());
	std::vector<double> sum(grain.grid.nodes(), 0.);
	std::vector<char> met(grain.grid.nodes(), 0);
	std::vector<int> seen;
	auto add = [&](int node, double weight) {
		if (!met[node]) seen.push_back(node);
		met[node] = 1;
		sum[node] += weight;
	};
	for (std::size_t s = 0; s < grain.contactX.size(); ++s) {
		const auto rows = grain.contacts.template rows<dim, order>(grain.grid, s);
		for (int i = 0; i < rows.count; ++i)
			for (int c = 0; c <= order; ++c) {
				const int node = rows.node[i] + c;
				const double N = rows.N[i] * rows.along[c];
				const auto* tie = grain.grid.tieOf(node);
				if (!tie)
					add(node, N);
				else
					for (int k = tie->begin; k < tie->end; ++k)
						add(grain.grid.tiedTo()[k].node,
						    N * grain.grid.tiedTo()[k].weight);
			}
		for (int node : seen) {
			shapes.append(node, sum[node]);
			sum[node] = met[node] = 0;
		}
		shapes.closeRow();
		seen.clear();
	}
	return shapes;
}

/// Box about the nodes of a row, both ends included.
template <int dim> struct IndexBox {
	typename SpatialGrid<dim>::Index low, high;

	static IndexBox nowhere()
	{
		IndexBox box;
		box.low.fill(std::numeric_limits<int>::max());
		box.high.fill(std::numeric_limits<int>::min());
		return box;
	}
	bool overlaps(const IndexBox& other) const
	{
		bool together = true;
		for (int a = 0; a < dim; ++a)
			together = together && low[a] <= other.high[a] && other.low[a] <= high[a];
		return together;
	}
};

template <int dim>
std::vector<IndexBox<dim>> boxesOf(const SparseRows<double>& shapes, const SpatialGrid<dim>& grid)
{
	const auto index = grid.indices();
	std::vector<IndexBox<dim>> boxes;
	boxes.reserve(shapes.rows());
	for (int s = 0; s < shapes.rows(); ++s) {
		if (shapes.begin(s) == shapes.end(s)) { // hangs on nothing
			boxes.push_back(IndexBox<dim>::nowhere());
			continue;
		}
		const auto& first = index[shapes.column[shapes.begin(s)]];
		IndexBox<dim> box { first, first };
		for (int k = shapes.begin(s) + 1; k < shapes.end(s); ++k)
			for (int a = 0; a < dim; ++a) {
				const int i = index[shapes.column[k]][a];
				box.low[a] = std::min(box.low[a], i);
				box.high[a] = std::max(box.high[a], i);
			}
		boxes.push_back(box);
	}
	return boxes;
}

/// A symmetric table from its upper half; each row in ascending order.
struct SymmetricEntry {
	int row, column;
	double value;
};
SparseRows<double> symmetricTable(const std::vector<SymmetricEntry>& upper, int rows)
{
	SparseRows<double> table;
	table.offset.assign(rows + 1, 0);
	for (const SymmetricEntry& e : upper) {
		++table.offset[e.row + 1];
		if (e.column != e.row) ++table.offset[e.column + 1];
	}
	for (int r = 0; r < rows; ++r)
		table.offset[r + 1] += table.offset[r];
	table.column.resize(table.offset[rows]);
	table.value.resize(table.offset[rows]);
	std::vector<int> next = table.offset;
	auto put = [&](int row, int column, double value) {
		table.column[next[row]] = column;
		table.value[next[row]++] = value;
	};
	for (const SymmetricEntry& e : upper) { // rows ascend, so lower halves fill up in order
		put(e.row, e.column, e.value);
		if (e.column != e.row) put(e.column, e.row, e.value);
	}
	return table;
}

/// W_ss' = sum_I N_I(x_s) N_I(x_s')/m_I: each row spread over the grid, the others gathered from
/// it, by rows of nodes where they see no tied node.
template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS SparseRows<double> mobilityTable(const UpdatedGrain<dim>& grain)
{
	const SparseRows<double>& shapes = grain.contactShapes;
	const SpatialGrid<dim>& grid = grain.grid;
	const auto boxes = boxesOf(shapes, grid);
	std::vector<GridRows<dim, order>> stencils;
	stencils.reserve(shapes.rows());
	std::vector<char> tied(shapes.rows(), 0);
	for (int s = 0; s < shapes.rows(); ++s) {
		stencils.push_back(grain.contacts.template rows<dim, order>(grid, s));
		for (int i = 0; i < stencils[s].count; ++i)
			for (int c = 0; c <= order; ++c)
				tied[s] = tied[s] || grid.tieOf(stencils[s].node[i] + c);
	}
	std::vector<double> spread(grid.nodes(), 0.); // N_I(x_s)/m_I of the row in hand
	std::vector<SymmetricEntry> upper;
	upper.reserve(32 * shapes.rows());
	for (int s = 0; s < shapes.rows(); ++s) {
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			spread[shapes.column[k]] = shapes.value[k] / grid.mass[shapes.column[k]];
		for (int t = s; t < shapes.rows(); ++t) {
			if (!boxes[s].overlaps(boxes[t])) continue;
			double W = 0;
			if (!tied[t])
				W = gather(spread, stencils[t]);
			else
				for (int k = shapes.begin(t); k < shapes.end(t); ++k)
					W += shapes.value[k] * spread[shapes.column[k]];
			if (W != 0) upper.push_back({ s, t, W });
		}
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			spread[shapes.column[k]] = 0;
	}
	return symmetricTable(upper, shapes.rows());
}

} // namespace

template <int dim> void UpdatedGrain<dim>::findContactMobility(int order)
{
	withSmoothOrder(order, [&](auto smooth) {
		contactShapes = shapesOfContactNodes<dim, smooth>(*this);
		delassus = mobilityTable<dim, smooth>(*this);
	});
}

template void UpdatedGrain<2>::findContactMobility(int);
template void UpdatedGrain<3>::findContactMobility(int);

} // namespace softgrain
