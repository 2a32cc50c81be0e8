// Grains at rest sleep: the same results, reactions as they were.
#include "Threads.hpp"
#include "step/SleepScenes.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <optional>

using namespace softgrain;
using namespace softgrain::testing;

TEMPLATE_TEST_CASE_SIG("Sleep: a grain in a corner: its weight is borne and nothing is done for it",
		       "[sleep]", ((int dim), dim), 2, 3)
{
	Scene<dim> scene;
	scene.add(dampedGrainsAt<dim>({ Vec<dim>::Zero() }, criticalDamping));
	for (int axis = 0; axis < dim; ++axis) {
		const Vec<dim> out = Vec<dim>::Unit(axis);
		scene.addPlane(0, -radius * out, out, Vec<dim>::Zero(), 0.3).second = -1 - axis;
	}
	weigh(scene);
	const Vec<dim> load = -gravity * Vec<dim>::Ones();
	scene.system.loads()[0].acceleration = load;
	rest(scene, 1);
	const auto state = scene.state();
	const EnergyBalance before = scene.system.energy();
	for (int n = 0; n < 50; ++n) {
		const StepReport report = scene.advance(1e-5);
		CHECK(report.activeGrains == 0);
		CHECK(report.sleepingGrains == 1);
		CHECK(report.work.visits == 0);
		CHECK(report.work.points <= scene.system.setOf(0).reference().points());
	}
	CHECK(scene.advance(1e-5).work.points == 0);
	CHECK(farthest(scene.state(), state) == 0);
	Vec<dim> sum = scene.whole(0).mass * load;
	for (int axis = 0; axis < dim; ++axis)
		sum += reaction(scene, -1 - axis);
	CHECK(sum.norm() < 1e-4 * weightOf(scene, 1));
	CHECK(scene.system.energy().elastic == before.elastic);
	CHECK(scene.system.energy().loads == before.loads);
	CHECK(scene.system.energy().kinetic == 0);
}

TEST_CASE("Sleep: a heap falls asleep, with the results it has awake", "[sleep]")
{
	Scene<2> with = heap(), without = heap();
	without.settings.sleep = false;
	const double dt = 0.5 * with.system.criticalTimeStep();
	double start = 0, dropped = 0, momentum = 0;
	int slept = 0;
	for (int n = 0; n < 6000; ++n) {
		const StepReport report = with.advance(dt);
		CHECK(without.advance(dt).sleepingGrains == 0);
		dropped += report.dropped.energy;
		momentum += report.dropped.momentum;
		if (n == 0) start = total(with);
		slept += report.sleepingGrains;
	}
	CHECK(sleepers(with) == 3);
	CHECK(slept > 3 * 1000);
	CHECK(with.system.isRigid(3)); // the flying one
	const double tolerance = 1e-5; // of the radius, and of the weight
	CHECK(farthest(outlines(with), outlines(without)) < tolerance * radius);
	const double weight = weightOf(with, 3);
	for (int plane : { -1, -2, -3 })
		CHECK((reaction(with, plane) - reaction(without, plane)).norm() < 1e-4 * weight);
	CHECK(std::abs(reaction(with, -1)[1] / weight +
		       (reaction(with, -2) + reaction(with, -3))[1] / weight - 1) < 1e-4);
	const EnergyBalance& e = with.system.energy();
	CHECK(e.sleep > 0);
	CHECK(std::abs(e.sleep - dropped) <= 1e-12 * dropped);
	CHECK(momentum > 0);
	CHECK(momentum < 1e-5 * weight * 1e-3); // N s; of the weight in a millisecond
	CHECK(e.sleep < 1e-9 * e.elastic);
	const EnergyBalance& f = without.system.energy();
	CHECK(std::abs(e.elastic / f.elastic - 1) < 1e-4);
	CHECK(std::abs(total(with) - start) <
	      1.01 * std::abs(total(without) - start) + 1e-9 * e.elastic);
}

TEST_CASE("Sleep: the balance of energy sees nothing of falling asleep and waking", "[sleep]")
{
	for (double viscosity : { 0., 2e-5 }) { // s
		Scene<2> scene = heap(criticalDamping, viscosity);
		rest(scene, 3);
		const double asleep = total(scene);
		advance(scene, 5);
		CHECK(std::abs(total(scene) - asleep) < 1e-14 * scene.system.energy().elastic);
		scene.system.activity().wake(1);
		advance(scene, 20);
		CHECK(sleepers(scene) == 2);
		scene.system.activity().wake(0);
		scene.system.activity().wake(2);
		advance(scene, 20);
		CHECK(sleepers(scene) == 0);
		CHECK(std::abs(total(scene) - asleep) < 1e-12 * scene.system.energy().elastic);
	}
}

TEST_CASE("Sleep: the contact problem of the step in which an island falls asleep", "[sleep]")
{
	Scene<2> tracked = heap(), untracked = heap();
	untracked.settings.trackEnergy = false;
	REQUIRE(rest(tracked, 3) == rest(untracked, 3));
	const ContactProblem<2> one = tracked.system.contactProblem(),
				other = untracked.system.contactProblem();
	CHECK(one.contacts() > 0);
	CHECK(one.impulse == other.impulse);
	CHECK(one.freeVelocity == other.freeVelocity);
}

TEST_CASE("Sleep: what does not fall asleep", "[sleep]")
{
	auto sleepersAfter = [](Scene<2> scene, int steps) {
		const double dt = 0.5 * scene.system.criticalTimeStep();
		for (int n = 0; n < steps; ++n) {
			scene.advance(dt);
			if (sleepers(scene) > 0) return sleepers(scene);
		}
		return 0;
	};
	constexpr int enough = 4000;
	CHECK(sleepersAfter(heap(), enough) == 3);
	CHECK(sleepersAfter(heap(0), enough) == 0); // nothing takes vibrations away
	Scene<2> moving = heap();
	for (auto& list : moving.lists)
		if (list.second == -1) list.plane.velocity = { 1e-9, 0 };
	CHECK(sleepersAfter(std::move(moving), enough) == 0);
	Scene<2> off = heap();
	off.settings.sleep = false;
	CHECK(sleepersAfter(std::move(off), enough) == 0);
}

TEST_CASE("Sleep: damping far above critical does not let grains sleep half way", "[sleep]")
{
	auto height = [](bool sleep) {
		Scene<2> scene;
		scene.add(dampedGrainsAt<2>({ Vec<2>::Zero() }, 50 * criticalDamping));
		addFloor(scene);
		weigh(scene);
		scene.settings.sleep = sleep;
		const double dt = 0.5 * scene.system.criticalTimeStep();
		for (int n = 0; n < 30000; ++n)
			scene.advance(dt);
		CHECK(sleepers(scene) == sleep);
		return scene.whole(0).centre[1];
	};
	const double with = height(true), without = height(false);
	CHECK(without < -1e-3 * radius);
	CHECK(std::abs(with / without - 1) < 1e-4);
}

namespace {

/// Heaps of its own that go on from others.
Scene<2> continued(const Scene<2>& from, int heaps = 1)
{
	Scene<2> scene = heap(criticalDamping, 0, heaps);
	for (int g = 0; g < from.system.grains(); ++g)
		scene.system.setOf(g).setState(scene.laneOf(g),
					       from.system.setOf(g).state(from.laneOf(g)));
	for (int g = 0; g < from.system.grains(); ++g)
		scene.system.activity().restoreSleep(g, from.system.activity().sleepNumbers(g));
	scene.lists = from.lists;
	scene.system.continueFrom(from.system.continuation());
	scene.system.updateSurfaces(1);
	return scene;
}

} // namespace

TEST_CASE("Sleep: the same bits after a pause", "[sleep]")
{
	auto run = [](int save) {
		std::optional<Scene<2>> running = heap();
		const double dt = 0.5 * running->system.criticalTimeStep();
		bool slept = false;
		for (int n = 0; n < 5000; ++n) {
			if (n == save) running.emplace(continued(*running));
			Scene<2>& scene = *running;
			if (n == 4900) {
				BodyLoad<2> load = scene.system.loads()[2];
				load.acceleration[0] = 0.1 * gravity;
				slept = sleepers(scene) == 3;
				scene.setLoad(2, load);
			}
			scene.advance(dt);
		}
		CHECK(slept);
		CHECK(sleepers(*running) == 0);
		return running->state();
	};
	const auto bits = run(-1);
	CHECK(run(1000) == bits); // on the way
	CHECK(run(4800) == bits); // asleep
}

TEST_CASE("Sleep: the same bits with any number of threads", "[sleep]")
{
	constexpr int heaps = 11; // enough for two threads and more
	Scene<2> before = heap(criticalDamping, 0, heaps);
	const double dt = 0.5 * before.system.criticalTimeStep();
	while (before.steps < 1500)
		before.advance(dt);
	auto run = [&](int threads) {
		Scene<2> scene = continued(before, heaps);
		scene.settings.threads = threads;
		REQUIRE(threadsFor(scene.system.grains(), threads) == threads);
		while (sleepers(scene) < 3 * heaps && scene.steps < 5000)
			scene.advance(dt);
		CHECK(sleepers(scene) == 3 * heaps);
		for (int g = 2; g < 3 * heaps; g += 3) {
			BodyLoad<2> load = scene.system.loads()[g];
			load.acceleration[0] = 0.1 * gravity;
			scene.setLoad(g, load);
		}
		for (int n = 0; n < 100; ++n)
			scene.advance(dt);
		CHECK(sleepers(scene) == 0);
		auto bits = scene.state();
		bits.push_back(total(scene));
		return bits;
	};
	const auto bits = run(1);
	CHECK(run(2) == bits);
	CHECK(run(3) == bits);
}

TEST_CASE("Sleep: free grains that do not move, whether damped or not", "[sleep]")
{
	Scene<2> scene;
	scene.add(dampedGrainsAt<2>({ { 0, 0 }, { 3 * radius, 0 }, { 6 * radius, 0 } }, 0));
	scene.addPairs(0);
	scene.settings.trackEnergy = true;
	CHECK(scene.advance(1e-5).sleepingGrains == 3);
	const auto state = scene.state();
	scene.advance(1e-5);
	CHECK(scene.state() == state);
	BodyLoad<2> load;
	load.acceleration = { 0, 1 };
	scene.setLoad(0, load);
	CHECK(scene.advance(1e-5).sleepingGrains == 2);
	CHECK(scene.whole(0).velocity[1] == 1e-5);
	scene.setLoad(0, {});
	scene.advance(1e-5);
	CHECK(scene.advance(1e-5).sleepingGrains == 2); // in flight
	// one is thrown at another and wakes it before they touch
	scene.system.activity().wake(1);
	scene.system.setOf(1).moveRigidly(1, Mat<2>::Identity(), Vec<2>::Zero(), { 1, 0 },
					  Mat<2>::Zero());
	scene.system.surfaces().update(1);
	int steps = 0;
	while (scene.system.isAsleep(2) && ++steps < 2000)
		scene.advance(1e-5);
	CHECK(steps > 500);
	CHECK(scene.whole(2).velocity.norm() == 0);
	for (int n = 0; n < 200; ++n)
		scene.advance(1e-5);
	CHECK(scene.whole(2).velocity[0] > 0.01);
	CHECK(std::abs(scene.momentum()[0] / scene.whole(1).mass - 1) < 1e-12);
}
