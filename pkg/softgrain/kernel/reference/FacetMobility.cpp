#include "reference/FacetMobility.hpp"

#include <algorithm>

namespace softgrain {

namespace {

double entry(const SparseRows<double>& table, int row, int column)
{
	for (int k = table.begin(row); k < table.end(row); ++k)
		if (table.column[k] == column) return table.value[k];
	return 0;
}

} // namespace

template <int dim>
FacetMobility<dim>::FacetMobility(const OutlineMesh<dim>& mesh, const SparseRows<double>& delassus)
{
	for (std::size_t f = 0; f < mesh.facet.size(); ++f) {
		const auto carrier = mesh.carriers(static_cast<int>(f));
		std::vector<int> columns;
		for (int node : carrier)
			columns.insert(columns.end(),
				       delassus.column.begin() + delassus.begin(node),
				       delassus.column.begin() + delassus.end(node));
		std::sort(columns.begin(), columns.end());
		columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
		for (int node : carrier)
			for (int column : columns)
				value_.push_back(entry(delassus, node, column));
		place_.emplace_back();
		for (int i = 0; i < carriers; ++i)
			place_.back()[i] = static_cast<int>(
				std::find(columns.begin(), columns.end(), carrier[i]) -
				columns.begin());
		column_.insert(column_.end(), columns.begin(), columns.end());
		offset_.push_back(static_cast<int>(column_.size()));
		mostColumns_ = std::max(mostColumns_, static_cast<int>(columns.size()));
	}
}

template <int dim>
double FacetMobility<dim>::combine(int facet, const std::array<double, mostPartners<dim>>& share,
				   double* row) const
{
	const int count = columns(facet);
	const double* value = value_.data() + carriers * offset_[facet];
	std::fill_n(row, count, 0.);
	for (int i = 0; i < carriers; ++i, value += count)
		for (int k = 0; k < count; ++k)
			row[k] += share[i] * value[k];
	double own = 0;
	for (int i = 0; i < carriers; ++i)
		own += share[i] * row[place_[facet][i]];
	return own;
}

template class FacetMobility<2>;
template class FacetMobility<3>;

} // namespace softgrain
