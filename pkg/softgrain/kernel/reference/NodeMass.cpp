#include "reference/NodeMass.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace softgrain {

namespace {

/// 1, X_a and X_a X_b with a <= b.
template <int dim> using Monomials = Eigen::Matrix<double, 1 + dim + dim*(dim + 1) / 2, 1>;

template <int dim> Monomials<dim> monomials(const Vec<dim>& X)
{
	Monomials<dim> value;
	value[0] = 1;
	value.template segment<dim>(1) = X;
	int k = 1 + dim;
	for (int a = 0; a < dim; ++a)
		for (int b = a; b < dim; ++b)
			value[k++] = X[a] * X[b];
	return value;
}

template <int dim>
Monomials<dim> momentsOf(const std::vector<Vec<dim>>& position, const std::vector<double>& mass)
{
	Monomials<dim> sum = Monomials<dim>::Zero();
	for (std::size_t k = 0; k < mass.size(); ++k)
		sum += mass[k] * monomials<dim>(position[k]);
	return sum;
}

/// Points taken as cubes (squares) of their volumes: X_a X_a has side^2/12 of its own.
template <int dim> Monomials<dim> momentsOfContinuum(const Quadrature<dim>& points)
{
	double own = 0;
	for (double V : points.weight)
		own += V * std::pow(V, 2. / dim) / 12;
	Monomials<dim> sum = momentsOf<dim>(points.point, points.weight);
	for (int a = 0, k = 1 + dim; a < dim; k += dim - a, ++a)
		sum[k] += own;
	return sum;
}

/// sum_J |sum_p V_p G_I(X_p).G_J(X_p)|
template <int dim>
std::vector<double> laplacianRowSums(int nodes, const std::vector<double>& volume,
				     const SparseRows<ShapeFunction<dim>>& shapes)
{
	std::vector<std::vector<std::pair<int, Vec<dim>>>> seenBy(nodes); // I: (p, V_p G_I)
	for (int p = 0; p < shapes.rows(); ++p)
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			seenBy[shapes.column[k]].emplace_back(p, volume[p] * shapes.value[k].G);

	std::vector<double> sums, row(nodes, 0.);
	for (const auto& places : seenBy) {
		for (const auto& [p, G] : places)
			for (int k = shapes.begin(p); k < shapes.end(p); ++k)
				row[shapes.column[k]] += G.dot(shapes.value[k].G);
		double sum = 0;
		for (const auto& [p, G] : places)
			for (int k = shapes.begin(p); k < shapes.end(p); ++k)
				sum += std::abs(std::exchange(row[shapes.column[k]], 0.));
		sums.push_back(sum);
	}
	return sums;
}

/// Weights times the quadratic polynomial with which they have these moments.
template <int dim>
std::vector<double> withMoments(std::vector<double> weight, const std::vector<Vec<dim>>& position,
				const Monomials<dim>& moments)
{
	constexpr int size = Monomials<dim>::RowsAtCompileTime;
	Eigen::Matrix<double, size, size> matrix = Eigen::Matrix<double, size, size>::Zero();
	for (std::size_t I = 0; I < weight.size(); ++I) {
		const Monomials<dim> value = monomials<dim>(position[I]);
		matrix += weight[I] * value * value.transpose();
	}
	// The few nodes of the coarsest grains may not tell all monomials apart.
	const Monomials<dim> coefficient = matrix.completeOrthogonalDecomposition().solve(moments);
	for (std::size_t I = 0; I < weight.size(); ++I)
		weight[I] *= coefficient.dot(monomials<dim>(position[I]));
	return weight;
}

bool areTooCoarse(const std::vector<double>& mass, const std::vector<double>& rowSums)
{
	for (std::size_t I = 0; I < mass.size(); ++I)
		if (!(mass[I] >= leastMassShare * rowSums[I])) return true;
	return false;
}

/// How far it is from one to the other until a node has lost `largestInertiaShare`; 1 at most.
double shareOfWay(const std::vector<double>& from, const std::vector<double>& to)
{
	double share = 1;
	for (std::size_t I = 0; I < from.size(); ++I) {
		const double loss = 1 - to[I] / from[I];
		if (loss > largestInertiaShare) share = std::min(share, largestInertiaShare / loss);
	}
	return share;
}

} // namespace

template <int dim>
std::vector<double>
balancedNodeMass(const std::vector<Vec<dim>>& nodePosition, const std::vector<double>& rowSums,
		 const Quadrature<dim>& points, const SparseRows<ShapeFunction<dim>>& pointShapes)
{
	const int nodes = static_cast<int>(rowSums.size());
	const auto bound = laplacianRowSums<dim>(nodes, points.weight, pointShapes);
	const auto kept =
		withMoments<dim>(bound, nodePosition, momentsOf<dim>(nodePosition, rowSums));
	const auto exact = withMoments<dim>(bound, nodePosition, momentsOfContinuum(points));
	if (areTooCoarse(kept, rowSums)) return rowSums;
	const double share = shareOfWay(kept, exact);
	std::vector<double> mass(nodes);
	for (int I = 0; I < nodes; ++I)
		mass[I] = (1 - share) * kept[I] + share * exact[I];
	return mass;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::vector<double> balancedNodeMass<dim>(                                        \
		const std::vector<Vec<dim>>&, const std::vector<double>&, const Quadrature<dim>&,  \
		const SparseRows<ShapeFunction<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
