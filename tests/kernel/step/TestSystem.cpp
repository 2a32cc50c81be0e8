#include "step/Batches.hpp"

#include "grain/CriticalTimeStep.hpp"
#include "grain/InternalForce.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <dlfcn.h>
#include <limits>
#include <pthread.h>

using namespace softgrain;
using namespace softgrain::testing;
using Catch::Matchers::ContainsSubstring;

namespace {
std::atomic<int> threadsMade = 0;
} // namespace

/// In place of that of the C library, for libgomp too: counts.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
			      void* (*start)(void*), void* argument)
{
	static const auto make =
		reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
	++threadsMade;
	return make(thread, attributes, start, argument);
}

namespace {

/// Angular momentum of all grains about the origin of space, as skew matrix.
template <int dim> Mat<dim> angularMomentum(const Scene<dim>& scene)
{
	Mat<dim> sum = Mat<dim>::Zero();
	for (int g = 0; g < scene.system.grains(); ++g) {
		const Batch<dim>& batch = scene.batchOf(g);
		const int lane = scene.laneOf(g);
		for (int I = 0; I < batch.reference->nodes(); ++I)
			sum += batch.nodeMass(lane, I) * batch.position(lane, I) *
			       batch.v.get(lane, I).transpose();
	}
	return sum - sum.transpose();
}

/// What stops the next step, which leaves the state as it was.
template <int dim> StepError failureOfStep(Scene<dim>& scene)
{
	const auto before = scene.state();
	try {
		scene.advance(1e-6);
	} catch (const StepError& error) {
		CHECK(scene.state() == before);
		return error;
	}
	throw std::logic_error("no StepError");
}

/// Grains of two batches, enough for three threads, that are squeezed between planes with friction.
Scene<2> squeezedPacking(int threads, bool shuffled)
{
	Scene<2> scene;
	scene.settings.threads = threads;
	scene.settings.trackEnergy = true;
	constexpr int side = 7;
	const double a = 0.0202;
	std::vector<Vec<2>> places;
	for (int row = 0; row < side; ++row)
		for (int column = 0; column < side; ++column)
			places.push_back({ column * a, row * a });
	scene.add(grainsAt<2>(0.35, places));
	scene.add(grainsAt<2>(0.4, { { 0.5 * a, 0.5 * a } }, { 0.0035 }));
	REQUIRE(threadsFor(scene.system.grains(), threads) == threads);
	scene.addPairs(0.3);
	for (int g = 0; g < scene.system.grains(); ++g) {
		scene.addPlane(g, { -0.0101, 0 }, { 1, 0 }, { 0.5, 0 }, 0.3).second = -1;
		scene.addPlane(g, { (side - 1) * a + 0.0101, 0 }, { -1, 0 }, { -0.5, 0 }, 0.3)
			.second = -2;
		scene.addPlane(g, { 0, -0.0101 }, { 0, 1 }, { 0, 0.5 }, 0.3).second = -3;
	}
	if (shuffled) {
		std::vector<ContactList<2>> order(scene.lists.begin(), scene.lists.end());
		Random random(1);
		for (std::size_t k = order.size(); k > 1; --k)
			std::swap(order[k - 1], order[random.index(static_cast<int>(k))]);
		scene.lists.assign(order.begin(), order.end());
	}
	for (int n = 0; n < 250; ++n)
		scene.advance();
	return scene;
}

} // namespace

TEST_CASE("System: the same bits with any number of threads and any order of the lists", "[step]")
{
	const Scene<2> one = squeezedPacking(1, false);
	CHECK(one.system.energy().friction > 0);
	CHECK(one.deepest > 0);
	int active = 0;
	for (const ContactList<2>& list : one.lists)
		if (list.second >= 0)
			for (const Contact<2>& c : list.contacts)
				active += c.impulse.norm() > 0;
	CHECK(active > 10);
	CHECK(squeezedPacking(2, false).state() == one.state());
	CHECK(squeezedPacking(3, false).state() == one.state());
	const Scene<2> shuffled = squeezedPacking(1, true);
	CHECK(shuffled.state() == one.state());
	CHECK(shuffled.system.energy().friction == one.system.energy().friction);
}

TEST_CASE("System: threads last from step to step", "[step]")
{
	Scene<2> scene = squeezedPacking(3, false);
	REQUIRE(threadsMade >= 2); // in this test or another
	const int before = threadsMade;
	for (int n = 0; n < 10; ++n)
		scene.advance();
	CHECK(threadsMade == before);
}

TEMPLATE_TEST_CASE_SIG("Impact: two grains head-on", "[step]", ((int dim), dim), 2, 3)
{
	const double zeta = dim == 2 ? 0.15 : 0.3, speed = 0.5;
	auto batch = grainsAt<dim>(zeta, { Vec<dim>::Zero(), 0.0201 * Vec<dim>::Unit(0) });
	setVelocity<dim>(batch, 0, speed * Vec<dim>::Unit(0));
	setVelocity<dim>(batch, 1, -0.5 * speed * Vec<dim>::Unit(0));
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(std::move(batch));
	scene.addPairs(0);
	const Vec<dim> before = scene.momentum();
	const double scale = scene.whole(0).mass * speed, initial = 0.5 * scale * speed * 1.25;
	double elastic = 0, imbalance = 0;
	while (scene.time < 5e-3) {
		scene.advance();
		const EnergyBalance& e = scene.system.energy();
		elastic = std::max(elastic, e.elastic);
		imbalance = std::max(imbalance, std::abs(conserved(e) - initial));
	}
	const EnergyBalance& e = scene.system.energy();
	const double v0 = scene.whole(0).velocity[0], v1 = scene.whole(1).velocity[0];
	CAPTURE(v0, v1, elastic / initial, imbalance / initial, e.impact / initial, scene.deepest);
	CHECK((scene.momentum() - before).norm() < 1e-13 * scale);
	CHECK(elastic > 0.1 * initial); // they did meet,
	CHECK(v1 > 0.2 * speed);        // and nearly exchanged their velocities
	CHECK(v0 < 0);
	CHECK(v0 > -0.55 * speed);
	CHECK(v1 < 1.05 * speed);
	CHECK(imbalance < 5e-3 * initial);
	CHECK(e.impact > -1e-3 * initial);
	CHECK(e.impact < 0.1 * initial);
	CHECK(std::abs(e.friction) < 1e-14 * initial);
	CHECK(scene.failures == 0);
}

TEMPLATE_TEST_CASE_SIG("Impact: off-centre with friction and different sizes", "[step]",
		       ((int dim), dim), 2, 3)
{
	const double zeta = dim == 2 ? 0.15 : 0.3;
	auto batch = grainsAt<dim>(
		zeta, { Vec<dim>::Zero(), 0.017 * Vec<dim>::Unit(0) + 0.006 * Vec<dim>::Unit(1) },
		{ 0.01, 0.008 });
	setVelocity<dim>(batch, 1, Vec<dim>(-0.7 * Vec<dim>::Unit(0)));
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(std::move(batch));
	scene.addPairs(0.5);
	const Vec<dim> before = scene.momentum();
	const Mat<dim> turning = angularMomentum(scene);
	const double initial = 0.5 * scene.whole(1).mass * 0.49;
	while (scene.time < 5e-3)
		scene.advance();
	const EnergyBalance& e = scene.system.energy();
	const double lost = (angularMomentum(scene) - turning).norm() / turning.norm();
	CAPTURE(lost, e.friction / initial, e.impact / initial, conserved(e) / initial - 1);
	CHECK((scene.momentum() - before).norm() < 1e-13 * before.norm());
	// Friction has the gap as its lever, in 3D also the bulge, h^2/8R, of the outline over the
	// triangle whose corners the impulses act on: half a per cent of the lever of the impact.
	CHECK(lost < (dim == 2 ? 1e-4 : 1e-2));
	CHECK(scene.whole(0).angularVelocity.norm() > 1);
	CHECK(e.friction > 1e-3 * initial);
	CHECK(e.impact > -1e-3 * initial);
	CHECK(std::abs(conserved(e) - initial) < 5e-3 * initial);
}

TEMPLATE_TEST_CASE_SIG("System: an inverted point stops the step and leaves the state", "[step]",
		       ((int dim), dim), 2, 3)
{
	auto batch = grainsAt<dim>(
		0.35, { Vec<dim>::Zero(), 0.03 * Vec<dim>::Unit(0), 0.06 * Vec<dim>::Unit(0) });
	for (int I = 0; I < batch.reference->nodes(); ++I) {
		Vec<dim> x = batch.x.get(1, I);
		if (x[0] > 0.004) x[0] = 0.002 - x[0]; // folds one side over
		batch.x.set(1, I, x);
	}
	int point = -1;
	const auto responses = pointResponses(batch, 1);
	for (int p = batch.reference->points() - 1; p >= 0; --p)
		if (!(responses[p].J > 0)) point = p;
	REQUIRE(point >= 0);
	Scene<dim> scene;
	scene.add(grainsAt<dim>(
		0.35,
		{ 0.1 * Vec<dim>::Unit(1) })); // so that the index in the system is not the lane
	scene.add(std::move(batch));
	const StepError error = failureOfStep(scene);
	CHECK(error.grain == 2);
	CHECK(error.point == point);
	CHECK(std::string(error.what()).find("inverted") != std::string::npos);
}

TEMPLATE_TEST_CASE_SIG(
	"System: a velocity that is not finite stops the step and leaves the positions", "[step]",
	((int dim), dim), 2, 3)
{
	Scene<dim> scene;
	scene.add(grainsAt<dim>(0.35, { Vec<dim>::Zero(), 0.03 * Vec<dim>::Unit(0) }));
	scene.advance(1e-6);
	BodyLoad<dim> load;
	load.acceleration[0] = std::numeric_limits<double>::infinity();
	scene.setLoad(1, load);
	const auto before = scene.state();
	const StepError error = failureOfStep(scene);
	CHECK(error.grain == 1);
	CHECK(error.point == -1);
	load.acceleration[0] = 1; // and it can go on
	scene.setLoad(1, load);
	scene.advance(1e-6);
	CHECK(scene.state() != before);
}

TEMPLATE_TEST_CASE_SIG(
	"System: an impulse that is not finite stops the step and leaves the positions", "[step]",
	((int dim), dim), 2, 3)
{
	Scene<dim> scene; // the first grain is not touched
	scene.add(grainsAt<dim>(
		0.35, { -0.05 * Vec<dim>::Unit(0), Vec<dim>::Zero(), 0.0199 * Vec<dim>::Unit(0) }));
	scene.addPairs(0.3);
	scene.advance(1e-6);
	ContactList<dim>& list = scene.lists.back();
	REQUIRE(!list.contacts.empty());
	const Vec<dim> found = list.contacts[0].impulse;
	list.contacts[0].impulse[0] = std::nan("");
	const auto before = scene.state();
	const StepError error = failureOfStep(scene);
	CHECK(error.grain == 1);
	CHECK(error.point == -1);
	list.contacts[0].impulse = found; // and it can go on: what was found is as it was
	CHECK(scene.system.contactProblem().contacts() == 0);
	scene.advance(1e-6);
	CHECK(scene.state() != before);
}

TEST_CASE("System: a rigid body whose velocity is not finite stops the step", "[step]")
{
	Scene<2> scene; // with a grain that it does not touch
	scene.add(grainsAt<2>(0.35, { { 0, 0 } }));
	std::vector<RigidPartner<2>>& partners = scene.system.rigidPartners();
	partners.resize(2);
	for (RigidPartner<2>& partner : partners)
		partner.inverseMass.setOnes();
	scene.system.rigidContacts() = { { 0, 1, { 1, 0 }, { 1, 0 }, 0, 1, 0, { 0, 0 } } };
	scene.advance(1e-6);
	partners[1].velocity[0] = std::nan("");
	const auto before = scene.state();
	CHECK_THROWS_WITH(scene.advance(1e-6), ContainsSubstring("rigid body"));
	CHECK(scene.state() == before);
	CHECK(scene.system.rigidContacts()[0].impulse.allFinite());
	for (RigidPartner<2>& partner : partners) { // which the host sets anew in each step
		partner.velocity.setZero();
		partner.spin.setZero();
	}
	scene.advance(1e-6);
}

TEST_CASE("System: the host is told of each grain once, when it has moved", "[step]")
{
	for (VelocityUpdate update : { VelocityUpdate::nodal, VelocityUpdate::flip }) {
		Scene<2> scene;
		Batch<2> batch = grainsAt<2>(0.35, { { 0, 0 }, { 0.03, 0 }, { 0.06, 0 } });
		for (int g = 0; g < batch.grains(); ++g)
			setVelocity<2>(batch, g, { 1, 2 });
		Scheme scheme;
		scheme.velocityUpdate = update;
		scene.add(std::make_unique<TotalLagrangian<2>>(std::move(batch), scheme));
		std::vector<std::vector<Vec<2>>> told(3);
		scene.settings.moved = [&](int g) {
			CHECK(told[g].empty());
			told[g].push_back(scene.whole(g).centre);
		};
		std::vector<Vec<2>> before;
		for (int g = 0; g < 3; ++g)
			before.push_back(scene.whole(g).centre);
		scene.advance(1e-6);
		for (int g = 0; g < 3; ++g) {
			REQUIRE(told[g].size() == 1);
			CHECK(told[g][0] == scene.whole(g).centre);
			CHECK(told[g][0] != before[g]);
		}
	}
}

TEST_CASE("System: time step and stiffening", "[step]")
{
	Scene<2> scene;
	CHECK(std::isinf(scene.system.criticalTimeStep()));
	scene.add(grainsAt<2>(0.35, { { 0, 0 }, { 0.03, 0 } }, { 0.01, 0.005 }));
	scene.add(grainsAt<2>(0.35, { { 0, 0.03 } }));
	const auto& small = scene.batchOf(1);
	CHECK(std::abs(scene.system.criticalTimeStep() /
			       criticalTimeStep(*small.reference, small.condition, small.grain[1]) -
		       1) < 1e-14);
	scene.system.updateForces(1);
	const double undeformed = scene.system.criticalTimeStep();
	CHECK(std::abs(scene.system.presentCriticalTimeStep() / undeformed - 1) < 1e-6);
	// a grain with the double of that step counts when it is four times as stiff
	for (const auto& [size, shortens] : { std::pair(0.8, false), std::pair(0.5, true) }) {
		deform<2>(scene.batchOf(2), 0, size * Mat<2>::Identity());
		scene.system.invalidateForces();
		scene.system.updateForces(1);
		CHECK((scene.system.presentCriticalTimeStep() < (1 - 1e-6) * undeformed) ==
		      shortens);
	}

	// measured where that matters
	auto isMeasured = [&](int g) {
		return !scene.system.setOf(g).state(scene.laneOf(g)).stiffening.empty();
	};
	CHECK(isMeasured(2));
	deform<2>(scene.batchOf(0), 0, Mat<2>(Vec<2>(0.6, 1.3).asDiagonal()));
	deform<2>(scene.batchOf(1), 1, Mat<2>(Vec<2>(0.6, 1.3).asDiagonal()));
	scene.system.invalidateForces();
	scene.system.updateForces(1);
	const double bound = scene.system.presentCriticalTimeStep(0);
	CHECK(bound > 0);
	CHECK(!isMeasured(1));
	CHECK(scene.system.presentCriticalTimeStep(bound) == bound);
	CHECK(!isMeasured(1));
	scene.system.timeSteps().takeMeasuredPoints();
	const double measured = scene.system.presentCriticalTimeStep(1.001 * bound, 2);
	CHECK(isMeasured(1));
	CHECK(!isMeasured(0)); // twice as large
	CHECK(measured > 1.001 * bound);
	const int points = scene.system.setOf(1).reference().points();
	CHECK(scene.system.timeSteps().takeMeasuredPoints() == 8 * points); // that was enough
	CHECK(scene.system.timeSteps().takeMeasuredPoints() == 0);
	CHECK(scene.system.presentCriticalTimeStep() == measured);
}

TEST_CASE("System: sums of work go on from a saved state", "[step]")
{
	auto start = [] {
		Scene<2> scene;
		scene.settings.trackEnergy = true;
		scene.add(grainsAt<2>(0.3, { { 0, 0 } }));
		scene.addPlane(0, { 0, 0.01 }, { 0, -1 }, { 0, -0.2 });
		scene.addPlane(0, { 0, -0.01 }, { 0, 1 });
		return scene;
	};
	Scene<2> whole = start(), first = start(), second = start();
	for (int n = 0; n < 60; ++n)
		whole.advance(2e-5);
	for (int n = 0; n < 30; ++n)
		first.advance(2e-5);
	const Batch<2>& from = first.batchOf(0);
	Batch<2>& to = second.batchOf(0);
	for (int I = 0; I < from.reference->nodes(); ++I) {
		to.x.set(0, I, from.x.get(0, I));
		to.v.set(0, I, from.v.get(0, I));
	}
	second.lists = first.lists;
	second.system.continueFrom(first.system.continuation());
	second.system.updateSurfaces(1);
	for (int n = 0; n < 30; ++n)
		second.advance(2e-5);
	CHECK(second.state() == whole.state());
	CHECK(second.system.energy().walls == whole.system.energy().walls);
	CHECK(second.system.energy().impact == whole.system.energy().impact);
	CHECK(second.system.energy().kinetic == whole.system.energy().kinetic);
	CHECK(whole.system.energy().walls > 0);
}
