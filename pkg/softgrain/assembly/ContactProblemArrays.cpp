#include "assembly/ContactProblemArrays.hpp"
#include "Require.hpp"
#include "assembly/SpaceVectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace softgrain {

namespace {

/// Lengths of normals that come from files may be rounded that far.
constexpr double unitTolerance = 1e-6;

template <int dim> std::vector<Vec<dim>> vectors(const std::vector<double>& numbers)
{
	std::vector<Vec<dim>> result;
	for (std::size_t k = 0; k < numbers.size(); k += dim)
		result.push_back(Eigen::Map<const Vec<dim>>(&numbers[k]));
	return result;
}

void checkArray(const std::vector<double>& numbers, const char* name, std::size_t expected)
{
	require(numbers.size() == expected, std::string("size of ") + name, numbers.size(),
		"of " + std::to_string(expected) + " numbers");
	for (double number : numbers)
		require(std::isfinite(number), name, number, "of finite numbers");
}

void checkDelassus(const SparseRows<double>& W, int contacts)
{
	require(W.rows() == contacts, "rows of delassus", W.rows(), "of one row a contact");
	require(W.column.size() == W.value.size(), "size of delassus_column", W.column.size(),
		"of one number a value");
	require(W.offset.front() == 0 && std::is_sorted(W.offset.begin(), W.offset.end()) &&
			W.offset.back() == static_cast<int>(W.value.size()),
		"last of delassus_offset", W.offset.back(),
		"of offsets that rise from 0 to the number of values");
	for (int column : W.column)
		require(column >= 0 && column < contacts, "delassus_column", column,
			"[0, contacts)");
	for (double value : W.value)
		require(std::isfinite(value), "delassus_value", value, "of finite numbers");
	for (int k = 0; k < contacts; ++k) {
		double diagonal = 0;
		for (int e = W.begin(k); e < W.end(k); ++e)
			if (W.column[e] == k) diagonal = W.value[e];
		require(diagonal > 0, "diagonal entry of delassus", diagonal, "(0, inf)");
	}
}

void check(const ContactProblemArrays& p, double tolerance, int maxSweeps)
{
	require(tolerance > 0, "tolerance", tolerance, "(0, inf)");
	require(maxSweeps >= 1, "max_sweeps", maxSweeps, "1, 2, ...");
	require(p.dim == 2 || p.dim == 3, "dim", p.dim, "2, 3");
	const std::size_t contacts = p.bias.size();
	checkArray(p.normal, "normal", contacts * p.dim);
	checkArray(p.freeVelocity, "free_velocity", contacts * p.dim);
	checkArray(p.bias, "bias", contacts);
	checkArray(p.friction, "friction", contacts);
	checkArray(p.start, "start", contacts * p.dim);
	for (double mu : p.friction)
		require(mu >= 0, "friction", mu, "[0, inf)");
	for (std::size_t k = 0; k < contacts; ++k) {
		const double length =
			Eigen::Map<const Eigen::VectorXd>(&p.normal[k * p.dim], p.dim).norm();
		require(std::abs(length - 1) < unitTolerance, "length of normal", length, "1");
	}
	checkDelassus(p.delassus, static_cast<int>(contacts));
}

template <int dim>
SolverReport solveIn(ContactProblemArrays& arrays, double tolerance, int maxSweeps)
{
	ContactProblem<dim> problem { arrays.delassus,
				      vectors<dim>(arrays.normal),
				      vectors<dim>(arrays.freeVelocity),
				      arrays.bias,
				      arrays.friction,
				      vectors<dim>(arrays.start),
				      {} };
	const SolverReport report = solve(problem, tolerance, maxSweeps);
	arrays.impulse = numbersOf<dim>(problem.impulse);
	return report;
}

} // namespace

template <int dim> ContactProblemArrays arraysOf(const ContactProblem<dim>& p)
{
	return { dim,    p.delassus, numbersOf<dim>(p.normal), numbersOf<dim>(p.freeVelocity),
		 p.bias, p.friction, numbersOf<dim>(p.start),  numbersOf<dim>(p.impulse) };
}

template ContactProblemArrays arraysOf(const ContactProblem<2>&);
template ContactProblemArrays arraysOf(const ContactProblem<3>&);

SolverReport solve(ContactProblemArrays& problem, double tolerance, int maxSweeps)
{
	check(problem, tolerance, maxSweeps);
	return problem.dim == 2 ? solveIn<2>(problem, tolerance, maxSweeps)
				: solveIn<3>(problem, tolerance, maxSweeps);
}

} // namespace softgrain
