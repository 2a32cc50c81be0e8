#include "contact/solve/ContactConditions.hpp"
#include "contact/solve/Mixture.hpp"
#include "contact/solve/Sharing.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEMPLATE_TEST_CASE_SIG("contact with rigid bodies holds all conditions, one by one", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	ContactConditions conditions(0.6);
	States ofEnds;
	for (const double offset : { 0., 0.5 })
		for (unsigned seed = 1; seed < 15; ++seed) {
			Mixture<dim> mixture(seed, 6, 3, 0.6, offset);
			Mixture<dim> anew = mixture;
			const Mixture<dim> before = mixture;
			const SolverReport report = mixture.solve(1e-13);
			REQUIRE(report.converged);
			anew.lists = mixture.lists;
			Mixture<dim> warm = anew; // the same problem again needs no work
			CHECK(warm.solve(1e-10).sweeps <= 4);
			anew.push();
			for (const ContactList<dim>& list : mixture.lists)
				for (const Contact<dim>& c : list.contacts) {
					const Spin<dim>& spin =
						before.partner[list.rigid->partner].spin;
					const Vec<dim> u = anew.velocityAt(list, c, spin);
					CHECK((u - mixture.velocityAt(list, c, spin)).norm() <
					      1e-11);
					const States last = conditions;
					conditions.check<dim>(mixture.normalOf(c),
							      mixture.impulseOf(c), u,
							      mixture.biasOf(list, c));
					if (c.key.side == 0) continue;
					ofEnds.stick += conditions.stick - last.stick;
					ofEnds.slip += conditions.slip - last.slip;
				}
			for (std::size_t g = 0; g < mixture.body.size(); ++g)
				for (int i = 0; i < GrainTables::nodes; ++i)
					CHECK((anew.body[g].impulse[i] - mixture.body[g].impulse[i])
						      .norm() < 1e-12);
		}
	CHECK(conditions.open > 10);
	CHECK(conditions.stick > 3);
	CHECK(conditions.slip > 10);
	CHECK(ofEnds.stick > 1);
	CHECK(ofEnds.slip > 5);
}

TEMPLATE_TEST_CASE_SIG("the impulse of a pair with a rigid body, and its moment about the pivot",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	Mixture<dim> mixture(3, 12, 3, 0.6, 0.5);
	mixture.solve(1e-10);
	int active = 0;
	for (const ContactList<dim>& list : mixture.lists) {
		Vec<dim> sum = Vec<dim>::Zero();
		Spin<dim> turning = Spin<dim>::Zero();
		for (const Contact<dim>& c : list.contacts) {
			const Vec<dim> r = mixture.impulseOf(c);
			sum += r;
			turning -= moment<dim>(mixture.placeOf(list, c) - list.rigid->pivot, r);
			active += !r.isZero(0);
		}
		CHECK((list.impulse.normal + list.impulse.shear - sum).norm() < 1e-13);
		CHECK((list.impulse.moment - turning).norm() < 1e-13);
	}
	CHECK(active > 5);
}

TEMPLATE_TEST_CASE_SIG("work of contacts with rigid bodies is the change of kinetic energy",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	Mixture<dim> mixture(5, 8, 4, 0.4, 0.3);
	const Mixture<dim> before = mixture;
	REQUIRE(mixture.solve(1e-10).converged);
	const ContactWork work = mixture.solver.work();
	auto sum = [](const ContactWork::Halves& halves) { return halves.before + halves.after; };
	const double walls = sum(work.walls), cell = sum(work.cell),
		     lost = sum(work.friction) + sum(work.impact);
	const double start = before.kineticOfGrains();
	CHECK(sum(work.friction) > 1e-3 * start);
	CHECK(std::abs(walls) > 1e-3 * start);
	CHECK(std::abs(cell) > 1e-3 * start);
	CHECK(std::abs(mixture.kineticOfGrains() - start - (walls + cell - lost)) < 1e-12 * start);
	// what the held one gives comes from outside
	double outside = 0;
	for (const ContactList<dim>& list : mixture.lists)
		for (const Contact<dim>& c : list.contacts)
			if (list.rigid->partner == 0)
				outside += mixture.impulseOf(c).dot(
					mixture.partner[0].velocityAt(mixture.armOf(list, c)));
	const double given = before.kineticOfFreeBodies() - mixture.kineticOfFreeBodies();
	CHECK(std::abs(walls - outside - given) < 1e-12 * start);
}

TEMPLATE_TEST_CASE_SIG("one contact with a ball is solved by one visit", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	int closed[2] = { 0, 0 }; // by side
	for (unsigned seed = 1; seed < 40; ++seed) {
		Mixture<dim> mixture(seed, 1, 2);
		ContactList<dim>& list = mixture.addList(0, 1, 0.5, 0);
		list.rigid->surface = BallSurface<dim> { mixture.centreOf(list, 1), 1 };
		list.contacts.resize(1);
		mixture.solve(1e-300, 1);
		CHECK(mixture.solver.residual() < 1e-14);
		closed[list.contacts[0].key.side] += !list.contacts[0].impulse.isZero(0);
	}
	CHECK(closed[0] > 5);
	CHECK(closed[1] > 5);
}

namespace {

/// Grains and free rigid bodies in turn in a square lattice, neighbours in contact.
template <int dim> Mixture<dim> chessboard(int side)
{
	Mixture<dim> board(7, side * side / 2, side * side / 2);
	auto touch = [&](int site, int other) {
		const bool grainFirst = (site / side + site) % 2 == 0;
		board.addList((grainFirst ? site : other) / 2, (grainFirst ? other : site) / 2, 0.4,
			      0.2);
	};
	for (int i = 0; i < side; ++i)
		for (int j = 0; j + 1 < side; ++j) {
			touch(i * side + j, i * side + j + 1);
			touch(j * side + i, (j + 1) * side + i);
		}
	return board;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("contact with free rigid bodies: the same bits with any number of threads",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	auto solved = [](int threads) {
		Mixture<dim> board = chessboard<dim>(24);
		REQUIRE(threadsThatShare<dim>(board.lists, board.body, board.partner, {},
					      threads) == threads);
		const SolverReport report = board.solve(1e-6, 1000, threads);
		CHECK(report.active > 300);
		std::vector<double> bits { report.residual, report.sweeps,
					   board.solver.work().friction.after };
		auto note = [&](const auto& vector) {
			bits.insert(bits.end(), vector.data(), vector.data() + vector.size());
		};
		for (const ContactList<dim>& list : board.lists) {
			note(list.impulse.moment);
			for (const Contact<dim>& c : list.contacts)
				note(c.impulse);
		}
		for (const ContactBody<dim>& b : board.body)
			for (const auto* field : { &b.velocity, &b.impulse })
				for (const Vec<dim>& v : *field)
					note(v);
		for (const RigidPartner<dim>& p : board.partner) {
			note(p.velocity);
			note(p.spin);
		}
		return bits;
	};
	const auto one = solved(1);
	CHECK(solved(2) == one);
	CHECK(solved(3) == one);
}

TEST_CASE("the contact problem as data names what it cannot hold", "[rigid]")
{
	Mixture<2> mixture(1, 4, 2, 0.3, 0);
	mixture.solve(1e-10);
	CHECK_THROWS_AS(mixture.solver.problem(), std::logic_error);

	Mixture<2> held(1, 4, 1, 0.3, 0);
	held.solve(1e-10);
	const ContactProblem<2> problem = held.solver.problem();
	CHECK(problem.contacts() > 0);
	CHECK(problem.residual() < 1e-9);
}
