// What all formulations promise the step: contact, loads, rigid motion, saving, errors.
#include "Threads.hpp"
#include "step/Formulations.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

TEMPLATE_TEST_CASE_SIG("Formulations: contact velocities answer to impulses as W_ss' says",
		       "[step]", ((int dim), dim), 2, 3)
{
	Random random(3);
	auto set = grainsOf<dim>(updated, recipe(dim == 2 ? 0.2 : 0.45));
	set->place(0, random.rotation<dim>(), random.vector<dim>(), Mat<dim>::Zero());
	set->moveRigidly(0, Mat<dim>::Identity(), random.vector<dim>(0.01), Vec<dim>::Zero(),
			 Mat<dim>::Zero());
	set->updateForces({});
	set->predictVelocities(0, 1e-5, {});
	const ContactMobility<dim> W = set->contactMobility(0);
	std::vector<Vec<dim>> before, after;
	set->contactVelocities(0, before);
	const int nodes = set->reference().contactNodes();
	std::vector<Vec<dim>> impulse(nodes, Vec<dim>::Zero()), expected(nodes, Vec<dim>::Zero());
	for (int n = 0; n < 5; ++n) {
		const int s = random.index(nodes);
		const Vec<dim> J = random.vector<dim>(1e-4);
		impulse[s] += J;
		for (int k = W.table->begin(s); k < W.table->end(s); ++k)
			expected[W.table->column[k]] += W.scale * W.table->value[k] * J;
	}
	set->applyContactImpulses(0, impulse);
	set->contactVelocities(0, after);
	double error = 0, largest = 0;
	for (int s = 0; s < nodes; ++s) {
		error = std::max(error, (after[s] - before[s] - expected[s]).norm());
		largest = std::max(largest, expected[s].norm());
	}
	CHECK(largest > 0);
	CHECK(error < 1e-12 * largest);
}

TEST_CASE("Formulations: mobility of contact nodes stays bounded wherever the grid lies", "[step]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.1));
	double usual = 0;
	for (int s = 0; s < reference->contactNodes(); ++s)
		for (int k = reference->delassus.begin(s); k < reference->delassus.end(s); ++k)
			if (reference->delassus.column[k] == s)
				usual = std::max(usual, reference->delassus.value[k]);
	usual /= 1000 * 1e-4; // of the total-Lagrangian grain
	Random random(4);
	double largest = 0;
	for (int n = 0; n < 200; ++n) {
		auto set = grainsOf<2>(updated, recipe(0.1));
		set->place(0, random.rotation<2>(), Vec<2>::Zero(), Mat<2>::Zero());
		set->moveRigidly(0, Mat<2>::Identity(), random.vector<2>(0.01), Vec<2>::Zero(),
				 Mat<2>::Zero());
		set->updateForces({});
		const ContactMobility<2> W = set->contactMobility(0);
		for (int s = 0; s < W.table->rows(); ++s)
			for (int k = W.table->begin(s); k < W.table->end(s); ++k)
				if (W.table->column[k] == s) {
					CHECK(W.table->value[k] > 0);
					largest = std::max(largest, W.table->value[k]);
				}
	}
	CAPTURE(largest / usual);
	CHECK(largest < 3 * usual);
}

TEST_CASE("Formulations: stiffening is measured alike wherever velocities live", "[step]")
{
	auto measured = [](const Scheme& scheme) {
		auto set = grainsOf<2>(scheme, recipe(0.2));
		GrainState state = set->state(0);
		// pressed, the more to the right
		for (std::size_t k = 0; k < state.x.size(); k += 2) {
			double& x = state.x[k];
			x *= 0.75 - 15 * x;
		}
		set->setState(0, state);
		set->updateForces({});
		const double bound = set->stiffening(0);
		REQUIRE(set->mayMeasureStiffening(0));
		set->measureStiffening({ { 0, 1. } });
		CHECK(!set->mayMeasureStiffening(0));
		CHECK(set->stiffening(0) > 1.05);
		CHECK(set->stiffening(0) < 0.95 * bound);
		return set->stiffening(0);
	};
	// their masses are lumped otherwise; the halved step of `flip` would halve it
	CHECK(std::abs(measured(flip) / measured(nodal) - 1) < 0.2);
}

TEMPLATE_TEST_CASE_SIG("Formulations: same bits with any number of threads, and after a save",
		       "[step]", ((int dim), dim), 2, 3)
{
	constexpr int count = 33; // enough for two threads
	std::vector<GrainParameters<dim>> grains(count, paperGrain<dim>());
	for (int g = 0; g < count; ++g)
		grains[g].origin = 0.0195 * g * Vec<dim>::Unit(0);
	for (const Scheme& scheme : { flip, updated }) {
		auto start = [&](int threads) {
			Scene<dim> scene;
			scene.settings.threads = threads;
			REQUIRE(threadsFor(count, threads) == threads);
			auto set = grainsOf<dim>(scheme, recipe(dim == 2 ? 0.25 : 0.45), grains);
			set->place(0, Mat<dim>::Identity(), Vec<dim>::Unit(0), spinAbout<dim>(50));
			scene.add(std::move(set));
			scene.addPairs(0.3, [](int a, int b) { return b == a + 1; });
			return scene;
		};
		Scene<dim> one = start(1), two = start(2), loaded = start(1);
		for (int n = 0; n < 24; ++n) {
			one.advance(2e-5);
			two.advance(2e-5);
			if (n != 11) continue;
			for (int g = 0; g < count; ++g)
				loaded.system.setOf(g).setState(g, one.system.setOf(g).state(g));
			loaded.lists = one.lists;
			loaded.system.continueFrom(one.system.continuation());
			loaded.system.updateSurfaces(1);
		}
		for (int n = 0; n < 12; ++n)
			loaded.advance(2e-5);
		CHECK(two.state() == one.state());
		CHECK(loaded.state() == one.state());
		CHECK(one.whole(1).velocity.norm() > 0.01); // they did meet
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: moving a grain rigidly moves all of it", "[step]",
		       ((int dim), dim), 2, 3)
{
	Random random(5);
	for (const Scheme& scheme : { nodal, flip, updated }) {
		auto set = grainsOf<dim>(scheme, recipe(0.4));
		const Mat<dim> Q = random.rotation<dim>(), turn = random.rotation<dim>();
		const Vec<dim> velocity = random.vector<dim>(), shift = random.vector<dim>(),
			       push = random.vector<dim>();
		set->place(0, Q, velocity, spinAbout<dim>(20));
		std::vector<Vec<dim>> before, after;
		set->contactPositions(0, before);
		const auto whole = set->whole(0);
		set->moveRigidly(0, turn, shift, push, spinAbout<dim>(30));
		set->contactPositions(0, after);
		for (std::size_t s = 0; s < before.size(); ++s)
			CHECK((after[s] - whole.centre - shift - turn * (before[s] - whole.centre))
				      .norm() < 1e-14);
		const auto moved = set->whole(0);
		CHECK((moved.velocity - turn * whole.velocity - push).norm() < 1e-13);
		CHECK((moved.rotation - turn * whole.rotation).norm() < 1e-12);
		CHECK((moved.centre - whole.centre - shift).norm() < 1e-14);
		set->updateForces({});
		CHECK(set->report(0).elasticEnergy < 1e-12);
		for (const auto& point : set->points(0))
			CHECK((point.F - turn * Q).norm() < 1e-11);
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: a load gives its momentum and its torque", "[step]",
		       ((int dim), dim), 2, 3)
{
	for (const Scheme& scheme : { nodal, flip, updated }) {
		Scene<dim> scene;
		scene.settings.trackEnergy = true;
		scene.add(grainsOf<dim>(scheme, recipe(0.3)));
		BodyLoad<dim>& load = scene.system.loads()[0];
		load.acceleration = Vec<dim>::Constant(3);
		load.angular = spinAbout<dim>(50);
		const auto before = scene.whole(0);
		const double dt = 1e-6;
		scene.advance(dt);
		scene.advance(dt);
		const auto after = scene.whole(0);
		const int z = static_cast<int>(after.angularMomentum.size()) - 1;
		const double torque = 50 * before.inertia(z, z);
		CAPTURE(static_cast<int>(scheme.formulation), after.angularMomentum[z],
			2 * torque * dt);
		CHECK((after.velocity - 2 * dt * load.acceleration).norm() < 1e-13);
		CHECK(std::abs(after.angularMomentum[z] / (2 * torque * dt) - 1) < 1e-3);
		const EnergyBalance& e = scene.system.energy();
		CHECK(e.loads > 0);
		if (scheme.formulation == Formulation::total)
			CHECK(std::abs(e.kinetic + e.elastic - e.loads) < 1e-9 * e.loads);
	}
}

TEST_CASE("Formulations: a grain that has fallen apart stops the step", "[step]")
{
	for (double place : { 1., -1e300, std::numeric_limits<double>::quiet_NaN() }) {
		auto set = grainsOf<2>(updated, recipe(0.3));
		GrainState s = set->state(0);
		s.x[2 * 5 + 1] = place; // of the sixth point
		set->setState(0, s);
		Scene<2> scene;
		scene.add(std::move(set));
		try {
			scene.advance(1e-6);
			FAIL("no StepError");
		} catch (const StepError& error) {
			CHECK(error.grain == 0);
			CHECK(error.point == 5);
		}
	}
}

TEST_CASE("Formulations: inadmissible schemes are named", "[step]")
{
	auto complaint = [](Scheme scheme, int order) {
		return complaintOf([&] { grainsOf<2>(scheme, recipe(0.4, order)); });
	};
	CHECK(complaint(updated, 2) == "");
	CHECK(complaint(updated, 1).find("order = 1 ") == 0);
	Scheme share = flip;
	share.picShare = 1;
	CHECK(complaint(share, 1) == "");
	share.picShare = 1.1;
	CHECK(complaint(share, 3).find("picShare = 1.1 ") == 0);
	share.picShare = std::numeric_limits<double>::quiet_NaN();
	CHECK(complaint(share, 3).find("picShare = nan ") == 0);
	share = nodal;
	share.picShare = 0.1;
	CHECK(complaint(share, 3).find("picShare = 0.1 ") == 0);
	auto set = grainsOf<2>(flip, recipe(0.4));
	const GrainState wrong = grainsOf<2>(nodal, recipe(0.4))->state(0);
	CHECK(complaintOf([&] { set->setState(0, wrong); }).find("saved velocities") !=
	      std::string::npos);
}

TEST_CASE("Formulations: schemes that differ anywhere are not taken for the same", "[step]")
{
	Scheme formulation, update, share;
	formulation.formulation = Formulation::updated;
	update.velocityUpdate = VelocityUpdate::flip;
	share.picShare = 0.1;
	const Scheme base;
	CHECK(!(base < base));
	for (const Scheme& other : { formulation, update, share })
		CHECK((base < other) != (other < base));
}
