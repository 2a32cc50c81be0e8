#include "contact/solve/TwoBodies.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double tolerance = 1e-3;

/// Bodies and lists of two problems as those of one scene.
template <int dim> struct BothProblems {
	Problem<dim>&first, &second;
	std::vector<ContactBody<dim>> body;

	BothProblems(Problem<dim>& a, Problem<dim>& b)
		: first(a)
		, second(b)
	{
		for (Problem<dim>* problem : { &a, &b })
			body.insert(body.end(), problem->body.begin(), problem->body.end());
		for (ContactList<dim>* list : b.lists()) {
			list->first += 2;
			if (list->second >= 0) list->second += 2;
		}
	}
	SolverReport solve()
	{
		std::vector<ContactList<dim>*> lists = first.lists();
		for (ContactList<dim>* list : second.lists())
			lists.push_back(list);
		ContactSolver<dim> solver;
		solver.plan(lists, static_cast<int>(body.size()));
		solver.prepare(body, first.dt, first.settings);
		return solver.solve();
	}
};

template <int dim> void makeFaster(Problem<dim>& problem, double times)
{
	for (int b : { 0, 1 })
		for (Vec<dim>& v : problem.start[b])
			v *= times;
	problem.restart();
}

template <int dim> std::vector<Vec<dim>> impulsesOf(Problem<dim>& problem)
{
	std::vector<Vec<dim>> impulses;
	for (const Contact<dim>* contact : problem.contacts())
		impulses.push_back(contact->impulse);
	return impulses;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Islands: each is solved as if it were alone", "[contact]", ((int dim), dim),
		       2, 3)
{
	for (unsigned seed = 1; seed <= 20; ++seed) {
		CAPTURE(seed);
		Problem<dim> alone(seed, 0.3), slow(seed, 0.3), fast(seed + 100, 0.3);
		alone.settings.tolerance = slow.settings.tolerance = tolerance;
		makeFaster(fast, 1e4);
		ContactSolver<dim> solver;
		const SolverReport expected = alone.solve(solver);
		const SolverReport report = BothProblems<dim>(slow, fast).solve();
		CHECK(impulsesOf(slow) == impulsesOf(alone));
		CHECK(report.residual >= expected.residual);
		CHECK(report.residual <= tolerance);
		CHECK(report.visits > expected.visits);
		CHECK(report.contacts == 2 * expected.contacts);
	}
}

TEST_CASE("Islands: no number on one is none of all", "[contact]")
{
	for (const bool isFirst : { true, false }) {
		Problem<2> odd(1, 0.3), usual(2, 0.3);
		odd.start[0][0][0] = std::numeric_limits<double>::quiet_NaN();
		odd.restart();
		BothProblems<2> both =
			isFirst ? BothProblems<2>(odd, usual) : BothProblems<2>(usual, odd);
		const SolverReport report = both.solve();
		CHECK(std::isnan(report.residual));
		CHECK(!report.converged);
	}
}
