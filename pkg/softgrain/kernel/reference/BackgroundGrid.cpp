#include "reference/BackgroundGrid.hpp"
#include "reference/BSpline.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace softgrain {

template <int dim>
BackgroundGrid<dim>::BackgroundGrid(int order, const Vec<dim>& spacing,
				    const Quadrature<dim>& quadrature, double tiedShare)
	: order_(order)
	, spacing_(spacing)
{
	std::map<Index, double> rawMass;
	for (std::size_t p = 0; p < quadrature.point.size(); ++p)
		for (const auto& [index, shape] : shapesWithTied(quadrature.point[p]))
			rawMass[index] += quadrature.weight[p] * shape.N;

	double heaviest = 0;
	for (const auto& [index, m] : rawMass)
		heaviest = std::max(heaviest, m);
	for (const auto& [index, m] : rawMass)
		if (m >= tiedShare * heaviest) {
			number_.emplace(index, static_cast<int>(position_.size()));
			position_.push_back(nodeAt(index));
		}

	mass_.assign(position_.size(), 0.);
	SparseRows<ShapeFunction<dim>> row;
	for (std::size_t p = 0; p < quadrature.point.size(); ++p) {
		row = {};
		appendShapes(quadrature.point[p], row);
		for (int k = row.begin(0); k < row.end(0); ++k)
			mass_[row.column[k]] += quadrature.weight[p] * row.value[k].N;
	}
}

template <int dim> Vec<dim> BackgroundGrid<dim>::nodeAt(const Index& index) const
{
	Vec<dim> X;
	for (int a = 0; a < dim; ++a)
		X[a] = index[a] * spacing_[a];
	return X;
}

template <int dim>
std::map<typename BackgroundGrid<dim>::Index, ShapeFunction<dim>>
BackgroundGrid<dim>::shapesWithTied(const Vec<dim>& X) const
{
	std::array<SplineStencil, dim> axis;
	for (int a = 0; a < dim; ++a)
		axis[a] = splineStencil(order_, X[a] / spacing_[a]);
	const int width = order_ + 1;
	const int count = static_cast<int>(std::lround(std::pow(width, dim)));
	std::map<Index, ShapeFunction<dim>> shapes;
	for (int k = 0; k < count; ++k) {
		Index index;
		std::array<int, dim> local;
		for (int a = 0, rest = k; a < dim; ++a, rest /= width) {
			local[a] = rest % width;
			index[a] = axis[a].first + local[a];
		}
		ShapeFunction<dim> shape { 1, spacing_.cwiseInverse() };
		for (int a = 0; a < dim; ++a) {
			shape.N *= axis[a].value[local[a]];
			for (int b = 0; b < dim; ++b)
				shape.G[b] *= a == b ? axis[a].gradient[local[a]]
						     : axis[a].value[local[a]];
		}
		if (shape.N > 0 || !shape.G.isZero(0)) shapes.emplace(index, shape);
	}
	return shapes;
}

/// Minimum-norm weights on the nearest nodes that reproduce affine functions at a tied node.
template <int dim>
typename BackgroundGrid<dim>::Weights BackgroundGrid<dim>::extrapolation(const Index& index) const
{
	const auto known = tied_.find(index);
	if (known != tied_.end()) return known->second;

	constexpr int neighbours = dim == 2 ? 6 : 11;
	const Vec<dim> X = nodeAt(index);
	std::vector<std::pair<int, int>> nearest; // squared distance in grid steps, node
	for (const auto& [other, node] : number_) {
		int squared = 0;
		for (int a = 0; a < dim; ++a)
			squared += (other[a] - index[a]) * (other[a] - index[a]);
		nearest.emplace_back(squared, node);
	}
	std::sort(nearest.begin(), nearest.end());
	int count = std::min<int>(neighbours, static_cast<int>(nearest.size()));
	while (count < static_cast<int>(nearest.size()) &&
	       nearest[count].first == nearest[count - 1].first)
		++count; // all nodes at the last distance, or the weights would lack the symmetry
			 // of the grid

	Eigen::Matrix<double, dim + 1, Eigen::Dynamic> affine(dim + 1, count);
	Eigen::VectorXd trust(count); // nearer nodes carry more
	for (int k = 0; k < count; ++k) {
		affine(0, k) = 1;
		affine.template block<dim, 1>(1, k) =
			(position_[nearest[k].second] - X).cwiseQuotient(spacing_);
		trust[k] = std::pow(nearest[k].first, -2);
	}
	Eigen::Matrix<double, dim + 1, 1> target = Eigen::Matrix<double, dim + 1, 1>::Unit(0);
	const Eigen::MatrixXd scaled = affine * trust.asDiagonal();
	const Eigen::VectorXd weight = trust.asDiagonal() * affine.transpose() *
				       (scaled * affine.transpose()).eval().ldlt().solve(target);
	Weights result;
	for (int k = 0; k < count; ++k)
		result.emplace_back(nearest[k].second, weight[k]);
	return tied_[index] = result;
}

template <int dim>
void BackgroundGrid<dim>::appendShapes(const Vec<dim>& X,
				       SparseRows<ShapeFunction<dim>>& rows) const
{
	std::map<int, ShapeFunction<dim>> resolved;
	auto add = [&](int node, double weight, const ShapeFunction<dim>& shape) {
		ShapeFunction<dim>& sum =
			resolved.try_emplace(node, ShapeFunction<dim> { 0, Vec<dim>::Zero() })
				.first->second;
		sum.N += weight * shape.N;
		sum.G += weight * shape.G;
	};
	for (const auto& [index, shape] : shapesWithTied(X)) {
		const auto carried = number_.find(index);
		if (carried != number_.end())
			add(carried->second, 1, shape);
		else
			for (const auto& [node, weight] : extrapolation(index))
				add(node, weight, shape);
	}
	for (const auto& [node, shape] : resolved)
		rows.append(node, shape);
	rows.closeRow();
}

template class BackgroundGrid<2>;
template class BackgroundGrid<3>;

} // namespace softgrain
