// What an impulse on a place over a facet does to the contact nodes of its grain.
#pragma once

#include "reference/Outline.hpp"
#include "reference/SparseRows.hpp"

namespace softgrain {

/// The rows of W of the nodes that carry a facet, on their common columns: an impulse that these
/// nodes bear with shares w_i moves node column[k] by sum_i w_i value[i][k].
template <int dim> class FacetMobility {
public:
	FacetMobility() = default;
	FacetMobility(const OutlineMesh<dim>& mesh, const SparseRows<double>& delassus);

	int mostColumns() const { return mostColumns_; } ///< of a facet
	int columns(int facet) const { return offset_[facet + 1] - offset_[facet]; }
	/// Nodes that an impulse on the facet moves.
	const int* column(int facet) const { return column_.data() + offset_[facet]; }
	/// Fills `row` with the mobilities of these nodes; returns that of the place itself.
	double combine(int facet, const std::array<double, mostPartners<dim>>& share,
		       double* row) const;

private:
	static constexpr int carriers = mostPartners<dim>;
	int mostColumns_ = 0;
	std::vector<int> offset_ { 0 };
	std::vector<int> column_;
	std::vector<double> value_;                    ///< [carrier][column] of facet after facet
	std::vector<std::array<int, carriers>> place_; ///< of the carriers among the columns
};

} // namespace softgrain
