// Grains that were brought to rest stay there: no creep, no heat, in tens of thousands of steps and
// with the default tolerance of the contact sweeps (doc/decisions/0010-grains-at-rest.md).
#include "step/Scene.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double radius = 0.01, modulus = 1e6, density = 1000; // of paperGrain

void addDisks(Scene<2>& scene, const std::vector<Vec<2>>& places, double zeta)
{
	std::vector<GrainParameters<2>> grains;
	for (const Vec<2>& place : places) {
		grains.push_back(paperGrain<2>());
		grains.back().origin = place;
	}
	scene.settings.trackEnergy = true;
	scene.settings.solver.overlapSpeed =
		1e-3 * grains[0].constants.waveSpeed(Condition::planeStrain);
	scene.add(Batch<2>(makeGrainTemplate<2>(recipe(zeta, 3, 1.25)), Law::neoHookean,
			   Condition::planeStrain, grains));
}

/// Steps in which all nodal velocities lose a hundredth.
void settle(Scene<2>& scene, double dt, int steps)
{
	for (int k = 0; k < steps; ++k) {
		scene.advance(dt);
		for (int g = 0; g < scene.system.grains(); ++g) {
			Batch<2>& batch = scene.batchOf(g);
			for (int I = 0; I < batch.reference->nodes(); ++I)
				batch.v.set(scene.laneOf(g), I,
					    0.99 * batch.v.get(scene.laneOf(g), I));
		}
	}
}

struct Rest {
	double kinetic = 0; ///< largest over the elastic energy
	double drift = 0;   ///< largest way of a grain, over its diameter
	double heat = 0;    ///< growth of the elastic energy plus friction, over the elastic energy
};

Rest watch(Scene<2>& scene, double dt, int steps)
{
	std::vector<Vec<2>> start;
	for (int g = 0; g < scene.system.grains(); ++g)
		start.push_back(scene.whole(g).centre);
	const EnergyBalance before = scene.system.energy();
	Rest rest;
	for (int k = 0; k < steps; ++k) {
		scene.advance(dt);
		const EnergyBalance& e = scene.system.energy();
		rest.kinetic = std::max(rest.kinetic, e.kinetic / e.elastic);
	}
	for (int g = 0; g < scene.system.grains(); ++g)
		rest.drift = std::max(rest.drift,
				      (scene.whole(g).centre - start[g]).norm() / (2 * radius));
	const EnergyBalance& e = scene.system.energy();
	rest.heat = (e.elastic - before.elastic + e.friction - before.friction) / e.elastic;
	return rest;
}

} // namespace

TEST_CASE("Rest: a disk in a corner under gravity", "[step]")
{
	const double friction = GENERATE(0., 0.5);
	Scene<2> scene;
	addDisks(scene, { { radius, radius } }, 0.3);
	scene.addPlane(0, { 0, 0 }, { 0, 1 }, { 0, 0 }, friction).second = -1;
	scene.addPlane(0, { 0, 0 }, { 1, 0 }, { 0, 0 }, friction).second = -2;
	const double dt = 0.45 * scene.system.criticalTimeStep();
	const double g = 0.03 * modulus / (density * 2 * radius);
	for (int k = 1; k <= 3000; ++k) {
		scene.system.loads()[0].acceleration = k / 3000. * Vec<2>(-0.5 * g, -g);
		settle(scene, dt, 1);
	}
	settle(scene, dt, 3000);
	const Rest rest = watch(scene, dt, 30000);
	CAPTURE(friction, rest.kinetic, rest.drift, rest.heat);
	CHECK(rest.kinetic < 1e-9);
	CHECK(rest.drift < 1e-8);
	CHECK(std::abs(rest.heat) < 1e-7);
	CHECK(scene.deepest < 2e-3);
}

TEST_CASE("Rest: a squeezed packing with friction", "[step]")
{
	Scene<2> scene;
	const double a = 0.0202, side = 3 * a;
	std::vector<Vec<2>> places;
	for (int k = 0; k < 9; ++k)
		places.push_back({ (k % 3 + 0.5) * a, (k / 3 + 0.5) * a });
	addDisks(scene, places, 0.35);
	scene.addPairs(0.3);
	for (int g = 0; g < 9; ++g) {
		scene.addPlane(g, { 0, 0 }, { 1, 0 }, { 0.3, 0 }, 0.3).second = -1;
		scene.addPlane(g, { side, 0 }, { -1, 0 }, { -0.3, 0 }, 0.3).second = -2;
		scene.addPlane(g, { 0, 0 }, { 0, 1 }, { 0, 0.2 }, 0.3).second = -3;
		scene.addPlane(g, { 0, side }, { 0, -1 }, { 0, -0.2 }, 0.3).second = -4;
	}
	const double dt = 0.4 * scene.system.criticalTimeStep();
	while (scene.time < 0.006)
		scene.advance(dt);
	for (ContactList<2>& list : scene.lists)
		list.plane.velocity.setZero();
	settle(scene, dt, 4000);
	const Rest rest = watch(scene, dt, 12000);
	CAPTURE(rest.kinetic, rest.drift, rest.heat, scene.deepest);
	CHECK(scene.system.energy().elastic > 0.1);
	CHECK(rest.kinetic < 1e-10);
	CHECK(rest.drift < 1e-8);
	CHECK(std::abs(rest.heat) < 1e-7);
}
