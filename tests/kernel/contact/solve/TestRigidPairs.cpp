#include "Helpers.hpp"
#include "contact/solve/ContactConditions.hpp"
#include "contact/solve/ContactSolver.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <deque>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Single nodes of mass 1 and rigid bodies that touch each other at random places, in a step of 1
/// s.
template <int dim> struct Mixture {
	SparseRows<double> table;
	OutlineMesh<dim> mesh;
	std::vector<ContactBody<dim>> body;
	std::vector<RigidPartner<dim>> partner;
	std::vector<Spin<dim>> freeSpin; ///< of each, without impulses
	std::deque<ContactList<dim>> lists;
	ContactSolver<dim> solver;
	SolverSettings settings;

	/// `offset`: how far arms are from the normal, over their length.
	Mixture(unsigned seed, int nodes, int partners, double friction, double offset)
		: body(nodes)
		, partner(partners)
	{
		Random random(seed);
		table.append(0, 1);
		table.closeRow();
		for (ContactBody<dim>& b : body) {
			b.mesh = &mesh;
			b.delassus = &table;
			b.delassusScale = random.uniform(0.5, 2);
			b.position = { random.vector<dim>() };
			b.velocity = b.velocityBefore = { random.vector<dim>() };
			b.impulse = { Vec<dim>::Zero() };
		}
		for (RigidPartner<dim>& p : partner) {
			p.velocity = p.velocityBefore = random.vector<dim>();
			p.spin = random.vector<spins<dim>>();
			freeSpin.push_back(p.spin);
			p.inverseMass.setConstant(random.uniform(0.5, 2));
			p.inverseInertia.setIdentity();
			p.inverseInertia *= random.uniform(1, 5);
		}
		if (partners > 0) { // one body is held
			partner[0].inverseMass.setZero();
			partner[0].inverseInertia.setZero();
		}
		for (int g = 0; g < nodes; ++g)
			for (int p = 0; p < partners; ++p)
				if (random.uniform(0, 1) < 0.5)
					addList(random, g, p, friction, offset);
	}
	void addList(Random& random, int g, int p, double friction, double offset)
	{
		ContactList<dim> list;
		list.first = g;
		list.second = -1 - p;
		list.friction = friction;
		list.rigid.emplace();
		list.rigid->surface = BlockSurface<dim>();
		list.rigid->partner = p;
		list.rigid->moves = partner[p].moves();
		Contact<dim> contact;
		contact.key = { 0, 0, -1 };
		const Vec<dim> arm = body[g].position[0] - partner[p].centre;
		contact.normal = (arm.normalized() + offset * random.direction<dim>()).normalized();
		contact.gap = random.uniform(0, 0.1);
		list.contacts = { contact };
		lists.push_back(list);
	}
	SolverReport solve(double tolerance, int maxSweeps = 10000)
	{
		settings.tolerance = tolerance;
		settings.maxSweeps = maxSweeps;
		std::vector<ContactList<dim>*> pointers;
		for (ContactList<dim>& list : lists)
			pointers.push_back(&list);
		solver.plan(pointers, static_cast<int>(body.size()), &partner);
		solver.prepare(body, 1, settings);
		return solver.solve();
	}
	/// From the centre of the rigid body.
	Vec<dim> armOf(const ContactList<dim>& list) const
	{
		return body[list.first].position[0] - partner[list.rigid->partner].centre;
	}
	/// Relative velocity at the contact of a list, at the place on the rigid body half a step
	/// later, as far as that moves along the surface.
	Vec<dim> velocityAt(const ContactList<dim>& list) const
	{
		const int p = list.rigid->partner;
		const Vec<dim> arm = armOf(list), &n = list.contacts[0].normal;
		const Vec<dim> turn = 0.5 * spinCross<dim>(freeSpin[p], arm);
		const Vec<dim> gained = spinCross<dim>(freeSpin[p], turn);
		return body[list.first].velocity[0] - partner[p].velocityAt(arm) -
		       (gained - gained.dot(n) * n);
	}
};

} // namespace

TEMPLATE_TEST_CASE_SIG("contact with rigid bodies holds all conditions, one by one", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	ContactConditions conditions(0.6);
	for (const double offset : { 0., 0.5 })
		for (unsigned seed = 1; seed < 15; ++seed) {
			Mixture<dim> mixture(seed, 6, 3, 0.6, offset);
			const Mixture<dim> before = mixture;
			const SolverReport report = mixture.solve(1e-13);
			REQUIRE(report.converged);
			// velocities anew from the impulses found
			Mixture<dim> anew = before;
			for (const ContactList<dim>& list : mixture.lists) {
				const Vec<dim>& r = list.contacts[0].impulse;
				ContactBody<dim>& b = anew.body[list.first];
				RigidPartner<dim>& p = anew.partner[list.rigid->partner];
				b.velocity[0] += b.delassusScale * r;
				p.push(anew.armOf(list), -r);
			}
			for (const ContactList<dim>& list : mixture.lists) {
				const Vec<dim>&n = list.contacts[0].normal,
				      &r = list.contacts[0].impulse;
				const Vec<dim> u = anew.velocityAt(list);
				CHECK((u - mixture.velocityAt(list)).norm() < 1e-11);
				conditions.check<dim>(n, r, u, list.contacts[0].gap);
			}
		}
	CHECK(conditions.open > 10);
	CHECK(conditions.stick > 3);
	CHECK(conditions.slip > 10);
}

TEMPLATE_TEST_CASE_SIG("one contact with a ball is solved by one visit", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	for (unsigned seed = 1; seed < 10; ++seed) {
		Mixture<dim> mixture(seed, 1, 2, 0.5, 0);
		while (mixture.lists.size() > 1)
			mixture.lists.pop_front();
		if (mixture.lists.empty()) continue;
		mixture.solve(1e-300, 1);
		CHECK(mixture.solver.residual() < 1e-14);
	}
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
