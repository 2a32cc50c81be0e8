// Friction, cohesion, bonds and restitution of whole grains.
#include "step/Scene.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double side = 0.02; // of the block, m

/// Its centre of mass is told relative to where it starts.
template <int dim>
std::unique_ptr<TotalLagrangian<dim>> block(double zeta, const Vec<dim>& centre, double length = 1)
{
	TemplateRecipe r = recipe(zeta);
	r.form.form = Form::block;
	r.form.aspect[0] = length;
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.origin = centre;
	grain.constants.poisson = 0.3;
	grain.damping.mass = 200;
	return std::make_unique<TotalLagrangian<dim>>(singleGrain<dim>(r, grain));
}

template <int dim> double faceArea() { return dim == 2 ? side : side * side; }

template <int dim> ContactList<dim>& useLaw(ContactList<dim>& list, const InterfaceLaw& law)
{
	list.interface.emplace();
	list.interface->law = law;
	return list;
}

/// A block upon a plane, or upon another block.
template <int dim>
Scene<dim> pressedBlocks(double zeta, bool onPlane, const InterfaceLaw& law, double friction = 0,
			 double length = 1)
{
	const Vec<dim> up = Vec<dim>::Unit(dim - 1);
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(block<dim>(zeta, 0.5 * side * up, length));
	if (onPlane)
		useLaw(scene.addPlane(0, Vec<dim>::Zero(), up, Vec<dim>::Zero(), friction), law);
	else {
		scene.add(block<dim>(zeta, -0.5 * side * up, length));
		scene.addPairs(friction);
		useLaw(scene.lists[0], law);
	}
	scene.system.surfaces().setInterfaceRange(law.range());
	return scene;
}

/// Load per area on block 0 upwards, the opposite on block 1.
template <int dim> void pull(Scene<dim>& scene, double traction)
{
	const Vec<dim> up = Vec<dim>::Unit(dim - 1);
	for (int g = 0; g < scene.system.grains(); ++g) {
		BodyLoad<dim> load;
		load.acceleration =
			(g == 0 ? 1 : -1) * traction * faceArea<dim>() / scene.whole(g).mass * up;
		scene.setLoad(g, load);
	}
}

/// Mean traction at which the faces come apart when the load grows by `rate` [Pa/s].
template <int dim> double pullOffTraction(Scene<dim>& scene, double rate, double upTo)
{
	const double gap = 2 * scene.lists[0].interface->law.range();
	for (double traction = 0; traction < upTo;) {
		traction = rate * scene.time;
		pull(scene, traction);
		scene.advance();
		const double apart = scene.whole(0).centre[dim - 1];
		if (apart > gap) return traction;
	}
	return upTo;
}

InterfaceLaw dugdale()
{
	InterfaceLaw law;
	law.cohesion = 2e3;
	law.cohesionRange = 1e-4;
	return law;
}

InterfaceLaw bonded()
{
	InterfaceLaw law;
	law.bondStrength = 2e3;
	law.bondEnergy = 0.1;
	return law;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Interface: cohesion holds flat faces up to its traction",
		       "[interface][dugdale]", ((int dim), dim), 2, 3)
{
	for (bool onPlane : { true, false }) {
		// without friction two free blocks that pull at each other tilt and slide off
		// (doc/decisions/0024-interface-laws.md): cubes within these steps
		const double friction = dim == 2 || onPlane ? 0 : 0.5;
		for (double share : { 0.97, 1.03 }) {
			Scene<dim> scene = pressedBlocks<dim>(dim == 2 ? 0.25 : 0.5, onPlane,
							      dugdale(), friction);
			const double dt = 0.5 * scene.system.criticalTimeStep();
			double impulse = 0, time = 0; // of the steps at full load
			for (int k = 0; k < 800; ++k) {
				pull(scene, 2e3 * share * std::min(1., k / 400.));
				scene.advance(dt);
				if (k < 600) continue;
				impulse += scene.lists[0].impulse.normal[dim - 1];
				time += scene.system.lastKick();
			}
			const bool apart = scene.whole(0).centre[dim - 1] > 1.5e-4;
			CHECK(apart == (share > 1));
			if (!onPlane) {
				const double size = scene.whole(0).mass;
				CHECK(scene.momentum().norm() < 1e-13 * size);
			}
			if (share < 1) // of the contact, reaction and traction together
				CHECK(std::abs(impulse / time + 2e3 * share * faceArea<dim>()) <
				      0.002 * 2e3 * faceArea<dim>());
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Interface: work of separation", "[interface][dugdale][bond]",
		       ((int dim), dim), 2, 3)
{
	for (const InterfaceLaw& law : { dugdale(), bonded() }) {
		for (double zeta : { 0.5, dim == 2 ? 0.25 : 0.4 }) {
			Scene<dim> scene = pressedBlocks<dim>(zeta, true, law);
			// in closed contact, then torn off by the plane at a steady speed
			BodyLoad<dim> down;
			down.acceleration = -Vec<dim>::Unit(dim - 1);
			scene.setLoad(0, down);
			for (int k = 0; k < 100; ++k)
				scene.advance();
			CHECK(scene.lists[0].impulse.active > 0);
			const double before = scene.system.energy().cohesion;
			scene.setLoad(0, {});
			pullOffTraction(scene, 2e5, 1e5);
			const double energy = law.hasBond() ? law.bondEnergy : 0.2;
			const double work =
				(scene.system.energy().cohesion - before) / faceArea<dim>();
			CHECK(std::abs(work - energy) < 0.03 * energy); // a step is 3 % of the way
			CHECK(scene.lists[0].interface->takeLostBonds() == 0);
			CHECK(std::abs(conserved(scene.system.energy())) <
			      0.01 * energy * faceArea<dim>());
		}
	}
}

TEST_CASE("Interface: a bond holds up to its strength", "[interface][bond]")
{
	for (bool onPlane : { true, false }) {
		Scene<2> scene = pressedBlocks<2>(0.25, onPlane, bonded());
		scene.advance();
		for (const auto& h : scene.lists[0].interface->history)
			CHECK(h.bond != Bond::broken);
		const double found = pullOffTraction(scene, 1e5, 1e5);
		CHECK(found > 0.98 * 2e3);
		CHECK(found < 1.2 * 2e3); // it takes a while to come apart
		CHECK(scene.failures == 0);
	}
}

TEST_CASE("Interface: stiff bonds shorten the time step, and are stable in it", "[interface][bond]")
{
	InterfaceLaw law = bonded();
	law.bondStiffness = 1e11;
	law.bondStrength = 1e5;
	Scene<2> scene = pressedBlocks<2>(0.25, false, law);
	const double free = scene.system.presentCriticalTimeStep();
	scene.courant = 0.95;
	scene.advance(0.5 * free);
	CHECK(scene.system.presentCriticalTimeStep() < 0.5 * free);
	const double start = conserved(scene.system.energy());
	pull(scene, 1e3);
	for (int k = 0; k < 3000; ++k)
		scene.advance();
	CHECK(std::abs(scene.whole(0).centre[1]) < 1e-5);
	CHECK(std::abs(conserved(scene.system.energy()) - start) < 1e-4);
	for (const auto& h : scene.lists[0].interface->history)
		CHECK(h.bond == Bond::whole);
}

TEST_CASE("Interface: with bonds, too, grains are measured where they decide on a step",
	  "[interface][bond]")
{
	InterfaceLaw law = bonded();
	law.bondStiffness = 1e9;
	law.bondStrength = 1e5;
	auto deformed = [&] {
		Scene<2> scene = pressedBlocks<2>(0.25, false, law);
		scene.advance(0.5 * scene.system.presentCriticalTimeStep());
		Batch<2>& batch = scene.batchOf(0);
		for (int I = 0; I < batch.reference->nodes(); ++I) { // more and more to the right
			Vec<2> x = batch.x.get(0, I);
			x[0] *= 0.7 - 30 * x[0];
			batch.x.set(0, I, x);
		}
		scene.system.invalidateForces();
		scene.system.updateForces(1);
		return scene;
	};
	Scene<2> scene = deformed(), other = deformed();
	const double bound = scene.system.presentCriticalTimeStep(0),
		     exact = scene.system.presentCriticalTimeStep();
	REQUIRE(exact > 1.02 * bound);
	const double between = 0.5 * (bound + exact);
	CHECK(other.system.presentCriticalTimeStep(between) >= between);
}

TEST_CASE("Interface: a block starts at mu_s and slides with mu_d", "[interface][friction]")
{
	InterfaceLaw law;
	law.dynamicFriction = 0.3;
	const double g = 10;
	for (bool onPlane : { true, false }) {
		Scene<2> scene = pressedBlocks<2>(0.25, onPlane, law, 0.5, 8);
		if (!onPlane) {
			scene.addPlane(1, { 0, -side }, { 0, 1 }, Vec<2>::Zero(), 100);
		}
		scene.settings.solver.tolerance = 1e-4;
		auto push = [&](double a) {
			for (int k = 0; k < scene.system.grains(); ++k) {
				BodyLoad<2> load;
				load.acceleration = { k == 0 ? a : 0., -g };
				scene.setLoad(k, load);
			}
			scene.advance();
		};
		double a = 0;
		while (scene.time < 0.02)
			push(0);
		const double ramp = scene.time;
		while (std::abs(scene.whole(0).velocity[0]) < 0.02 && a < 10) {
			a = 100 * (scene.time - ramp);
			push(a);
		}
		CHECK(a > 4.6); // its ends slip before the rest
		CHECK(a < 5.4);
		a = 5; // less than mu_s g would ask for
		const double start = scene.time, v = scene.whole(0).velocity[0];
		while (scene.time - start < 0.02)
			push(a);
		const double found = (scene.whole(0).velocity[0] - v) / (scene.time - start);
		CHECK(std::abs(found - (a - 0.3 * g)) < 0.05 * 2);
	}
}

TEST_CASE("Interface: restitution at a plane adds no energy", "[interface][restitution]")
{
	double last = -1;
	for (double restitution : { 0., 0.5, 1. }) {
		InterfaceLaw law;
		law.restitution = restitution;
		Scene<2> scene;
		scene.settings.trackEnergy = true;
		scene.add(singleGrain<2>(recipe(0.25)));
		useLaw(scene.addPlane(0, { 0, -0.0101 }, { 0, 1 }), law);
		scene.system.setOf(0).place(0, Mat<2>::Identity(), { 0, -0.5 }, Mat<2>::Zero());
		scene.system.updateSurfaces(1);
		while (scene.time < 0.03)
			scene.advance();
		CHECK(scene.lists[0].contacts.empty());
		const EnergyBalance e = scene.system.energy();
		const double start = 0.5 * scene.whole(0).mass * 0.25;
		CHECK(e.kinetic + e.elastic < 1.001 * start);
		CHECK(std::abs(e.kinetic + e.elastic + e.impact - start) < 5e-3 * start);
		CHECK(scene.whole(0).velocity[1] != last);
		last = scene.whole(0).velocity[1];
		CHECK(last > 0.3);
	}
}
