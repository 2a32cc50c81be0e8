// How far surfaces look for each other in the step to come.
#include "step/Batches.hpp"
#include "step/Formulations.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Surfaces: reach by speeds and spacings", "[step]")
{
	Scene<2> scene;
	scene.add(grainsAt<2>(0.35, { { 0, 0 }, { 0.03, 0 } }, { 0.01, 0.005 }));

	// Without motion a twentieth of the smaller point spacing; else twice the way of a step.
	const double dt = 1e-4;
	CHECK(std::abs(scene.system.surfaces().reach(0, 1, {}, dt) - 0.05 * 0.35 * 0.005) < 1e-15);
	setVelocity<2>(scene.batchOf(0), 0, { 3, 4 });
	setVelocity<2>(scene.batchOf(1), 1, { 0, -2 });
	scene.system.updateSurfaces(1);
	CHECK(std::abs(scene.system.surfaces().reach(0, 1, {}, dt) - 2 * dt * std::hypot(3, 6)) <
	      1e-12);
	const PairImage<2> image { { 0, 0 }, { 3, 0 } };
	CHECK(std::abs(scene.system.surfaces().reach(0, 1, image, dt) - 2 * dt * 6) < 1e-12);
	const Plane<2> plane { { 0, 0 }, { 0, 1 }, { 0, 1 } };
	CHECK(std::abs(scene.system.surfaces().reach(0, plane, dt) - 2 * dt * std::hypot(3, 3)) <
	      1e-12);

	// What is common to all nodes of both does not count, what they differ by does.
	const double spin = 500;
	for (int k : { 0, 1 })
		scene.batchOf(k).place(k, Mat<2>::Identity(), { 30, 0 },
				       spinMatrix<2>(Spin<2>(k * spin)));
	scene.system.updateSurfaces(1);
	CHECK(std::abs(scene.system.surfaces().reach(0, 1, {}, dt) / (2 * dt * 0.005 * spin) - 1) <
	      0.02); // 18 nodes
}

TEMPLATE_TEST_CASE_SIG("Surfaces: no contact node is faster than the reach takes it to be",
		       "[step]", ((int dim), dim), 2, 3)
{
	Scene<dim> scene;
	Batch<dim> batch = grainsAt<dim>(
		0.25, { Vec<dim>::Zero(), 0.0202 * Vec<dim>::Unit(0) + 0.004 * Vec<dim>::Unit(1) });
	setVelocity<dim>(batch, 1, -2 * Vec<dim>::Unit(0));
	scene.add(std::move(batch));
	scene.addPairs(0.5);
	scene.settings.rigidMotion = true;
	int soft = 0;
	for (int step = 0; step < 120; ++step) {
		scene.advance();
		for (int g : { 0, 1 }) {
			if (scene.system.isRigid(g)) continue;
			++soft;
			std::vector<Vec<dim>> v;
			scene.system.setOf(g).contactVelocitiesBefore(scene.laneOf(g), v);
			const VectorRange<dim> found =
				scene.system.surfaces().bodies()[g].velocities;
			const VectorRange<dim> least = rangeOf<dim>(v);
			CHECK(farthestFrom<dim>(found.middle, v) < found.spread + 1e-9);
			CHECK(found.spread < least.spread + 1e-9);
		}
	}
	CHECK(soft > 100);
	CHECK(soft < 240); // they touch while we look
}

TEST_CASE("Surfaces: the reach of the next step follows from the state alone", "[step]")
{
	for (const Scheme& scheme : { nodal, flip, updated }) {
		Scene<2> scene;
		scene.add(grainsOf<2>(scheme, recipe(0.25)));
		auto& set = scene.system.setOf(0);
		setVelocities<2>(set, [](const Vec<2>& x) {
			return Vec<2>(3 + 500 * x[0] - 900 * x[1], 200 * x[0] + 3e4 * x[1] * x[1]);
		});
		scene.system.updateSurfaces(1);
		for (int step = 0; step < 40; ++step)
			scene.advance();
		Surfaces<2>& surfaces = scene.system.surfaces();
		const VectorRange<2> found = surfaces.bodies()[0].velocities;
		surfaces.update(0); // as after loading
		const VectorRange<2> state = surfaces.bodies()[0].velocities;
		CAPTURE(found.middle, state.middle, found.spread, state.spread);
		CHECK(state.spread > 0.1);
		CHECK((found.middle - state.middle).norm() < 1e-8);
		CHECK(std::abs(found.spread - state.spread) < 1e-8);
	}
}
