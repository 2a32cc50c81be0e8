// Grains that come to rest under their weight, and what is measured of them.
#pragma once

#include "step/Batches.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <vector>

namespace softgrain::testing {

inline constexpr double radius = 0.01, density = 1000, modulus = 1e6; // of paperGrain
/// Weight over modulus 0.02, so that grains come to rest soon.
inline constexpr double gravity = 0.02 * modulus / (density * 2 * radius);
inline constexpr double criticalDamping =
	2000; // 1/s, about the speed of shear waves over the radius

template <int dim>
Batch<dim> dampedGrainsAt(const std::vector<Vec<dim>>& places, double damping, double viscosity = 0)
{
	return grainsAt<dim>(recipe(0.35), places, [=](GrainParameters<dim>& grain, std::size_t) {
		grain.damping = { damping, viscosity };
	});
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

/// Two disks on a floor between walls and one upon them, lightly above each other at the start; or
/// several such heaps side by side. At last one far above, which moves rigidly.
inline Scene<2> heap(double damping = criticalDamping, double viscosity = 0, int heaps = 1)
{
	Scene<2> scene;
	auto left = [](int h) { return 10 * radius * h; };
	std::vector<Vec<2>> places;
	for (int h = 0; h < heaps; ++h)
		for (const Vec<2>& place : { Vec<2>(0, 0), Vec<2>(2.1, 0), Vec<2>(1.05, 1.8) })
			places.push_back(radius * place + Vec<2>(left(h), 0));
	places.push_back({ 1.05 * radius, 50 * radius });
	scene.add(dampedGrainsAt<2>(places, damping, viscosity));
	scene.addPairs(0.3, [=](int a, int b) { return b == 3 * heaps || a / 3 == b / 3; });
	addFloor(scene);
	for (int g = 0; g < 3 * heaps; ++g) {
		const double x = left(g / 3);
		scene.addPlane(g, { x - 1.05 * radius, 0 }, { 1, 0 }, { 0, 0 }, 0.3).second = -2;
		scene.addPlane(g, { x + 3.15 * radius, 0 }, { -1, 0 }, { 0, 0 }, 0.3).second = -3;
	}
	weigh(scene);
	scene.system.loads()[3 * heaps].acceleration.setZero();
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

/// Adds a velocity as a script does.
template <int dim> void kick(Scene<dim>& scene, int g, const Vec<dim>& velocity)
{
	System<dim>& system = scene.system;
	system.activity().jolt(g, velocity.norm(), system.lastKick());
	system.setOf(g).moveRigidly(system.indexInSet(g), Mat<dim>::Identity(), Vec<dim>::Zero(),
				    velocity, Mat<dim>::Zero());
	system.surfaces().update(g);
	system.invalidateForces();
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
	return conserved(scene.system.energy());
}

/// Of the grains of the heap. (Background nodes at the rim that carry next to no mass are soft, and
/// come to rest later.)
inline std::vector<double> outlines(const Scene<2>& scene)
{
	std::vector<double> all;
	for (int g = 0; g < 3; ++g)
		for (const Vec<2>& x : scene.system.body(g).position)
			all.insert(all.end(), x.data(), x.data() + 2);
	return all;
}

inline double farthest(const std::vector<double>& a, const std::vector<double>& b)
{
	double largest = 0;
	for (std::size_t k = 0; k < a.size(); ++k)
		largest = std::max(largest, std::abs(a[k] - b[k]));
	return largest;
}

} // namespace softgrain::testing
