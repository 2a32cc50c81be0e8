#include "Problems.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/Residual.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Nearest point of Coulomb's cone.
template <int dim> Vec<dim> nearestOnCone(const Vec<dim>& r, const Vec<dim>& n, double mu)
{
	const double rn = r.dot(n);
	const Vec<dim> rt = r - rn * n;
	if (rt.norm() <= mu * rn) return r;
	const double normal = (rn + mu * rt.norm()) / (1 + mu * mu);
	if (normal <= 0) return Vec<dim>::Zero();
	return normal * (n + mu * rt.normalized());
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Cone: the map keeps impulses that satisfy the conditions, and no others",
		       "[contact]", ((int dim), dim), 2, 3)
{
	Random random(1);
	for (int trial = 0; trial < 100; ++trial) {
		const Vec<dim> n = random.direction<dim>();
		const double mu = random.uniform(0.1, 3), W = random.uniform(0.2, 5),
			     b = random.uniform(-1, 1), pressed = random.uniform(0.1, 1);
		Vec<dim> t = random.vector<dim>();
		t = (t - t.dot(n) * n).normalized();
		auto changed = [&](const Vec<dim>& r, const Vec<dim>& u) {
			return (solvedContact<dim>(r, u, n, b, 1 / W, mu) - r).norm();
		};
		const Vec<dim> stuck = pressed * (n + random.uniform(-0.8, 0.8) * mu * t),
			       sliding = pressed * (n - mu * t), none = Vec<dim>::Zero();
		CHECK(changed(stuck, -b * n) < 1e-13);
		CHECK(changed(sliding, -b * n + t) < 1e-13);
		CHECK(changed(none, (0.1 - b) * n + t) == 0);

		CHECK(changed(sliding, -b * n - t) > 0.01);         // slides with the force
		CHECK(changed(0.5 * stuck, (-b - 0.1) * n) > 0.01); // sinks in
		CHECK(changed(stuck, (-b + 0.1) * n) > 0.01);       // pressed and opening
		CHECK(changed(0.5 * stuck, -b * n + t) > 5e-4);     // slides below the bound
		CHECK(changed(none, (-b - 0.1) * n) > 0.01);
		const Vec<dim> tooMuch = pressed * (n - 2 * mu * t);
		CHECK(changed(tooMuch, -b * n) > 0.01);

		// with the nearest point of the cone a sliding contact would be torn open
		const Vec<dim> trial1 = sliding - t / W;
		CHECK((nearestOnCone<dim>(trial1, n, mu) - sliding).norm() > 0.01);
	}
}

TEST_CASE("Residual: no unit, 0 for nothing, 1 for impulses that are missing", "[contact]")
{
	ResidualSum nothing;
	CHECK(nothing.value() == 0);
	nothing.add<2>(Vec<2>::Zero(), Vec<2>::Zero(), 3);
	CHECK(nothing.value() == 0);
	ResidualSum missing;
	missing.add<2>(Vec<2>::Zero(), Vec<2>(1e-30, 0), 3);
	CHECK(missing.value() == 1);
	ResidualSum wrong;
	wrong.add<2>(Vec<2>(1, 0), Vec<2>(1.01, 0), 1. / 3);
	wrong.add<2>(Vec<2>(0, 2), Vec<2>(0, 2), 1. / 5);
	CHECK(std::abs(wrong.value() - 0.01 / std::sqrt(3.) / std::sqrt(1.01 * 1.01 / 3 + 4. / 5)) <
	      1e-15);

	auto problem = randomProblem<2>(3, 6, 20, 0.5);
	solve(problem, 1e-2, 1000);
	auto scaled = problem; // other units of mass, length and time
	const double mass = 1e5, length = 1e-6, time = 1e-3;
	for (double& W : scaled.delassus.value)
		W /= mass;
	for (int k = 0; k < problem.contacts(); ++k) {
		scaled.freeVelocity[k] *= length / time;
		scaled.bias[k] *= length / time;
		scaled.impulse[k] *= mass * length / time;
	}
	CHECK(problem.residual() > 1e-5);
	CHECK(std::abs(scaled.residual() / problem.residual() - 1) < 1e-8);
}

TEMPLATE_TEST_CASE_SIG("Problem: random contacts are solved to any tolerance", "[contact]",
		       ((int dim), dim), 2, 3)
{
	States seen;
	for (double friction : { 0., 0.3, 1. })
		for (unsigned seed = 1; seed <= 10; ++seed) {
			auto problem = randomProblem<dim>(seed, 12, 40, friction);
			for (double tolerance : { 1e-2, 1e-6, 1e-13 }) {
				const SolverReport report = solve(problem, tolerance, 100000);
				CAPTURE(friction, seed, tolerance, report.sweeps);
				CHECK(report.converged);
				CHECK(report.residual <= tolerance);
				CHECK(std::abs(problem.residual() - report.residual) < 1e-13);
			}
			CAPTURE(friction, seed);
			seen += checkConditions(problem, 1e-9);
		}
	CHECK(seen.open > 100);
	CHECK(seen.stick > 10);
	CHECK(seen.slip > 100);
}

TEMPLATE_TEST_CASE_SIG("Problem: a tower carries its weight, by redundant contacts too",
		       "[contact]", ((int dim), dim), 2, 3)
{
	const int blocks = 12;
	for (int redundancy : { 1, 4 })
		for (double friction : { 0., 0.3, 10. }) {
			auto problem = tower<dim>(blocks, redundancy, friction);
			const SolverReport report = solve(problem, 1e-12, 100000);
			CAPTURE(redundancy, friction, report.sweeps, report.residual);
			CHECK(report.converged);
			checkConditions(problem, 1e-9);
			for (int b = 0; b < blocks; ++b) { // unit masses fall at 0.1
				double carried = 0;
				for (int k = 0; k < redundancy; ++k)
					carried += problem.impulse[b * redundancy + k][dim - 1];
				CHECK(std::abs(carried - 0.1 * (blocks - b)) < 1e-9);
			}
		}
}

TEST_CASE("Problem: the cap on sweeps ends what is not solved, and says so", "[contact]")
{
	auto problem = tower<2>(30, 1, 0.3);
	const SolverReport capped = solve(problem, 1e-12, 7);
	CHECK(capped.sweeps == 7);
	CHECK(!capped.converged);
	CHECK(capped.residual > 1e-12);
	CHECK(std::abs(capped.residual - problem.residual()) < 1e-13);

	problem.start = problem.impulse; // and others can go on from there
	const SolverReport rest = solve(problem, 1e-12, 100000);
	CHECK(rest.converged);
	problem.start = problem.impulse;
	CHECK(solve(problem, 1e-11, 1).converged); // a sweep shuffles the rounding
}

/// Gauss-Seidel need not converge with strong friction in a hyperstatic problem; here it cycles.
TEST_CASE("Problem: what the sweeps cannot solve is not called solved", "[contact]")
{
	auto problem = randomProblem<2>(10, 12, 40, 3);
	const SolverReport report = solve(problem, 1e-6, 20000);
	CHECK(!report.converged);
	CHECK(report.sweeps == 20000);
	CHECK(report.residual > 1e-4);
	CHECK(std::abs(problem.residual() - report.residual) < 1e-12);
	for (int k = 0; k < problem.contacts(); ++k) {
		const Vec<2>&n = problem.normal[k], &r = problem.impulse[k];
		const double rn = r.dot(n);
		CHECK(rn >= 0); // admissible all the same
		CHECK((r - rn * n).norm() <= problem.friction[k] * rn * (1 + 1e-12));
	}
}

TEST_CASE("Problem: separating contacts have no impulse, whatever they start from", "[contact]")
{
	auto problem = tower<3>(5, 2, 0.5);
	for (Vec<3>& u : problem.freeVelocity)
		u = Vec<3>(0.3, 0, 0.2);
	Random random(1);
	for (Vec<3>& r : problem.start)
		r = random.vector<3>();
	const SolverReport report = solve(problem, 1e-2, 100);
	CHECK(report.converged);
	CHECK(report.residual == 0);
	CHECK(report.active == 0);
	for (const Vec<3>& r : problem.impulse)
		CHECK(r.isZero(0));
}

TEST_CASE("Problem: the same bits every time", "[contact]")
{
	auto a = randomProblem<3>(5, 12, 40, 1), b = a;
	const SolverReport first = solve(a, 1e-8, 10000), second = solve(b, 1e-8, 10000);
	CHECK(first.sweeps == second.sweeps);
	CHECK(first.residual == second.residual);
	for (int k = 0; k < a.contacts(); ++k)
		CHECK(a.impulse[k] == b.impulse[k]);
}
