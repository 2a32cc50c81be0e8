// Grains at rest sleep: the same results, reactions as they were, woken by any change.
#include "step/Scene.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <functional>
#include <optional>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double radius = 0.01, density = 1000, modulus = 1e6; // of paperGrain
/// Weight over modulus 0.02, so that grains come to rest soon.
constexpr double gravity = 0.02 * modulus / (density * 2 * radius);
constexpr double criticalDamping = 2000; // 1/s, about the speed of shear waves over the radius

template <int dim>
Batch<dim> grainsAt(const std::vector<Vec<dim>>& places, double damping, double viscosity = 0)
{
	std::vector<GrainParameters<dim>> grains;
	for (const Vec<dim>& place : places) {
		grains.push_back(paperGrain<dim>());
		grains.back().origin = place;
		grains.back().damping = { damping, viscosity };
	}
	return Batch<dim>(makeGrainTemplate<dim>(recipe(0.35)), Law::neoHookean,
			  usualCondition<dim>, grains);
}

template <int dim> void addFloor(Scene<dim>& scene)
{
	for (int g = 0; g < scene.system.grains(); ++g)
		scene.addPlane(g, -radius * Vec<dim>::Unit(1), Vec<dim>::Unit(1), Vec<dim>::Zero(),
			       0.3);
}

template <int dim> void weigh(Scene<dim>& scene)
{
	scene.settings.trackEnergy = true;
	scene.settings.solver.overlapSpeed =
		1e-3 * paperGrain<dim>().constants.waveSpeed(usualCondition<dim>);
	for (auto& load : scene.system.loads())
		load.acceleration = -gravity * Vec<dim>::Unit(1);
}

/// Two disks on a floor between walls and one upon them, lightly above each other at the start; a
/// fourth far above, which moves rigidly.
Scene<2> heap(double damping = criticalDamping, double viscosity = 0)
{
	Scene<2> scene;
	scene.add(grainsAt<2>({ { 0, 0 },
				{ 2.1 * radius, 0 },
				{ 1.05 * radius, 1.8 * radius },
				{ 1.05 * radius, 50 * radius } },
			      damping, viscosity));
	scene.addPairs(0.3);
	addFloor(scene);
	for (int g = 0; g < 3; ++g) {
		scene.addPlane(g, { -1.05 * radius, 0 }, { 1, 0 }, { 0, 0 }, 0.3).second = -2;
		scene.addPlane(g, { 3.15 * radius, 0 }, { -1, 0 }, { 0, 0 }, 0.3).second = -3;
	}
	weigh(scene);
	scene.system.loads()[3].acceleration.setZero();
	return scene;
}

/// Those that came to rest in contact.
template <int dim> int sleepers(const Scene<dim>& scene)
{
	int count = 0;
	for (int g = 0; g < scene.system.grains(); ++g)
		count += scene.system.isAsleep(g) && !scene.system.isRigid(g);
	return count;
}

/// Until so many grains sleep; returns the steps taken.
template <int dim> int rest(Scene<dim>& scene, int grains, double courant = 0.5)
{
	const int before = scene.steps;
	const double dt = courant * scene.system.criticalTimeStep();
	while (sleepers(scene) < grains && scene.steps - before < 60000)
		scene.advance(dt);
	REQUIRE(sleepers(scene) == grains);
	return scene.steps - before;
}

template <int dim> void advance(Scene<dim>& scene, int steps)
{
	const double dt = 0.5 * scene.system.criticalTimeStep();
	for (int n = 0; n < steps; ++n)
		scene.advance(dt);
}

/// Of a plane on its grains, of the last step that solved them, N.
template <int dim> Vec<dim> reaction(const Scene<dim>& scene, int plane)
{
	Vec<dim> sum = Vec<dim>::Zero();
	for (const ContactList<dim>& list : scene.lists) {
		if (list.second != plane || list.contacts.empty()) continue;
		const double kick = list.isAsleep() ? list.rest.kick : scene.system.lastKick();
		sum += (list.impulse.normal + list.impulse.shear) / kick;
	}
	return sum;
}

template <int dim> double weightOf(const Scene<dim>& scene, int grains)
{
	double sum = 0;
	for (int g = 0; g < grains; ++g)
		sum += scene.whole(g).mass * gravity;
	return sum;
}

template <int dim> double total(const Scene<dim>& scene)
{
	const EnergyBalance& e = scene.system.energy();
	return e.kinetic + e.elastic + e.friction + e.impact + e.damping + e.sleep - e.planes -
	       e.loads;
}

/// Of the grains of the heap. (Background nodes at the rim that carry next to no mass are soft, and
/// come to rest later.)
std::vector<double> outlines(const Scene<2>& scene)
{
	std::vector<double> all;
	for (int g = 0; g < 3; ++g)
		for (const Vec<2>& x : scene.system.body(g).position)
			all.insert(all.end(), x.data(), x.data() + 2);
	return all;
}

double farthest(const std::vector<double>& a, const std::vector<double>& b)
{
	double largest = 0;
	for (std::size_t k = 0; k < a.size(); ++k)
		largest = std::max(largest, std::abs(a[k] - b[k]));
	return largest;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Sleep: a grain in a corner: its weight is borne and nothing is done for it",
		       "[sleep]", ((int dim), dim), 2, 3)
{
	Scene<dim> scene;
	scene.add(grainsAt<dim>({ Vec<dim>::Zero() }, criticalDamping));
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

TEST_CASE("Sleep: an island falls asleep as one, with the results it has awake", "[sleep]")
{
	Scene<2> with = heap(), without = heap();
	without.settings.sleep = false;
	const double dt = 0.5 * with.system.criticalTimeStep();
	double start = 0, dropped = 0, momentum = 0;
	int slept = 0;
	for (int n = 0; n < 6000; ++n) {
		const int before = sleepers(with);
		const StepReport report = with.advance(dt);
		CHECK(without.advance(dt).sleepingGrains == 0);
		dropped += report.dropped.energy;
		momentum += report.dropped.momentum;
		if (n == 0) start = total(with);
		if (sleepers(with) != before) CHECK(sleepers(with) - before == 3);
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

TEST_CASE("Sleep: woken without any change, nothing jumps", "[sleep]")
{
	Scene<2> scene = heap();
	rest(scene, 3);
	// the step is another now than that in which they fell asleep
	const double dt = 0.35 * scene.system.criticalTimeStep();
	scene.advance(dt);
	scene.advance(dt);
	const auto places = outlines(scene);
	const double weight = weightOf(scene, 3), elastic = scene.system.energy().elastic;
	const Vec<2> onFloor = reaction(scene, -1);
	scene.system.activity().wake(0);
	for (int n = 0; n < 60; ++n) {
		const StepReport report = scene.advance(dt);
		CHECK(report.activeGrains == 3);
		CHECK(report.solver.converged);
		CHECK((reaction(scene, -1) - onFloor).norm() < 1e-4 * weight);
		CHECK(scene.system.energy().kinetic < 1e-9 * elastic);
	}
	CHECK(farthest(outlines(scene), places) < 4e-6 * radius);
	rest(scene, 3, 0.35);
	CHECK(farthest(outlines(scene), places) < 1e-5 * radius);
}

TEST_CASE("Sleep: what wakes an island", "[sleep]")
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
		load.acceleration[0] += 1e-3 * gravity;
		scene.setLoad(2, load);
		CHECK(scene.advance(dt).activeGrains == 3);
		CHECK(scene.whole(2).velocity[0] > 0);
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
		CHECK(sleepers(scene) == 0);
		CHECK(gap > 0); // before it touches
		advance(scene, 200);
		CHECK(scene.whole(3).velocity[1] > -2);
	}
	SECTION("a wall that moves, also away from them")
	{
		for (int g = 0; g < 3; ++g)
			planeOf(g, -2).plane.velocity = { -0.1, 0 };
		CHECK(scene.advance(dt).activeGrains == 3);
	}
	SECTION("a wall that was moved")
	{
		for (int g = 0; g < 3; ++g)
			planeOf(g, -1).plane.point -= Vec<2>(0, 1e-3 * radius);
		CHECK(scene.advance(dt).activeGrains == 3);
	}
	SECTION("a wall that comes")
	{
		for (int g = 0; g < 3; ++g)
			scene.addPlane(g, { 0, 3 * radius }, { 0, -1 }, { 0, -1 }, 0).second = -4;
		int steps = 0;
		while (sleepers(scene) == 3 && ++steps < 10000)
			scene.advance(dt);
		CHECK(steps > 5);
		CHECK(sleepers(scene) == 0);
		CHECK(planeOf(2, -4).contacts[0].gap > 0);
	}
	SECTION("a pair that is taken away")
	{
		std::erase_if(scene.lists, [](const auto& list) {
			return list.first == 0 && list.second == -1;
		});
		CHECK(scene.advance(dt).activeGrains == 3);
		CHECK(scene.whole(0).velocity[1] < 0);
	}
	SECTION("one of them is moved by hand")
	{
		scene.system.activity().wake(1);
		scene.system.setOf(1).moveRigidly(1, Mat<2>::Identity(), Vec<2>::Zero(),
						  { 0.01, 0 }, Mat<2>::Zero());
		scene.system.surfaces().update(1);
		scene.system.invalidateForces();
		CHECK(scene.advance(dt).activeGrains == 3);
	}
	SECTION("it is switched off")
	{
		scene.settings.sleep = false;
		CHECK(scene.advance(dt).activeGrains == 3);
		advance(scene, 500);
		CHECK(sleepers(scene) == 0);
	}
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
		scene.add(grainsAt<2>({ Vec<2>::Zero() }, 50 * criticalDamping));
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

/// A heap of its own that goes on from another one.
Scene<2> continued(const Scene<2>& from)
{
	Scene<2> scene = heap();
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

TEST_CASE("Sleep: the same bits with any number of threads, and after a pause", "[sleep]")
{
	auto run = [](int threads, int save) {
		std::optional<Scene<2>> running = heap();
		running->settings.threads = threads;
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
	const auto bits = run(1, -1);
	CHECK(run(2, -1) == bits);
	CHECK(run(3, -1) == bits);
	CHECK(run(1, 1000) == bits); // on the way
	CHECK(run(1, 4800) == bits); // asleep
}

TEST_CASE("Sleep: free grains that do not move, whether damped or not", "[sleep]")
{
	Scene<2> scene;
	scene.add(grainsAt<2>({ { 0, 0 }, { 3 * radius, 0 }, { 6 * radius, 0 } }, 0));
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
