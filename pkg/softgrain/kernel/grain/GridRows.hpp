// How a point meets the nodes of a grid: rows of nodes that lie side by side in memory, taken as
// whole.
#pragma once

#include "grain/SpatialGrid.hpp"
#include "reference/BSpline.hpp"

#include <vector>

namespace softgrain {

/// Factors of one point: for each axis values, then gradients.
template <int dim> constexpr int factorCount = 2 * dim * rowWidth;

template <int order, int dim>
constexpr int rowCount = dim == 2 ? order + 1 : (order + 1) * (order + 1);

/// The rows of nodes that a point sees, and its shape functions across the rows: N without the
/// factor of the last axis, and the gradients of that along the other axes.
template <int dim, int order> struct GridRows {
	static constexpr int count = rowCount<order, dim>;
	int node[count];
	double N[count];
	double G[dim - 1][count];
	const double* along;         ///< values of the last axis
	const double* gradientAlong; ///< its gradients

	GridRows(const SpatialGrid<dim>& grid, int first, const double* factors)
		: along(factors + 2 * (dim - 1) * rowWidth)
		, gradientAlong(along + rowWidth)
	{
		if constexpr (dim == 2)
			for (int i = 0; i < count; ++i) {
				node[i] = first + i * grid.stride(0);
				N[i] = factors[i];
				G[0][i] = factors[rowWidth + i];
			}
		else
			for (int i = 0, k = 0; i <= order; ++i)
				for (int j = 0; j <= order; ++j, ++k) {
					const double* other = factors + 2 * rowWidth;
					node[k] = first + i * grid.stride(0) + j * grid.stride(1);
					N[k] = factors[i] * other[j];
					G[0][k] = factors[rowWidth + i] * other[j];
					G[1][k] = factors[i] * other[rowWidth + j];
				}
	}
};

/// Value and gradient of one component of a nodal field at one point.
template <int dim, int order>
double gather(const std::vector<double>& field, const GridRows<dim, order>& rows, double* gradient)
{
	double across[rowWidth] = {}, slope[dim - 1][rowWidth] = {};
	for (int i = 0; i < rows.count; ++i) {
		const double* value = field.data() + rows.node[i];
		for (int c = 0; c < rowWidth; ++c) {
			across[c] += rows.N[i] * value[c];
			for (int b = 0; b < dim - 1; ++b)
				slope[b][c] += rows.G[b][i] * value[c];
		}
	}
	double sum = 0;
	for (int b = 0; b < dim; ++b)
		gradient[b] = 0;
	for (int c = 0; c < rowWidth; ++c) {
		sum += rows.along[c] * across[c];
		gradient[dim - 1] += rows.gradientAlong[c] * across[c];
		for (int b = 0; b < dim - 1; ++b)
			gradient[b] += rows.along[c] * slope[b][c];
	}
	return sum;
}

/// The value alone.
template <int dim, int order>
double gather(const std::vector<double>& field, const GridRows<dim, order>& rows)
{
	double across[rowWidth] = {};
	for (int i = 0; i < rows.count; ++i) {
		const double* value = field.data() + rows.node[i];
		for (int c = 0; c < rowWidth; ++c)
			across[c] += rows.N[i] * value[c];
	}
	double sum = 0;
	for (int c = 0; c < rowWidth; ++c)
		sum += rows.along[c] * across[c];
	return sum;
}

} // namespace softgrain
