#include "Problems.hpp"
#include "contact/solve/Bias.hpp"
#include "contact/solve/TwoBodies.hpp"

#include <array>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// One body of one node of mass 2 above a plane.
struct Ball {
	SparseRows<double> table;
	OutlineMesh<2> mesh;
	std::vector<ContactBody<2>> body = std::vector<ContactBody<2>>(1);
	ContactList<2> list;
	ContactSolver<2> solver;

	Ball(const Vec<2>& velocity, double gap, double friction,
	     const Vec<2>& planeVelocity = Vec<2>::Zero())
	{
		table.append(0, 1);
		table.closeRow();
		body[0].mesh = &mesh;
		body[0].delassus = &table;
		body[0].delassusScale = 0.5;
		body[0].velocity = body[0].velocityBefore = { velocity };
		body[0].impulse = body[0].position = { Vec<2>::Zero() };
		list.first = 0;
		list.friction = friction;
		list.plane = { Vec<2>::Zero(), Vec<2>::Unit(1), planeVelocity };
		Contact<2> c;
		c.key = { 0, 0, -1 };
		c.normal = Vec<2>::Unit(1);
		c.gap = gap;
		list.contacts.push_back(c);
	}
	Ball(const Ball&) = delete;
	void solve(double dt, const SolverSettings& settings = {})
	{
		std::vector<ContactList<2>*> lists { &list };
		solver.plan(lists, static_cast<int>(body.size()));
		solver.prepare(body, dt, settings);
		solver.solve();
	}
};

} // namespace

TEMPLATE_TEST_CASE_SIG("Solver: frictionless problems against enumeration", "[contact]",
		       ((int dim), dim), 2, 3)
{
	int active = 0, open = 0;
	for (unsigned seed = 1; seed <= 30; ++seed) {
		Problem<dim> problem(seed, 0);
		ContactSolver<dim> solver;
		const SolverReport report = problem.solve(solver);
		CAPTURE(seed, report.sweeps, report.residual);
		CHECK(report.converged);
		const Eigen::VectorXd exact = enumerated(problem);
		REQUIRE(exact.allFinite());
		const auto all = problem.contacts();
		for (std::size_t c = 0; c < all.size(); ++c) {
			CHECK((all[c]->impulse - exact[c] * all[c]->normal).norm() < 1e-8);
			(exact[c] > 0 ? active : open) += 1;
		}
		CHECK(report.active == (exact.array() > 0).count());
		CHECK(report.contacts == (dim == 2 ? 8 : 9));
	}
	CHECK(active > 20);
	CHECK(open > 20);
}

TEMPLATE_TEST_CASE_SIG("Solver: no friction is the limit of little, sweep by sweep", "[contact]",
		       ((int dim), dim), 2, 3)
{
	const double tolerance = GENERATE(1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-14);
	for (unsigned seed = 1; seed <= 10; ++seed) {
		Problem<dim> none(seed, 0), little(seed, 1e-200);
		none.settings.tolerance = little.settings.tolerance = tolerance;
		ContactSolver<dim> solver, another;
		CAPTURE(seed, tolerance);
		const double sweeps = none.solve(solver).sweeps,
			     others = little.solve(another).sweeps;
		if (tolerance > 1e-12) CHECK(sweeps == others); // below, rounding decides on it
		const auto all = none.contacts(), same = little.contacts();
		for (std::size_t c = 0; c < all.size(); ++c)
			CHECK((all[c]->impulse - same[c]->impulse).norm() < 1e-12);
	}
}

TEMPLATE_TEST_CASE_SIG("Solver: friction against damped projections, and all conditions",
		       "[contact]", ((int dim), dim), 2, 3)
{
	States seen;
	for (unsigned seed = 1; seed <= 30; ++seed) {
		Problem<dim> problem(seed, seed % 2 ? 0.3 : 0.8);
		ContactSolver<dim> solver;
		const SolverReport report = problem.solve(solver);
		CAPTURE(seed, report.sweeps, report.residual);
		CHECK(report.converged);
		CHECK(solver.residual() < 1e-10);
		const States states = checkConditions(problem.dense(), 1e-9);
		seen.open += states.open;
		seen.stick += states.stick;
		seen.slip += states.slip;
		const auto exact = projected(problem);
		const auto all = problem.contacts();
		for (std::size_t c = 0; c < all.size(); ++c)
			CHECK((all[c]->impulse - exact[c]).norm() < 1e-8);
	}
	CAPTURE(seen.open, seen.stick, seen.slip);
	CHECK(seen.open > 10);
	CHECK(seen.stick > 10);
	CHECK(seen.slip > 10);
}

TEMPLATE_TEST_CASE_SIG("Solver: any warm start leads to the same impulses, the solution at once",
		       "[contact]", ((int dim), dim), 2, 3)
{
	for (unsigned seed = 1; seed <= 5; ++seed) {
		Problem<dim> problem(seed, 0.3);
		ContactSolver<dim> solver;
		const double cold = problem.solve(solver).sweeps;
		std::vector<Vec<dim>> solution;
		for (Contact<dim>* c : problem.contacts())
			solution.push_back(c->impulse);
		CHECK(problem.solve(solver).sweeps <= 4);
		CHECK(cold > 4);
		Random random(seed);
		for (int n = 0; n < 5; ++n) {
			for (Contact<dim>* c : problem.contacts())
				c->impulse = random.vector<dim>(2); // not even admissible
			problem.solve(solver);
			const auto all = problem.contacts();
			for (std::size_t c = 0; c < all.size(); ++c)
				CHECK((all[c]->impulse - solution[c]).norm() < 1e-8);
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Solver: residual sees what is not solved", "[contact]", ((int dim), dim), 2,
		       3)
{
	Problem<dim> problem(4, 0.3);
	ContactSolver<dim> solver;
	problem.solve(solver);
	CHECK(solver.residual() < 1e-10);
	std::vector<Vec<dim>> solution;
	for (Contact<dim>* c : problem.contacts())
		solution.push_back(c->impulse);
	double last = 0;
	for (double share : { 1e-4, 1e-3, 1e-2, 1e-1 }) {
		const auto all = problem.contacts();
		for (std::size_t c = 0; c < all.size(); ++c)
			all[c]->impulse = (1 + share) * solution[c];
		problem.restart();
		auto lists = problem.lists();
		solver.plan(lists, static_cast<int>(problem.body.size()));
		solver.prepare(problem.body, problem.dt, problem.settings);
		const double residual = solver.residual();
		CAPTURE(share, residual);
		CHECK(residual > 0.1 * share);
		CHECK(residual < 10 * share);
		CHECK(residual > last);
		last = residual;
	}
}

TEMPLATE_TEST_CASE_SIG("Solver: the cap on sweeps is kept and reported", "[contact]",
		       ((int dim), dim), 2, 3)
{
	Problem<dim> problem(2, 0.3);
	problem.settings.maxSweeps = 3;
	ContactSolver<dim> solver;
	const SolverReport capped = problem.solve(solver);
	CHECK(capped.sweeps == 3);
	CHECK(!capped.converged);
	CHECK(capped.residual > problem.settings.tolerance);
	CHECK(capped.residual == solver.residual());

	problem.settings.maxSweeps = 1000;
	problem.settings.tolerance = 1e-3;
	const SolverReport loose = problem.solve(solver);
	CHECK(loose.converged);
	CHECK(loose.residual <= 1e-3);
	CHECK(loose.residual == solver.residual());
	problem.settings.tolerance = 1e-9;
	for (Contact<dim>* c : problem.contacts())
		c->impulse.setZero();
	CHECK(problem.solve(solver).sweeps > loose.sweeps);
}

TEMPLATE_TEST_CASE_SIG("Solver: the problem can be taken out and solved elsewhere", "[contact]",
		       ((int dim), dim), 2, 3)
{
	Problem<dim> problem(3, 0.3);
	ContactSolver<dim> solver;
	Random random(3);
	for (Contact<dim>* c : problem.contacts())
		c->impulse = random.vector<dim>();
	const SolverReport report = problem.solve(solver);
	ContactProblem<dim> taken = solver.problem();
	const auto all = problem.contacts();
	REQUIRE(taken.contacts() == static_cast<int>(all.size()));

	const ContactProblem<dim> expected = problem.dense();
	Eigen::MatrixXd W = -problem.delassus();
	const double size = W.norm();
	for (int c = 0; c < taken.contacts(); ++c) {
		for (int e = taken.delassus.begin(c); e < taken.delassus.end(c); ++e)
			W(c, taken.delassus.column[e]) += taken.delassus.value[e];
		CHECK((taken.freeVelocity[c] + taken.bias[c] * taken.normal[c] -
		       expected.freeVelocity[c])
			      .norm() < 1e-14);
		CHECK(taken.normal[c] == expected.normal[c]);
		CHECK(taken.impulse[c] == expected.impulse[c]);
		CHECK(taken.friction[c] == expected.friction[c]);
	}
	CHECK(W.norm() < 1e-14 * size);
	CHECK(std::abs(taken.residual() - report.residual) < 1e-13);
	CHECK(std::abs(expected.residual() - report.residual) < 1e-13);

	const auto solution = taken.impulse;
	CHECK(solve(taken, problem.settings.tolerance, 100000).converged);
	for (int c = 0; c < taken.contacts(); ++c)
		CHECK((taken.impulse[c] - solution[c]).norm() < 1e-10);
}

TEST_CASE("Solver: nothing to do", "[contact]")
{
	std::vector<ContactBody<2>> bodies;
	std::vector<ContactList<2>*> lists;
	ContactSolver<2> solver;
	solver.plan(lists, static_cast<int>(bodies.size()));
	solver.prepare(bodies, 1, {});
	const SolverReport report = solver.solve();
	CHECK(report.converged);
	CHECK(report.sweeps == 0);
	CHECK(solver.residual() == 0);
}

TEMPLATE_TEST_CASE_SIG("Solver: momentum, velocities and work follow from the impulses",
		       "[contact]", ((int dim), dim), 2, 3)
{
	constexpr int nodes = Problem<dim>::nodes;
	for (unsigned seed = 1; seed <= 5; ++seed) {
		Problem<dim> problem(seed, 0.3);
		problem.pair.account.grace = problem.plane.account.grace = 0;
		ContactSolver<dim> solver;
		problem.solve(solver);
		Vec<dim> sum = Vec<dim>::Zero(), fromPlane = Vec<dim>::Zero();
		double size = 0;
		for (const ContactBody<dim>& b : problem.body)
			for (const Vec<dim>& r : b.impulse) {
				sum += r;
				size += r.norm();
			}
		for (const Contact<dim>& c : problem.plane.contacts)
			fromPlane += c.impulse;
		CHECK(size > 0.1);
		CHECK((sum - fromPlane).norm() <
		      1e-14 * size); // between the bodies nothing is gained

		double gained = 0;
		for (int b = 0; b < 2; ++b)
			for (int i = 0; i < nodes; ++i) {
				Vec<dim> v = problem.start[b][i];
				for (int j = 0; j < nodes; ++j)
					v += problem.W[b](i, j) * problem.body[b].impulse[j];
				CHECK((v - problem.body[b].velocity[i]).norm() < 1e-11);
				gained += 0.5 * problem.body[b].impulse[i].dot(
							problem.body[b].velocityBefore[i] + v);
			}
		const ContactWork work = solver.work();
		auto total = [](const ContactWork::Halves& h) { return h.before + h.after; };
		CHECK(std::abs(total(work.walls) - total(work.impact) - total(work.friction) -
			       gained) < 1e-11);
		CHECK(work.friction.after > -1e-12); // sliding opposite to the force takes energy

		std::array<double, 2> given { 0, 0 }; // by overlaps: of the pair, of the plane
		const auto all = problem.contacts();
		for (int c = 0; c < static_cast<int>(all.size()); ++c) {
			if (all[c]->gap >= 0) continue;
			Vec<dim> u = Vec<dim>::Zero();
			for (int b = 0; b < 2; ++b)
				for (int i = 0; i < nodes; ++i)
					u += problem.shares(c, b)[i] * problem.body[b].velocity[i];
			if (problem.onPlane(c)) u -= problem.plane.plane.velocity;
			const Vec<dim>& n = all[c]->normal;
			given[problem.onPlane(c)] += all[c]->impulse.dot(n) * u.dot(n);
		}
		CHECK(std::abs(problem.pair.account.taken + given[0]) < 1e-12);
		CHECK(std::abs(problem.plane.account.taken + given[1]) < 1e-12);
		CHECK(std::abs(given[0]) + std::abs(given[1]) > 1e-3);
	}
}

TEST_CASE("Solver: one ball on a plane, by hand", "[contact]")
{
	SECTION("stops on the plane and loses its energy")
	{
		Ball ball({ 1, -2 }, 0, 0.6);
		ball.solve(0.1);
		CHECK((ball.list.contacts[0].impulse - Vec<2>(-2, 4)).norm() <
		      1e-14); // m = 2, sticks
		CHECK(ball.body[0].velocity[0].norm() < 1e-14);
		const ContactWork w = ball.solver.work();
		CHECK(std::abs(w.impact.before + w.impact.after - 4) < 1e-14);
		CHECK(std::abs(w.friction.before + w.friction.after - 1) < 1e-14);
		CHECK(w.walls.before == 0);
	}
	SECTION("slides where friction does not suffice")
	{
		Ball ball({ 1, -2 }, 0, 0.1);
		ball.solve(0.1);
		CHECK((ball.list.contacts[0].impulse - Vec<2>(-0.4, 4)).norm() < 1e-14);
		CHECK((ball.body[0].velocity[0] - Vec<2>(0.8, 0)).norm() < 1e-14);
	}
	SECTION("closes a gap and no more")
	{
		Ball ball({ 0, -2 }, 0.05, 0);
		ball.solve(0.1);
		CHECK((ball.body[0].velocity[0] - Vec<2>(0, -0.5)).norm() < 1e-14);
	}
	SECTION("a gap wider than the way of one step is left alone")
	{
		Ball ball({ 1, -2 }, 0.3, 0.5);
		ball.solve(0.1);
		CHECK(ball.list.contacts[0].impulse.norm() == 0);
		CHECK(ball.body[0].velocity[0] == Vec<2>(1, -2));
	}
	SECTION("an overlap is worked off by its share, up to the cap")
	{
		SolverSettings settings;
		settings.overlapRelaxation = 0.2;
		Ball share({ 0, -2 }, -0.05, 0);
		share.solve(0.1, settings);
		CHECK((share.body[0].velocity[0] - Vec<2>(0, 0.1)).norm() < 1e-14);
		settings.overlapSpeed = 0.03;
		Ball capped({ 0, -2 }, -0.05, 0);
		capped.solve(0.1, settings);
		CHECK((capped.body[0].velocity[0] - Vec<2>(0, 0.03)).norm() < 1e-14);
	}
	SECTION("a thousandth of the point spacing is left")
	{
		SolverSettings settings;
		settings.overlapRelaxation = 0.2;
		Ball left({ 0, -2 }, -0.05, 0);
		left.body[0].pointSpacing = 51;
		left.solve(0.1, settings);
		CHECK(left.body[0].velocity[0].norm() < 1e-14);
		Ball excess({ 0, -2 }, -0.05, 0);
		excess.body[0].pointSpacing = 30;
		excess.solve(0.1, settings);
		CHECK((excess.body[0].velocity[0] - Vec<2>(0, 0.04)).norm() < 1e-14);
	}
	SECTION("a small overlap without an account is worked off by its cube")
	{
		SolverSettings settings;
		settings.overlapRelaxation = 1;
		settings.overlapSpeed = 0.08;
		const double account = GENERATE(0., -1., 1.);
		Ball ball({ 0, -2 }, -0.026, 0); // half of what is urgent, and what rests
		ball.body[0].pointSpacing = 1;
		ball.list.account = { account, 0 };
		ball.solve(0.1, settings);
		const double speed = account > 0 ? 0.08 : 0.01;
		CHECK((ball.body[0].velocity[0] - Vec<2>(0, speed)).norm() < 1e-14);
		// what it gave, with the impulse that stops and turns it, is entered
		const double r = ball.list.contacts[0].impulse[1];
		CHECK(std::abs(r - 2 * (2 + speed)) < 1e-13); // m = 2
		const double kept = (1 - 1. / stepsOfAccount) * account;
		CHECK(std::abs(ball.list.account.taken - (kept - r * speed)) < 1e-14);
	}
	SECTION("what bears may owe its force over what may rest")
	{
		SolverSettings settings;
		settings.overlapRelaxation = 1;
		settings.overlapSpeed = 0.08;
		const double owed = GENERATE(0.0199, 0.0201); // J; the force is 20 N
		Ball ball({ 0, -2 }, -0.026, 0);
		ball.body[0].pointSpacing = 1;
		ball.list.contacts[0].impulse = Vec<2>(0, 2);
		ball.list.account = { -owed, 0 };
		ball.solve(0.1, settings);
		const double speed = owed < 0.02 ? 0.08 : 0.01;
		CHECK((ball.body[0].velocity[0] - Vec<2>(0, speed)).norm() < 1e-14);
	}
	SECTION("an overlap that was there from the start is worked off at full speed")
	{
		SolverSettings settings;
		settings.overlapRelaxation = 1;
		settings.overlapSpeed = 0.08;
		Ball ball({ 0, -2 }, -0.026, 0);
		ball.body[0].pointSpacing = 1;
		ball.solve(0.1, settings);
		CHECK((ball.body[0].velocity[0] - Vec<2>(0, 0.08)).norm() < 1e-14);
		CHECK(ball.list.account.taken == 0);
		CHECK(ball.list.account.grace == stepsOfAccount - 1);
		ball.list.contacts[0].gap = -1e-4;
		ball.solve(0.1, settings);
		CHECK(ball.list.account.grace == 0); // for good
		ball.list.contacts[0].gap = -0.026;
		ball.body[0].velocity[0] = Vec<2>(0, -2);
		ball.solve(0.1, settings);
		CHECK(ball.list.account.taken < 0);
	}
	SECTION("a moving plane takes it along and works on it")
	{
		Ball ball({ 0, 0 }, 0, 10, { 3, 1 });
		ball.solve(0.1);
		CHECK((ball.body[0].velocity[0] - Vec<2>(3, 1)).norm() < 1e-14);
		const ContactWork w = ball.solver.work();
		// The plane gives m v^2; half of it is lost on the way to the speed of the plane.
		CHECK(std::abs(w.walls.before + w.walls.after - 20) < 1e-13);
		CHECK(std::abs(w.impact.before + w.impact.after - 1) < 1e-13);
		CHECK(std::abs(w.friction.before + w.friction.after - 9) < 1e-13);
	}
}
