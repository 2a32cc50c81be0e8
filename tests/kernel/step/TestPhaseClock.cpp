#include "step/Scene.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <chrono>
#include <cmath>
#include <thread>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

Scene<2> diskOnPlane()
{
	Scene<2> scene;
	scene.add(Batch<2>(makeGrainTemplate<2>(recipe(0.35)), Law::neoHookean, usualCondition<2>,
			   { paperGrain<2>() }));
	scene.addPlane(0, { 0, -0.01 }, { 0, 1 });
	return scene;
}

} // namespace

TEST_CASE("the clock books time on the phase that ends", "[clock]")
{
	PhaseClock clock;
	clock.start(true);
	std::this_thread::sleep_for(std::chrono::milliseconds(20));
	clock.end("slow");
	clock.end("quick");
	clock.end("slow");
	const auto entries = clock.take();
	REQUIRE(entries.size() == 2);
	CHECK(entries[0].phase == "slow");
	CHECK(entries[0].count == 2);
	CHECK(entries[0].nanoseconds >= 20000000);
	CHECK(entries[1].count == 1);
	CHECK(entries[1].nanoseconds < entries[0].nanoseconds);
	CHECK(clock.take().empty());
}

TEST_CASE("the clock books nothing while it is off", "[clock]")
{
	PhaseClock clock;
	clock.start(false);
	clock.end("slow");
	CHECK(clock.take().empty());
}

TEST_CASE("a step books its phases once, and changes no bit by it", "[clock]")
{
	PhaseClock clock;
	Scene<2> timed = diskOnPlane(), silent = diskOnPlane();
	timed.settings.clock = &clock;
	clock.start(true);
	for (Scene<2>* scene : { &timed, &silent })
		scene->advance();
	const auto entries = clock.take();
	CHECK(entries.size() > 5);
	CHECK(std::all_of(entries.begin(), entries.end(),
			  [](const auto& entry) { return entry.count == 1; }));
	CHECK(timed.state() == silent.state());
}

TEST_CASE("a step counts its work", "[clock]")
{
	Scene<2> scene = diskOnPlane();
	const int points = scene.batchOf(0).reference->points();
	for (int step = 0; step < 3; ++step) {
		const StepReport report = scene.advance();
		CHECK(report.work.points == points);
		CHECK(report.work.visits ==
		      std::lround(report.solver.contacts * report.solver.sweeps));
		CHECK(scene.lists[0].tested == scene.system.body(0).nodes());
	}
	scene.system.updateForces(1);
	CHECK(scene.advance().work.points == 2 * points); // each time that stress is computed
}
