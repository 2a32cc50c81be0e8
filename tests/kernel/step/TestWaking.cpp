// Grains that sleep are woken by any change.
#include "step/SleepScenes.hpp"

#include <catch2/generators/catch_generators.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Sleep: woken without any change, nothing jumps", "[sleep]")
{
	const auto woken = GENERATE(std::vector<int> { 0 }, std::vector<int> { 0, 1, 2 });
	Scene<2> scene = heap();
	rest(scene, 3);
	// the step is another now than that in which they fell asleep
	const double dt = 0.35 * scene.system.criticalTimeStep();
	scene.advance(dt);
	scene.advance(dt);
	const auto places = outlines(scene);
	const double weight = weightOf(scene, 3), elastic = scene.system.energy().elastic;
	const Vec<2> onFloor = reaction(scene, -1);
	for (int g : woken)
		scene.system.activity().wake(g);
	for (int n = 0; n < 60; ++n) {
		const StepReport report = scene.advance(dt);
		CHECK(report.activeGrains == static_cast<int>(woken.size()));
		CHECK(report.solver.converged);
		CHECK((reaction(scene, -1) - onFloor).norm() < 1e-4 * weight);
		CHECK(scene.system.energy().kinetic < 1e-9 * elastic);
	}
	CHECK(farthest(outlines(scene), places) < 4e-6 * radius);
	rest(scene, 3, 0.35);
	CHECK(farthest(outlines(scene), places) < 1e-5 * radius);
}

namespace {

constexpr int soon = 1000; ///< steps, a few periods of the slowest vibration

/// Steps until so many grains of the heap are awake.
int stepsUntilAwake(Scene<2>& scene, int grains, int most)
{
	const double dt = 0.5 * scene.system.criticalTimeStep();
	int steps = 0;
	while (3 - sleepers(scene) < grains && steps < most) {
		scene.advance(dt);
		++steps;
	}
	CHECK(3 - sleepers(scene) >= grains);
	return steps;
}

} // namespace

TEST_CASE("Sleep: what wakes a grain, and then those that feel it", "[sleep]")
{
	Scene<2> scene = heap();
	rest(scene, 3);
	advance(scene, 3);
	const double dt = 0.5 * scene.system.criticalTimeStep();
	auto planeOf = [&](int grain, int plane) -> ContactList<2>& {
		return *std::find_if(scene.lists.begin(), scene.lists.end(), [&](auto& list) {
			return list.first == grain && list.second == plane;
		});
	};
	SECTION("another load on one of them")
	{
		BodyLoad<2> load = scene.system.loads()[2];
		scene.setLoad(2, load);
		scene.advance(dt);
		CHECK(sleepers(scene) == 3); // the same load
		load.acceleration[0] += 0.5 * gravity;
		scene.setLoad(2, load);
		CHECK(scene.advance(dt).activeGrains == 3); // both others touch it
		CHECK(scene.whole(2).velocity[0] > 0);
	}
	SECTION("another load that the others do not feel")
	{
		BodyLoad<2> load = scene.system.loads()[2];
		load.acceleration[0] += 1e-4 * gravity;
		scene.setLoad(2, load);
		int awake = 0;
		for (int n = 0; n < soon; ++n)
			awake = std::max(awake, scene.advance(dt).activeGrains);
		CHECK(awake == 1);
		CHECK(sleepers(scene) == 3); // again
	}
	SECTION("a grain that comes within reach")
	{
		scene.system.activity().wake(3);
		scene.system.setOf(3).moveRigidly(3, Mat<2>::Identity(), { 0, -45 * radius },
						  { 0, -2 }, Mat<2>::Zero());
		scene.system.surfaces().update(3);
		double gap = 0;
		int steps = 0;
		for (; sleepers(scene) == 3 && steps < 10000; ++steps) {
			scene.advance(dt);
			for (const auto& list : scene.lists)
				if (list.second == 3)
					for (const auto& contact : list.contacts)
						gap = contact.gap;
		}
		CHECK(steps > 5);
		CHECK_FALSE(scene.system.isAsleep(2));
		CHECK(gap > 0); // before it touches
		stepsUntilAwake(scene, 3, soon);
		advance(scene, 200);
		CHECK(scene.whole(3).velocity[1] > -2);
	}
	SECTION("a wall that moves away from them")
	{
		for (int g = 0; g < 3; ++g)
			planeOf(g, -2).plane.velocity = { -0.1, 0 };
		CHECK(scene.advance(dt).activeGrains == 1);
		stepsUntilAwake(scene, 3, soon);
	}
	SECTION("a wall that was moved")
	{
		for (int g = 0; g < 3; ++g)
			planeOf(g, -1).plane.point -= Vec<2>(0, 1e-3 * radius);
		CHECK(scene.advance(dt).activeGrains == 2);
		stepsUntilAwake(scene, 3, soon);
	}
	SECTION("a wall that comes")
	{
		for (int g = 0; g < 3; ++g)
			scene.addPlane(g, { 0, 3 * radius }, { 0, -1 }, { 0, -1 }, 0).second = -4;
		int steps = 0;
		while (sleepers(scene) == 3 && ++steps < 10000)
			scene.advance(dt);
		CHECK(steps > 5);
		CHECK_FALSE(scene.system.isAsleep(2));
		CHECK(planeOf(2, -4).contacts[0].gap > 0);
		stepsUntilAwake(scene, 3, soon);
	}
	SECTION("a pair that is taken away")
	{
		std::erase_if(scene.lists, [](const auto& list) {
			return list.first == 0 && list.second == -1;
		});
		CHECK(scene.advance(dt).activeGrains == 1);
		CHECK(scene.whole(0).velocity[1] < 0);
		stepsUntilAwake(scene, 3, soon);
	}
	SECTION("one of them is moved by hand")
	{
		kick(scene, 1, { 1, 0 });
		CHECK(scene.advance(dt).activeGrains == 2); // with what lies on it
		CHECK_FALSE(scene.system.isAsleep(2));
		stepsUntilAwake(scene, 3, soon);
	}
	SECTION("it is switched off")
	{
		scene.settings.sleep = false;
		CHECK(scene.advance(dt).activeGrains == 3);
		advance(scene, 500);
		CHECK(sleepers(scene) == 0);
	}
}
