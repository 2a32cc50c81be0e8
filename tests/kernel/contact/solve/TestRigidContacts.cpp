#include "Helpers.hpp"
#include "contact/solve/ContactConditions.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/Sharing.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>

using Catch::Matchers::WithinRel;
using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Rigid bodies alone, in a step of 1 s.
template <int dim> struct RigidBodies {
	std::vector<ContactBody<dim>> none;
	std::vector<RigidPartner<dim>> body;
	std::vector<RigidContact<dim>> contacts;
	ContactSolver<dim> solver;
	SolverSettings settings;

	SolverReport solve(double tolerance, int maxSweeps = 100000, int threads = 1)
	{
		settings.tolerance = tolerance;
		settings.maxSweeps = maxSweeps;
		solver.plan({}, static_cast<int>(none.size()), &body, &contacts);
		solver.prepare(none, 1, settings, threads);
		return solver.solve();
	}
	Vec<dim> velocityAt(const RigidContact<dim>& c) const
	{
		const Vec<dim> image = body[c.second].centre + c.imageShift;
		return body[c.second].velocityAt(c.point - image) + c.imageVelocity -
		       body[c.first].velocityAt(c.point - body[c.first].centre);
	}
	/// Of all free bodies, at the velocities of that time, J.
	double kinetic(Vec<dim> RigidPartner<dim>::* velocity,
		       Spin<dim> RigidPartner<dim>::* spin) const
	{
		double sum = 0;
		for (const RigidPartner<dim>& p : body)
			sum += 0.5 * p.massProduct(p.*velocity, p.*spin, p.*velocity, p.*spin);
		return sum;
	}
};

/// The first body is held.
template <int dim> RigidBodies<dim> looseBodies(Random& random, int count)
{
	RigidBodies<dim> bodies;
	bodies.body.resize(count);
	for (RigidPartner<dim>& p : bodies.body) {
		p.centre = random.vector<dim>();
		p.velocity = random.vector<dim>();
		p.spin = random.vector<spins<dim>>();
		p.inverseMass.setConstant(random.uniform(0.5, 2));
		p.inverseInertia.setIdentity();
		p.inverseInertia *= random.uniform(1, 5);
	}
	bodies.body[0].inverseMass.setZero();
	bodies.body[0].inverseInertia.setZero();
	return bodies;
}

/// `offset`: how far arms are from the normal, over their length.
template <int dim>
void addContact(RigidBodies<dim>& bodies, Random& random, int a, int b, double friction,
		double offset)
{
	const Vec<dim> arm = bodies.body[b].centre - bodies.body[a].centre;
	RigidContact<dim> c;
	c.first = a;
	c.second = b;
	c.point = bodies.body[a].centre + random.uniform(0.2, 0.8) * arm;
	c.normal = (arm.normalized() + offset * random.direction<dim>()).normalized();
	c.gap = random.uniform(0, 0.1);
	c.size = 1;
	c.friction = friction;
	c.impulse = random.vector<dim>(); // a bad start
	bodies.contacts.push_back(c);
}

/// Bodies that touch at random places.
template <int dim>
RigidBodies<dim> randomBodies(unsigned seed, int count, double share, double friction,
			      double offset)
{
	Random random(seed);
	auto bodies = looseBodies<dim>(random, count);
	for (int a = 0; a < count; ++a)
		for (int b = a + 1; b < count; ++b)
			if (random.uniform(0, 1) <= share)
				addContact(bodies, random, a, b, friction, offset);
	return bodies;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("contacts of rigid bodies hold all conditions, one by one", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	ContactConditions conditions(0.6);
	for (const double offset : { 0., 0.3 })
		for (unsigned seed = 1; seed < 15; ++seed) {
			auto bodies = randomBodies<dim>(seed, 6, 0.4, 0.6, offset);
			auto anew = bodies;
			const SolverReport report = bodies.solve(1e-13);
			REQUIRE(report.converged);
			for (const RigidContact<dim>& c : bodies.contacts) {
				auto push = [&](int k, const Vec<dim>& J) {
					RigidPartner<dim>& p = anew.body[k];
					if (p.moves()) p.push(c.point - p.centre, J);
				};
				push(c.first, -c.impulse);
				push(c.second, c.impulse);
			}
			for (const RigidContact<dim>& c : bodies.contacts) {
				const Vec<dim>&n = c.normal, &r = c.impulse;
				const Vec<dim> u = anew.velocityAt(c);
				CHECK((u - bodies.velocityAt(c)).norm() < 1e-11);
				conditions.check<dim>(n, r, u, c.gap);
			}
		}
	CHECK(conditions.open > 10);
	CHECK(conditions.stick > 3);
	CHECK(conditions.slip > 10);
}

TEMPLATE_TEST_CASE_SIG("a body and its image that moves along with it are the same partner",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	auto here = randomBodies<dim>(3, 6, 0.6, 0.5, 0.2);
	auto there = here;
	Random random(4);
	for (RigidContact<dim>& c : there.contacts) {
		c.imageShift = random.vector<dim>(); // its body lies elsewhere,
		there.body.push_back(there.body[c.second]);
		there.body.back().centre -= c.imageShift;
		there.body.back().inverseMass.setZero();
		there.body.back().inverseInertia.setZero();
		c.imageVelocity = random.vector<dim>(); // and moves otherwise
		there.body.back().velocity -= c.imageVelocity;
		c.second = static_cast<int>(there.body.size()) - 1;
	}
	for (std::size_t k = 0; k < here.contacts.size(); ++k) { // held in both
		RigidContact<dim>& c = here.contacts[k];
		here.body.push_back(here.body[c.second]);
		here.body.back().inverseMass.setZero();
		here.body.back().inverseInertia.setZero();
		c.second = static_cast<int>(here.body.size()) - 1;
	}
	REQUIRE(here.solve(1e-13).converged);
	REQUIRE(there.solve(1e-13).converged);
	for (std::size_t k = 0; k < here.contacts.size(); ++k)
		CHECK((here.contacts[k].impulse - there.contacts[k].impulse).norm() < 1e-10);
}

TEMPLATE_TEST_CASE_SIG("work of contacts between rigid bodies is the change of kinetic energy",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	auto bodies = randomBodies<dim>(5, 8, 0.5, 0.4, 0.3);
	Random random(6);
	for (RigidContact<dim>& c : bodies.contacts)
		c.imageVelocity = 0.3 * random.vector<dim>();
	bodies.body[1].inverseMass[0] = 0; // held along one axis
	bodies.body[2].inverseInertia.setZero();
	for (RigidPartner<dim>& p : bodies.body) {
		p.velocityBefore = p.velocity;
		p.spinBefore = p.spin;
	}
	using Body = RigidPartner<dim>;
	const double before = bodies.kinetic(&Body::velocityBefore, &Body::spinBefore);
	REQUIRE(bodies.solve(1e-10).converged);
	const double after = bodies.kinetic(&Body::velocity, &Body::spin);
	const ContactWork work = bodies.solver.rigidWork();
	auto sum = [](const ContactWork::Halves& halves) { return halves.before + halves.after; };
	CHECK(sum(work.friction) > 0.01 * before);
	CHECK(std::abs(sum(work.walls)) > 1e-3 * before);
	CHECK(std::abs(sum(work.cell)) > 1e-3 * before);
	const double done =
		sum(work.walls) + sum(work.cell) - sum(work.friction) - sum(work.impact);
	CHECK(std::abs(after - before - done) < 1e-12 * before);
}

TEST_CASE("a stack of ten bears its weight", "[rigid]")
{
	RigidBodies<2> stack;
	const double mass = 2, weight = 3, radius = 0.5;
	stack.body.resize(11);
	for (int k = 0; k <= 10; ++k) {
		RigidPartner<2>& p = stack.body[k];
		p.centre = Vec<2>(0, 2 * radius * k);
		if (k == 0) continue; // the floor
		p.inverseMass.setConstant(1 / mass);
		p.inverseInertia(0, 0) = 2 / (mass * radius * radius);
		p.velocity = Vec<2>(0, -weight / mass); // after a step of 1 s
		stack.contacts.push_back({ k - 1, k, Vec<2>(0, (2 * k - 1) * radius), Vec<2>(0, 1),
					   0, 1, 0.5, Vec<2>::Zero() });
	}
	const SolverReport report = stack.solve(1e-13);
	REQUIRE(report.converged);
	CHECK(report.active == 10);
	for (int k = 0; k < 10; ++k)
		CHECK((stack.contacts[k].impulse - Vec<2>(0, (10 - k) * weight)).norm() < 1e-9);
	// warm: the same problem again needs no work
	for (int k = 1; k <= 10; ++k) {
		stack.body[k].velocity = Vec<2>(0, -weight / mass);
		stack.body[k].spin.setZero();
	}
	CHECK(stack.solve(1e-9).sweeps == 4);
}

TEST_CASE("rigid bodies that overlap are moved apart without speed, a little stays", "[rigid]")
{
	for (const double gap : { -0.5, -0.5e-3 }) {
		RigidBodies<3> three; // the third lies on the second and is not to be run into
		three.body.resize(3);
		for (int k = 0; k < 3; ++k) {
			three.body[k].centre = Vec<3>(0, 0, k);
			three.body[k].inverseMass.setOnes();
		}
		for (int k = 0; k < 2; ++k)
			three.contacts.push_back({ k, k + 1, Vec<3>(0, 0, k + 0.5), Vec<3>(0, 0, 1),
						   k == 0 ? gap : 0, 1, 0, Vec<3>::Zero() });
		three.solve(1e-13);
		three.solver.separateRigidBodies(1);
		const double expected = gap < -1e-3 ? 0.1 * (-gap - 1e-3) : 0;
		double sum = 0;
		for (const RigidPartner<3>& p : three.body) {
			CHECK(p.velocity.isZero(0));
			sum += p.shift[2];
		}
		CHECK(std::abs(three.body[1].shift[2] - three.body[0].shift[2] - expected) < 1e-4);
		CHECK(three.body[2].shift[2] >= three.body[1].shift[2] - 1e-15);
		CHECK(std::abs(sum) < 1e-15);
	}
}

TEST_CASE("what is held along the normal bears nothing", "[rigid]")
{
	RigidBodies<2> pair;
	pair.body.resize(2);
	pair.body[1].inverseMass = Vec<2>(1, 0); // moves across only
	pair.body[1].velocity = Vec<2>(1, -1);
	pair.contacts.push_back({ 0, 1, Vec<2>(0, 0), Vec<2>(0, 1), 0, 1, 0.5, Vec<2>(0, 1) });
	const SolverReport report = pair.solve(1e-10);
	CHECK(report.converged);
	CHECK(pair.contacts[0].impulse.isZero(0));
	CHECK(pair.body[1].velocity == Vec<2>(1, -1));
}

TEST_CASE("rigid contacts: the same bits with any number of threads", "[rigid]")
{
	constexpr int side = 60; // threads share what has the work of some hundred pairs of grains
	auto solved = [](int threads) {
		Random random(5);
		auto bodies = looseBodies<3>(random, side * side);
		for (const BodiesOfPair& pair : latticeOf(side)) {
			addContact(bodies, random, pair.first, pair.second, 0.4, 0.2);
			if (random.index(3) == 0) bodies.contacts.back().gap = -0.02;
		}
		REQUIRE(threadsThatShare<3>(std::vector<ContactList<3>>(), bodies.none, bodies.body,
					    bodies.contacts, threads) == threads);
		const SolverReport report = bodies.solve(1e-3, 1000, threads);
		CHECK(report.active > 2000);
		bodies.solver.separateRigidBodies(1);
		int displaced = 0;
		std::vector<double> bits { report.residual, report.sweeps,
					   bodies.solver.rigidWork().friction.after };
		auto note = [&](const Vec<3>& v) { bits.insert(bits.end(), v.begin(), v.end()); };
		for (const RigidContact<3>& c : bodies.contacts)
			note(c.impulse);
		for (const RigidPartner<3>& p : bodies.body) {
			for (const Vec<3>& v : { p.velocity, p.spin, p.shift, p.turn })
				note(v);
			displaced += p.isDisplaced();
		}
		CHECK(displaced > 1000);
		return bits;
	};
	const auto one = solved(1);
	CHECK(solved(2) == one);
	CHECK(solved(3) == one);
}

TEST_CASE("rigid contacts: what closes leaves with e times its speed, the rest does not", "[rigid]")
{
	const double e = 0.6;
	auto after = [&](double gap, double speedBefore, double freeSpeed) {
		RigidBodies<2> pair; // steps of 1 s
		pair.body.resize(2);
		pair.body[1].inverseMass.setOnes();
		pair.body[1].velocityBefore = Vec<2>(0, speedBefore);
		pair.body[1].velocity = Vec<2>(0, freeSpeed);
		pair.contacts.push_back(
			{ 0, 1, Vec<2>(0, 0), Vec<2>(0, 1), gap, 1, 0.5, Vec<2>(0, 0) });
		pair.contacts[0].restitution = e;
		REQUIRE(pair.solve(1e-13).converged);
		return pair.body[1].velocity[1];
	};
	CHECK(std::abs(after(0.5, -1, -1.2) - e) < 1e-12);   // closes
	CHECK(std::abs(after(-0.1, -1, -1.2) - e) < 1e-12);  // has closed
	CHECK(std::abs(after(1.1, -1, -1.2) + 1.1) < 1e-12); // closes by what acts in this step
	CHECK(std::abs(after(2, -1, -1.2) + 1.2) < 1e-12);   // does not
	CHECK(std::abs(after(0, 0, -0.2)) < 1e-12);          // rests
	CHECK(std::abs(after(0, 1, 0.8) - 0.8) < 1e-12);     // leaves
}

TEMPLATE_TEST_CASE_SIG("rigid contacts: an impact without friction leaves e^2 of its energy",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	using Body = RigidPartner<dim>;
	int impacts = 0;
	for (const double e : { 0.5, 1. })
		for (unsigned seed = 1; seed < 30; ++seed) {
			auto bodies = randomBodies<dim>(seed, 2, 1, 0, 0.3);
			bodies.body[0].velocity.setZero(); // it is held
			bodies.body[0].spin.setZero();
			for (Body& p : bodies.body) {
				p.velocityBefore = p.velocity;
				p.spinBefore = p.spin;
			}
			RigidContact<dim>& c = bodies.contacts[0];
			c.restitution = e;
			c.gap = 0;
			c.impulse.setZero();
			const double speed = bodies.velocityAt(c).dot(c.normal);
			if (speed > 0) continue;
			++impacts;
			REQUIRE(bodies.solve(1e-13).converged);
			CHECK(std::abs(bodies.velocityAt(c).dot(c.normal) + e * speed) < 1e-12);
			const double lost = -0.5 * (1 - e) * speed * c.impulse.dot(c.normal);
			const double before =
				bodies.kinetic(&Body::velocityBefore, &Body::spinBefore);
			const double after = bodies.kinetic(&Body::velocity, &Body::spin);
			const auto impact = bodies.solver.rigidWork().impact;
			CHECK(std::abs(impact.before + impact.after - lost) < 1e-12);
			CHECK(std::abs(before - after - lost) < 1e-12);
		}
	CHECK(impacts > 10);
}

TEST_CASE("Rigid contacts: where friction lifts, some passes solve one that slides")
{
	for (const double friction : { 0.3, 1., 2., 5. }) {
		// friction to the left turns the place upwards: W_nt/W_nn = -1
		TwoStepContact<2> contact;
		contact.normal = Vec<2>::UnitY();
		contact.bias = 0;
		Mat<2> W;
		W << 3, -1, -1, 1;
		REQUIRE(contact.setMobility(W));
		contact.begin(Vec<2>::Zero());
		const Vec<2> free(10, -0.1);
		for (int pass = 0; pass < 4; ++pass)
			contact.impulse = contact.solvedAt(free + W * contact.impulse, friction);
		const double normal = 0.1 / (1 + friction);
		REQUIRE_THAT(contact.impulse[1], WithinRel(normal, 1e-12));
		REQUIRE_THAT(contact.impulse[0], WithinRel(-friction * normal, 1e-12));
	}
}
