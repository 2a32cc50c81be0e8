#include "Threads.hpp"
#include "contact/solve/Sharing.hpp"
#include "step/Scene.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Soft grains and free rigid balls of the density of disks (balls), driven as the host does.
template <int dim> struct Mixed {
	Scene<dim> scene;
	std::vector<RigidPartner<dim>> partner;
	std::vector<double> radius;
	Vec<dim> gravity = Vec<dim>::Zero();

	void addBall(const Vec<dim>& centre, double R, double density, const Vec<dim>& velocity,
		     double friction)
	{
		RigidPartner<dim> p;
		p.centre = centre;
		p.velocity = velocity;
		const double mass = density * M_PI * (dim == 2 ? R * R : 4. / 3 * R * R * R);
		if (density > 0) {
			p.inverseMass.setConstant(1 / mass);
			p.inverseInertia.setIdentity();
			p.inverseInertia /= (dim == 2 ? 0.5 : 0.4) * mass * R * R;
		}
		for (int g = 0; g < scene.system.grains(); ++g) {
			ContactList<dim> list;
			list.first = g;
			list.second = -1 - static_cast<int>(partner.size());
			list.friction = friction;
			list.rigid.emplace();
			list.rigid->partner = static_cast<int>(partner.size());
			scene.lists.push_back(list);
		}
		partner.push_back(p);
		radius.push_back(R);
	}
	StepReport advance(double dt)
	{
		for (ContactList<dim>& list : scene.lists) {
			if (!list.rigid) continue;
			const RigidPartner<dim>& p = partner[list.rigid->partner];
			const double R = radius[list.rigid->partner];
			list.rigid->surface = BallSurface<dim> { p.centre, R };
			list.rigid->pivot = p.centre;
			list.rigid->velocities = { p.velocity, R * p.spin.norm() };
		}
		for (RigidPartner<dim>& p : partner) {
			p.velocityBefore = p.velocity;
			p.spinBefore = p.spin;
			for (int a = 0; a < dim; ++a)
				if (p.inverseMass[a] > 0) p.velocity[a] += dt * gravity[a];
		}
		for (int g = 0; g < scene.system.grains(); ++g)
			scene.system.loads()[g].acceleration = gravity;
		scene.system.rigidPartners() = partner;
		const StepReport report = scene.advance(dt);
		partner = scene.system.rigidPartners();
		for (RigidPartner<dim>& p : partner)
			p.centre += dt * p.velocity;
		return report;
	}
	Vec<dim> momentum() const
	{
		Vec<dim> sum = scene.momentum();
		for (const RigidPartner<dim>& p : partner)
			if (p.moves()) sum += p.velocity.cwiseQuotient(p.inverseMass);
		return sum;
	}
	/// About the origin.
	Spin<dim> angularMomentum() const
	{
		Spin<dim> sum = Spin<dim>::Zero();
		for (int g = 0; g < scene.system.grains(); ++g) {
			const Batch<dim>& batch = scene.batchOf(g);
			const int lane = scene.laneOf(g);
			for (int I = 0; I < batch.reference->nodes(); ++I)
				sum += moment<dim>(batch.position(lane, I),
						   batch.nodeMass(lane, I) * batch.v.get(lane, I));
		}
		for (const RigidPartner<dim>& p : partner)
			if (p.moves())
				sum += moment<dim>(p.centre,
						   p.velocity.cwiseQuotient(p.inverseMass)) +
				       p.inverseInertia.inverse() * p.spin;
		return sum;
	}
};

/// A grain that is hit off its centre by a spinning ball, with friction.
template <int dim> Mixed<dim> collision(double zeta)
{
	Mixed<dim> mixed;
	mixed.scene.add(singleGrain<dim>(recipe(zeta)));
	mixed.scene.settings.trackEnergy = true;
	Vec<dim> centre = Vec<dim>::Zero();
	centre[0] = 0.0151;
	centre[1] = 0.004;
	mixed.addBall(centre, 0.006, 2000, -2 * Vec<dim>::Unit(0), 0.5);
	mixed.partner[0].spin.setConstant(50);
	return mixed;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("a free ball and a grain keep both momenta", "[rigid]", ((int dim), dim), 2,
		       3)
{
	Mixed<dim> mixed = collision<dim>(dim == 2 ? 0.2 : 0.4);
	const double dt = 0.4 * mixed.scene.system.criticalTimeStep();
	mixed.advance(dt);
	const Vec<dim> momentum = mixed.momentum();
	const Spin<dim> angular = mixed.angularMomentum();
	int touched = 0;
	for (int k = 0; k < 400; ++k)
		touched += mixed.advance(dt).solver.active > 0;
	CHECK(touched > 20);
	CHECK(mixed.scene.failures == 0);
	CHECK((mixed.momentum() - momentum).norm() < 1e-13 * momentum.norm());
	// forces at t_n and momenta half a step apart: internal forces of a deformed grain turn
	// with it
	CHECK((mixed.angularMomentum() - angular).norm() < 1e-3 * angular.norm());
	CHECK(mixed.partner[0].velocity[0] > -1.9);
	CHECK((mixed.partner[0].spin - Spin<dim>::Constant(50)).norm() > 5);
}

TEST_CASE("energy of a grain and a free ball closes", "[rigid]")
{
	Mixed<2> mixed = collision<2>(0.2);
	const double dt = 0.4 * mixed.scene.system.criticalTimeStep();
	auto kinetic = [&](const RigidPartner<2>& p) {
		return 0.5 * p.velocity.squaredNorm() / p.inverseMass[0] +
		       0.5 * p.spin.squaredNorm() / p.inverseInertia(0, 0);
	};
	const double start = kinetic(mixed.partner[0]);
	for (int k = 0; k < 400; ++k)
		mixed.advance(dt);
	const EnergyBalance e = mixed.scene.system.energy();
	CHECK(e.friction > 0);
	const double end =
		e.kinetic + e.elastic + e.friction + e.impact + kinetic(mixed.partner[0]);
	CHECK(std::abs(end - start) < 0.01 * start);
	CHECK(std::abs(e.walls - (start - kinetic(mixed.partner[0]))) < 1e-10 * start);
}

TEST_CASE("a ball rests on a grain, which rests on a plane", "[rigid]")
{
	Mixed<2> mixed;
	GrainParameters<2> grain = paperGrain<2>();
	grain.damping.mass = 200;
	mixed.scene.add(singleGrain<2>(recipe(0.2), grain));
	mixed.scene.addPlane(0, { 0, -0.01 }, { 0, 1 }, Vec<2>::Zero(), 0.3);
	mixed.gravity = { 0, -10 };
	mixed.addBall({ 0, 0.015 }, 0.005, 3000, Vec<2>::Zero(), 0.3);
	mixed.partner[0].inverseMass[0] = 0; // it may not fall to a side
	mixed.partner[0].inverseInertia.setZero();
	const double weight = 10 / mixed.partner[0].inverseMass[1];
	const double dt = 0.4 * mixed.scene.system.criticalTimeStep();
	for (int k = 0; k < 6000; ++k)
		mixed.advance(dt);
	const double height = mixed.partner[0].centre[1];
	double sum = 0;
	const int steps = 2000;
	for (int k = 0; k < steps; ++k) {
		mixed.advance(dt);
		const PairImpulse<2>& r = mixed.scene.lists[1].impulse;
		sum -= (r.normal + r.shear)[1] / dt;
	}
	CHECK(std::abs(sum / steps - weight) < 0.01 * weight);
	CHECK(std::abs(mixed.partner[0].centre[1] - height) < 1e-6);
	CHECK(mixed.partner[0].centre[0] == 0);
	CHECK(mixed.partner[0].velocity.norm() < 1e-3);
}

TEST_CASE("a held ball with a prescribed motion pushes", "[rigid]")
{
	Mixed<2> mixed;
	mixed.scene.add(singleGrain<2>(recipe(0.2)));
	mixed.addBall({ -0.0202, 0 }, 0.01, 0, { 1, 0 }, 0);
	const double dt = 0.4 * mixed.scene.system.criticalTimeStep();
	for (int k = 0; k < 500; ++k)
		mixed.advance(dt);
	CHECK(mixed.partner[0].velocity == Vec<2>(1, 0));
	CHECK(mixed.scene.whole(0).velocity[0] > 1.4);
	CHECK(mixed.scene.whole(0).velocity[0] < 2.01);
}

namespace {

/// Grains in a square lattice, free balls in its holes; all contacts have an interface law.
Mixed<2> latticeWithBalls(int side)
{
	constexpr double a = 0.0201;
	Mixed<2> mixed;
	std::vector<GrainParameters<2>> grains;
	for (int k = 0; k < side * side; ++k) {
		grains.push_back(paperGrain<2>());
		grains.back().origin = { a * (k % side), a * (k / side) };
	}
	mixed.scene.add(Batch<2>(makeGrainTemplate<2>(recipe(0.35)), Law::neoHookean,
				 Condition::planeStrain, grains));
	mixed.scene.addPairs(0.3);
	Random random(1);
	for (int row = 0; row + 1 < side; ++row)
		for (int column = 0; column + 1 < side; ++column)
			mixed.addBall({ a * (column + 0.5), a * (row + 0.5) }, 0.0042, 1000,
				      random.vector<2>(0.5), 0.3);
	InterfaceLaw law;
	law.dynamicFriction = 0.1;
	law.cohesion = 1e3;
	law.cohesionRange = 1e-4;
	for (ContactList<2>& list : mixed.scene.lists) {
		list.interface.emplace();
		list.interface->law = law;
	}
	mixed.scene.system.surfaces().setInterfaceRange(law.range());
	return mixed;
}

} // namespace

TEST_CASE("rigid bodies do not make bits depend on threads", "[rigid]")
{
	std::vector<std::vector<double>> states;
	for (const int threads : { 1, 2, 3 }) {
		Mixed<2> mixed = latticeWithBalls(8);
		mixed.scene.settings.threads = threads;
		REQUIRE(threadsFor(mixed.scene.system.grains(), threads) == threads);
		const double dt = 0.4 * mixed.scene.system.criticalTimeStep();
		int active = 0;
		for (int k = 0; k < 60; ++k)
			active += mixed.advance(dt).solver.active;
		CHECK(active > 1000);
		REQUIRE(threadsThatShare<2>(mixed.scene.lists,
					    mixed.scene.system.surfaces().bodies(), mixed.partner,
					    {}, threads) == threads);
		states.push_back(mixed.scene.state());
		for (const RigidPartner<2>& p : mixed.partner)
			states.back().insert(states.back().end(),
					     { p.velocity[0], p.velocity[1], p.spin[0] });
		bool pulls = false;
		for (const ContactList<2>& list : mixed.scene.lists) {
			const std::vector<double> numbers = list.interface->numbers();
			states.back().insert(states.back().end(), numbers.begin(), numbers.end());
			for (const ContactHistory<2>& history : list.interface->history)
				pulls = pulls || (list.rigid && !history.pull.isZero(0));
		}
		CHECK(pulls);
	}
	CHECK(states[1] == states[0]);
	CHECK(states[2] == states[0]);
}
