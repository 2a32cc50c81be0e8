#include "Problems.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/PairProblem.hpp"

#include <array>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// All contacts of a problem as if they were those of one pair.
template <int dim> PairProblem<dim> asPair(const ContactProblem<dim>& problem)
{
	PairProblem<dim> pair;
	pair.resize(problem.contacts());
	for (int k = 0; k < problem.contacts(); ++k)
		for (int e = problem.delassus.begin(k); e < problem.delassus.end(k); ++e)
			pair.column(k)[problem.delassus.column[e]] = problem.delassus.value[e];
	const std::vector<Vec<dim>> velocity = problem.velocity();
	for (int k = 0; k < problem.contacts(); ++k)
		pair.setContact(k, problem.normal[k], problem.bias[k], problem.friction[k],
				problem.impulse[k], velocity[k]);
	return pair;
}

/// Number of sweeps; the problem gets the impulses.
template <int dim> int solveAsPair(ContactProblem<dim>& problem, double violation, int maxSweeps)
{
	PairProblem<dim> pair = asPair(problem);
	const int sweeps = pair.solve(violation, maxSweeps);
	for (int k = 0; k < problem.contacts(); ++k)
		problem.impulse[k] = pair.impulse(k);
	return sweeps;
}

/// sum W |rho|^2
template <int dim> double violationOf(const ContactProblem<dim>& problem)
{
	double sum = 0;
	const std::vector<Vec<dim>> velocity = problem.velocity();
	for (int k = 0; k < problem.contacts(); ++k) {
		const Vec<dim> solved = solvedContact<dim>(
			problem.impulse[k], velocity[k], problem.normal[k], problem.bias[k],
			1 / problem.mobility(k), problem.friction[k]);
		sum += problem.mobility(k) * (solved - problem.impulse[k]).squaredNorm();
	}
	return sum;
}

/// Nodes of a body that feel each other, in turn against a floor and a wall.
ContactProblem<3> wedge(unsigned seed, double friction)
{
	Random random(seed);
	constexpr int nodes = 24;
	ContactProblem<3> problem;
	for (int k = 0; k < nodes; ++k) {
		for (int l = 0; l < nodes; ++l) // nearly singular, as that of surface nodes
			problem.delassus.append(l, std::exp(-0.02 * (k - l) * (k - l)));
		problem.delassus.closeRow();
		problem.normal.push_back(Vec<3>::Unit(k % 2));
		problem.freeVelocity.push_back(random.vector<3>());
		problem.bias.push_back(0);
		problem.friction.push_back(friction);
	}
	problem.start.assign(nodes, Vec<3>::Zero());
	problem.impulse = problem.start;
	return problem;
}

/// Two grains, each on a plane of its own by as many contacts as it has nodes: two pairs that do
/// not feel each other.
struct TwoPairs {
	static constexpr int nodes = 8;
	SparseRows<double> table;
	OutlineMesh<2> mesh;
	std::vector<ContactBody<2>> body = std::vector<ContactBody<2>>(2);
	std::array<ContactList<2>, 2> planes;

	TwoPairs()
	{
		for (int i = 0; i < nodes; ++i) {
			for (int j = 0; j < nodes; ++j) // neighbours feel each other nearly alike
				table.append(j, 1 / (1. + 0.2 * (i - j) * (i - j)));
			table.closeRow();
		}
		for (int b = 0; b < 2; ++b) {
			body[b].delassus = &table;
			body[b].delassusScale = 1;
			body[b].mesh = &mesh;
			body[b].position.assign(nodes, Vec<2>::Zero());
			body[b].velocity.assign(nodes, Vec<2>(0.1, -1));
			body[b].impulse.assign(nodes, Vec<2>::Zero());
			planes[b].first = b;
			planes[b].friction = 0.3;
			planes[b].plane.normal = { 0, 1 };
			for (int n = 0; n < nodes; ++n) {
				Contact<2> c;
				c.key = { 0, n, -1 };
				c.normal = { 0, 1 };
				c.gap = 0.02 * n;
				planes[b].contacts.push_back(c);
			}
		}
	}
	SolverReport solve(double tolerance)
	{
		for (ContactBody<2>& b : body) {
			b.velocity.assign(nodes, Vec<2>(0.1, -1));
			b.impulse.assign(nodes, Vec<2>::Zero());
		}
		SolverSettings settings;
		settings.tolerance = tolerance;
		settings.maxSweeps = 1000;
		ContactSolver<2> solver;
		solver.plan({ &planes[0], &planes[1] }, static_cast<int>(body.size()));
		solver.prepare(body, 1, settings);
		return solver.solve();
	}
	void forget(int b)
	{
		for (Contact<2>& c : planes[b].contacts)
			c.impulse.setZero();
	}
};

} // namespace

TEMPLATE_TEST_CASE_SIG("Pair on its own: all conditions", "[contact]", ((int dim), dim), 2, 3)
{
	States seen;
	for (unsigned seed = 1; seed <= 30; ++seed) {
		auto problem = randomProblem<dim>(seed, 12, 9, seed % 2 ? 0.3 : 0.8);
		const int sweeps = solveAsPair(problem, 1e-26, 100000);
		CAPTURE(seed, sweeps);
		CHECK(problem.residual() < 1e-11);
		seen += checkConditions(problem, 1e-9);
	}
	CHECK(seen.open > 10);
	CHECK(seen.stick > 10);
	CHECK(seen.slip > 10);
}

TEST_CASE("Pair on its own: ends at the violation asked for, or at the cap", "[contact]")
{
	for (double violation : { 1e-6, 1e-9, 1e-12 }) {
		auto problem = tower<2>(10, 2, 0.3);
		const int sweeps = solveAsPair(problem, violation, 100000);
		CAPTURE(violation, sweeps);
		CHECK(violationOf(problem) <= violation * (1 + 1e-6));
		auto shorter = tower<2>(10, 2, 0.3);
		CHECK(solveAsPair(shorter, violation, sweeps - 1) == sweeps - 1);
		CHECK(violationOf(shorter) > violation);
		for (int k = 0; k < shorter.contacts(); ++k) // admissible wherever it stops
			CHECK((shorter.impulse[k] - onCone<2>(shorter.impulse[k], shorter.normal[k],
							      shorter.friction[k]))
				      .norm() < 1e-15);
	}
}

TEST_CASE("Pair on its own: extrapolation saves sweeps", "[contact]")
{
	for (int redundancy : { 1, 3 }) {
		auto problem = tower<2>(20, redundancy, 0.3), plain = problem;
		const SolverReport report = solve(plain, 1e-4, 100000);
		const double reached = violationOf(plain);
		const int sweeps = solveAsPair(problem, reached, 100000);
		CAPTURE(redundancy, report.sweeps, sweeps);
		CHECK(sweeps < 0.5 * report.sweeps);
	}
}

TEST_CASE("Pair on its own: wedged contacts of large friction do not grow", "[contact]")
{
	// a light body in a corner of a heavy one, by many contacts with both sides
	for (const double friction : { 2., 5. })
		for (unsigned seed = 1; seed <= 5; ++seed) {
			auto problem = wedge(seed, friction), plain = problem;
			const double start = violationOf(problem);
			solve(plain, 1e-6, 1000);
			solveAsPair(problem, 1e-12 * start, 1000);
			double largest = 0, usual = 0;
			for (int k = 0; k < problem.contacts(); ++k) {
				largest = std::max(largest, problem.impulse[k].norm());
				usual = std::max(usual, plain.impulse[k].norm());
			}
			CAPTURE(friction, seed, largest, usual);
			CHECK(largest < 20 * usual);
			CHECK(violationOf(problem) <= start);
		}
}

TEST_CASE("Pairs on their own: only where the residual sits", "[contact]")
{
	TwoPairs scene;
	const double tolerance = 1e-6;
	const SolverReport cold = scene.solve(tolerance);
	CHECK(cold.converged);
	CHECK(cold.visits > 8L * cold.contacts);
	CHECK(cold.sweeps == double(cold.visits) / cold.contacts);
	scene.forget(1);
	const SolverReport half = scene.solve(tolerance);
	CHECK(half.converged);
	// four sweeps of all, and what the forgotten pair needed before
	CHECK(half.visits > 4L * half.contacts);
	CHECK(half.visits < 4L * half.contacts + 0.7 * (cold.visits - 4L * cold.contacts));
	CHECK(scene.solve(tolerance).visits == 4L * half.contacts);
}
