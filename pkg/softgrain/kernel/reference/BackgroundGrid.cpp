#include "reference/BackgroundGrid.hpp"
#include "reference/BSpline.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

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
std::vector<std::pair<typename BackgroundGrid<dim>::Index, ShapeFunction<dim>>>
BackgroundGrid<dim>::shapesWithTied(const Vec<dim>& X) const
{
	std::array<SplineStencil, dim> axis;
	for (int a = 0; a < dim; ++a)
		axis[a] = splineStencil(order_, X[a] / spacing_[a]);
	const int width = order_ + 1;
	const int count = static_cast<int>(std::lround(std::pow(width, dim)));
	std::vector<std::pair<Index, ShapeFunction<dim>>> shapes;
	shapes.reserve(count);
	for (int k = 0; k < count; ++k) {
		Index index;
		std::array<int, dim> local;
		for (int a = dim - 1, rest = k; a >= 0; --a, rest /= width) {
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
		if (shape.N > 0 || !shape.G.isZero(0)) shapes.emplace_back(index, shape);
	}
	return shapes;
}

template <int dim>
typename BackgroundGrid<dim>::NodesAbout BackgroundGrid<dim>::nodesWithin(int steps,
									  const Index& index) const
{
	NodesAbout found;
	const int width = 2 * steps + 1;
	const int count = static_cast<int>(std::lround(std::pow(width, dim)));
	for (int k = 0; k < count; ++k) {
		Index other = index;
		int squared = 0;
		for (int a = 0, rest = k; a < dim; ++a, rest /= width) {
			const int away = rest % width - steps;
			other[a] += away;
			squared += away * away;
		}
		if (squared > steps * steps) continue;
		const auto node = number_.find(other);
		if (node != number_.end()) found.emplace_back(squared, node->second);
	}
	std::sort(found.begin(), found.end());
	return found;
}

template <int dim>
typename BackgroundGrid<dim>::NodesAbout BackgroundGrid<dim>::nearestNodes(const Index& index,
									   std::size_t count) const
{
	NodesAbout nearest;
	for (int steps = 2; nearest.size() < count; ++steps)
		nearest = nodesWithin(steps, index);
	const int last = nearest[count - 1].first;
	nearest.erase(std::find_if(nearest.begin(), nearest.end(),
				   [last](const auto& node) { return node.first > last; }),
		      nearest.end());
	return nearest;
}

template <int dim>
std::optional<typename BackgroundGrid<dim>::Weights>
BackgroundGrid<dim>::affineWeights(const Index& index, const NodesAbout& nodes) const
{
	const Vec<dim> X = nodeAt(index);
	const int count = static_cast<int>(nodes.size());
	Eigen::Matrix<double, dim + 1, Eigen::Dynamic> affine(dim + 1, count);
	Eigen::VectorXd trust(count); // nearer nodes carry more
	for (int k = 0; k < count; ++k) {
		affine(0, k) = 1;
		affine.template block<dim, 1>(1, k) =
			(position_[nodes[k].second] - X).cwiseQuotient(spacing_);
		trust[k] = std::pow(nodes[k].first, -2);
	}
	Eigen::Matrix<double, dim + 1, 1> target = Eigen::Matrix<double, dim + 1, 1>::Unit(0);
	const Eigen::MatrixXd scaled = affine * trust.asDiagonal();
	const auto gram = (scaled * affine.transpose()).eval().ldlt();
	constexpr double rounding = 1e-9;
	if (!(gram.vectorD().minCoeff() > rounding * gram.vectorD().maxCoeff()))
		return std::nullopt;
	const Eigen::VectorXd weight = trust.asDiagonal() * affine.transpose() * gram.solve(target);
	Weights result;
	for (int k = 0; k < count; ++k)
		result.emplace_back(nodes[k].second, weight[k]);
	return result;
}

/// As many nodes as an affine function needs and more, and all at the last distance: or the weights
/// would lack the symmetry of the grid. In a thin arm, where these lie in a row, more.
template <int dim>
typename BackgroundGrid<dim>::Weights BackgroundGrid<dim>::extrapolation(const Index& index) const
{
	const auto known = tied_.find(index);
	if (known != tied_.end()) return known->second;

	const std::size_t all = number_.size();
	for (std::size_t count = std::min<std::size_t>(dim == 2 ? 6 : 11, all);;
	     count = std::min(2 * count, all)) {
		const auto weights = affineWeights(index, nearestNodes(index, count));
		if (weights) return tied_[index] = *weights;
		if (count == all)
			throw std::invalid_argument("zeta is too large for the outline: all "
						    "background nodes lie in a row; admissible: "
						    "such that it is some dr wide somewhere");
	}
}

template <int dim>
void BackgroundGrid<dim>::appendShapes(const Vec<dim>& X,
				       SparseRows<ShapeFunction<dim>>& rows) const
{
	std::vector<std::pair<int, ShapeFunction<dim>>>
		parts; // several of a node that others follow
	for (const auto& [index, shape] : shapesWithTied(X)) {
		const auto carried = number_.find(index);
		if (carried != number_.end())
			parts.emplace_back(carried->second, shape);
		else
			for (const auto& [node, weight] : extrapolation(index))
				parts.push_back({ node, { weight * shape.N, weight * shape.G } });
	}
	std::stable_sort(parts.begin(), parts.end(),
			 [](const auto& a, const auto& b) { return a.first < b.first; });
	for (std::size_t k = 0; k < parts.size();) {
		const int node = parts[k].first;
		ShapeFunction<dim> sum { 0, Vec<dim>::Zero() };
		for (; k < parts.size() && parts[k].first == node; ++k) {
			sum.N += parts[k].second.N;
			sum.G += parts[k].second.G;
		}
		rows.append(node, sum);
	}
	rows.closeRow();
}

template class BackgroundGrid<2>;
template class BackgroundGrid<3>;

} // namespace softgrain
