#include "reference/PressureSpace.hpp"
#include "reference/BSpline.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <stdexcept>

namespace softgrain {

namespace {

template <int dim> using Index = std::array<int, dim>;

/// Values of the 2^dim functions about X.
template <int dim> std::map<Index<dim>, double> functionsAt(const Vec<dim>& X, double spacing)
{
	std::map<Index<dim>, double> values;
	for (int corner = 0; corner < (1 << dim); ++corner) {
		Index<dim> index;
		double value = 1;
		for (int a = 0; a < dim; ++a) {
			const SplineStencil s = splineStencil(1, X[a] / spacing);
			const int side = corner >> a & 1;
			index[a] = s.first + side;
			value *= s.value[side];
		}
		if (value > 0) values.emplace(index, value);
	}
	return values;
}

/// Numbers of the functions that are heavy enough, and of the heaviest at points that see none of
/// these.
template <int dim>
std::map<Index<dim>, int> heavyFunctions(const Quadrature<dim>& quadrature, double spacing)
{
	std::map<Index<dim>, double> mass;
	for (std::size_t p = 0; p < quadrature.point.size(); ++p)
		for (const auto& [index, value] : functionsAt<dim>(quadrature.point[p], spacing))
			mass[index] += quadrature.weight[p] * value;
	double heaviest = 0;
	for (const auto& [index, m] : mass)
		heaviest = std::max(heaviest, m);
	std::set<Index<dim>> heavy;
	for (const auto& [index, m] : mass)
		if (m >= lightFunctionShare * heaviest) heavy.insert(index);
	for (const Vec<dim>& X : quadrature.point) {
		const auto values = functionsAt<dim>(X, spacing);
		auto isHeavy = [&](const auto& f) { return heavy.count(f.first) > 0; };
		if (std::any_of(values.begin(), values.end(), isHeavy)) continue;
		auto isLighter = [&](const auto& f, const auto& g) {
			return mass[f.first] < mass[g.first];
		};
		heavy.insert(std::max_element(values.begin(), values.end(), isLighter)->first);
	}
	std::map<Index<dim>, int> number;
	for (const Index<dim>& index : heavy)
		number.emplace(index, static_cast<int>(number.size()));
	return number;
}

using SparseMatrix = Eigen::SparseMatrix<double>;

SparseMatrix gramMatrix(const SparseRows<double>& shapes, const std::vector<double>& weight,
			int functions)
{
	std::vector<Eigen::Triplet<double>> entries;
	for (int p = 0; p < shapes.rows(); ++p)
		for (int i = shapes.begin(p); i < shapes.end(p); ++i)
			for (int j = shapes.begin(p); j < shapes.end(p); ++j)
				entries.emplace_back(shapes.column[i], shapes.column[j],
						     weight[p] * shapes.value[i] * shapes.value[j]);
	SparseMatrix gram(functions, functions);
	gram.setFromTriplets(entries.begin(), entries.end());
	return gram;
}

using Cholesky = Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>;

/// Whether there is a factor whose rows are not those of rounding, which leaves 1e-16 of a pivot.
bool isFactored(const Cholesky& solver, const SparseMatrix& gram)
{
	constexpr double rounding = 1e-10;
	if (solver.info() != Eigen::Success) return false;
	const Eigen::VectorXd pivots = SparseMatrix(solver.matrixL()).diagonal();
	return (pivots.array().square() > rounding * gram.diagonal().array()).all();
}

/// At few points functions may depend on each other. Their shares are not determined then, and a
/// ridge takes about the smallest; what is projected changes by as little as that is.
SparseRows<double> choleskyRows(SparseMatrix gram)
{
	constexpr double ridge = 1e-8;
	Cholesky solver(gram);
	if (!isFactored(solver, gram)) {
		gram.diagonal() *= 1 + ridge;
		solver.compute(gram);
	}
	if (solver.info() != Eigen::Success)
		throw std::logic_error("the pressure functions of a grain have no factor");
	const Eigen::SparseMatrix<double, Eigen::RowMajor> L = SparseMatrix(solver.matrixL());
	SparseRows<double> rows;
	for (int a = 0; a < L.rows(); ++a) {
		for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(L, a); entry;
		     ++entry)
			rows.append(static_cast<int>(entry.col()), entry.value());
		rows.closeRow();
	}
	return rows;
}

} // namespace

template <int dim>
PressureSpace makePressureSpace(const Quadrature<dim>& quadrature, double spacing)
{
	const auto number = heavyFunctions<dim>(quadrature, spacing);
	PressureSpace space;
	for (const Vec<dim>& X : quadrature.point) {
		double sum = 0;
		const auto values = functionsAt<dim>(X, spacing);
		for (const auto& [index, value] : values)
			if (number.count(index)) sum += value;
		for (const auto& [index, value] : values) {
			const auto known = number.find(index);
			if (known != number.end()) space.shapes.append(known->second, value / sum);
		}
		space.shapes.closeRow();
	}
	space.factor = choleskyRows(
		gramMatrix(space.shapes, quadrature.weight, static_cast<int>(number.size())));
	return space;
}

template PressureSpace makePressureSpace<2>(const Quadrature<2>&, double);
template PressureSpace makePressureSpace<3>(const Quadrature<3>&, double);

} // namespace softgrain
