#include "step/Scene.hpp"

#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr int dim = 2;
constexpr double radius = 0.01;

/// Two disks that meet, the second one `apart` from where the first sees it.
Scene<dim> meetingDisks(const Vec<dim>& apart)
{
	Scene<dim> scene;
	GrainParameters<dim> left = paperGrain<dim>(), right = paperGrain<dim>();
	left.radius = right.radius = radius;
	right.origin = Vec<dim>(2.001 * radius, 0.3 * radius) - apart;
	const auto reference = makeGrainTemplate<dim>(recipe(0.25));
	Batch<dim> batch(reference, Law::neoHookean, Condition::planeStrain, { left, right });
	scene.add(std::move(batch));
	for (int g : { 0, 1 })
		scene.system.setOf(g).moveRigidly(g, Mat<dim>::Identity(), Vec<dim>::Zero(),
						  Vec<dim>(g == 0 ? 0.4 : -0.4, 0.1),
						  Mat<dim>::Zero());
	scene.system.updateSurfaces(1);
	scene.addPairs(0.3);
	scene.lists[0].image.shift = apart;
	scene.settings.trackEnergy = true;
	scene.settings.solver.tolerance = 1e-10;
	scene.settings.solver.maxSweeps = 1000;
	return scene;
}

} // namespace

TEST_CASE("Periodic: a grain and an image collide as two grains do", "[step][periodic]")
{
	const Vec<dim> period(0.5, -0.25);
	Scene<dim> near = meetingDisks(Vec<dim>::Zero()), far = meetingDisks(period);
	int touching = 0;
	double apart = 0; // contact points, which are those of the first grain's side
	for (int n = 0; n < 300; ++n) {
		near.advance(5e-5);
		far.advance(5e-5);
		const PairImpulse<dim>&here = near.lists[0].impulse, &there = far.lists[0].impulse;
		if (near.lists[0].contacts.empty() || here.active == 0) continue;
		++touching;
		apart = std::max(apart, (here.point - there.point).norm());
	}
	CHECK(touching > 5);
	CHECK(apart < 1e-9 * radius);
	for (int g : { 0, 1 }) {
		const auto &a = near.system.body(g).position, &b = far.system.body(g).position;
		for (std::size_t s = 0; s < a.size(); ++s) {
			const Vec<dim> seen = g == 0 ? b[s] : Vec<dim>(b[s] + period);
			CHECK((seen - a[s]).norm() < 1e-10 * radius);
		}
	}
	CHECK((far.momentum() - near.momentum()).norm() < 1e-12 * near.whole(0).mass);
}

TEST_CASE("Periodic: an image that comes nearer does the work that is found in the grains",
	  "[step][periodic]")
{
	Scene<dim> scene = meetingDisks(Vec<dim>(0.5, 0));
	for (int g : { 0, 1 }) // at rest; all that moves is the period
		scene.system.setOf(g).moveRigidly(g, Mat<dim>::Identity(), Vec<dim>::Zero(),
						  Vec<dim>(g == 0 ? -0.4 : 0.4, -0.1),
						  Mat<dim>::Zero());
	const Vec<dim> velocity(-0.5, 0.2);
	const double dt = 2e-5;
	const Vec<dim> before = scene.momentum();
	double largest = 0, worst = 0;
	for (int n = 0; n < 400; ++n) {
		PairImage<dim>& image = scene.lists[0].image;
		image.velocity = velocity;
		scene.advance(dt);
		image.shift += dt * velocity;
		const EnergyBalance& energy = scene.system.energy();
		largest = std::max(largest, energy.elastic);
		worst = std::max(worst, std::abs(conserved(energy)));
	}
	CHECK(scene.system.energy().cell > 0.5 * largest);
	CHECK(largest > 1e-4);
	CHECK(worst < 2e-2 * largest); // ripple of the integrator
	CHECK((scene.momentum() - before).norm() < 1e-13);
	CHECK(scene.deepest < 0.1);
}

TEST_CASE("Periodic: a rigid ball and its image are hit alike", "[step][periodic]")
{
	const Vec<dim> place(2.001 * radius, 0.4 * radius);
	std::vector<Vec<dim>> velocity;
	for (const Vec<dim>& apart : { Vec<dim>(0, 0), Vec<dim>(0.3, 0.7) }) {
		Scene<dim> scene;
		scene.add(singleGrain<dim>(recipe(0.25)));
		RigidPartner<dim> ball;
		ball.centre = place - apart;
		ball.velocity = Vec<dim>(-1, 0);
		ball.inverseMass.setConstant(10);
		ball.inverseInertia.setConstant(1e5);
		ContactList<dim> list;
		list.first = 0;
		list.second = -2;
		list.friction = 0.5;
		list.rigid.emplace();
		list.rigid->partner = 0;
		list.image.shift = apart;
		scene.lists.push_back(list);
		for (int n = 0; n < 200; ++n) {
			RigidSide<dim>& side = *scene.lists[0].rigid;
			side.surface = BallSurface<dim> { ball.centre + apart, radius };
			side.pivot = ball.centre + apart;
			side.velocities.spread = 2;
			ball.velocityBefore = ball.velocity;
			ball.spinBefore = ball.spin;
			scene.system.rigidPartners() = { ball };
			scene.advance(2e-5);
			ball = scene.system.rigidPartners()[0];
			ball.centre += 2e-5 * ball.velocity;
		}
		velocity.push_back(ball.velocity);
		CHECK(ball.spin[0] != 0);
	}
	CHECK(velocity[0][0] > -0.95);
	CHECK((velocity[0] - velocity[1]).norm() < 1e-9);
}
