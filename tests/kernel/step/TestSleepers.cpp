// Grains that sleep beside others that are awake.
#include "step/SleepScenes.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> void loadMore(Scene<dim>& scene, int g, double share)
{
	BodyLoad<dim> load = scene.system.loads()[g];
	load.acceleration[1] *= 1 + share;
	scene.setLoad(g, load);
}

/// Most grains that were awake in so many steps.
template <int dim> int mostAwake(Scene<dim>& scene, int steps)
{
	int most = 0;
	for (int n = 0; n < steps; ++n) {
		advance(scene, 1);
		most = std::max(most, scene.system.grains() - sleepers(scene));
	}
	return most;
}

constexpr int below = 12, above = below - 1, all = below + above;

/// Two rows of disks on a floor between walls.
Scene<2> bed(bool sleep)
{
	constexpr double step = 2.02 * radius, wall = 1.01 * radius;
	std::vector<Vec<2>> places;
	for (int k = 0; k < below; ++k)
		places.push_back({ k * step, 0 });
	for (int k = 0; k < above; ++k)
		places.push_back({ (k + 0.5) * step, 1.78 * radius });
	Scene<2> scene;
	scene.add(dampedGrainsAt<2>(places, criticalDamping));
	scene.addPairs(0.3);
	addFloor(scene);
	const Vec<2> left(-wall, 0), right((below - 1) * step + wall, 0);
	scene.addPlane(0, left, { 1, 0 }, { 0, 0 }, 0.3).second = -2;
	scene.addPlane(below - 1, right, { -1, 0 }, { 0, 0 }, 0.3).second = -3;
	weigh(scene);
	scene.settings.sleep = sleep;
	return scene;
}

std::vector<double> ofWholes(const Scene<2>& scene, Vec<2> WholeGrain<2>::* what)
{
	std::vector<double> numbers;
	for (int g = 0; g < all; ++g) {
		const Vec<2> v = scene.whole(g).*what;
		numbers.insert(numbers.end(), { v[0], v[1] });
	}
	return numbers;
}

std::vector<double> centres(const Scene<2>& scene)
{
	return ofWholes(scene, &WholeGrain<2>::centre);
}

} // namespace

TEST_CASE("Sleep: a load on one of many wakes those that feel it, with the same results", "[sleep]")
{
	const auto [share, mostOf, places, forces] =
		GENERATE(table<double, int, double, double>({ { 3e-3, 1, 2e-4, 5e-4 }, // hidden
							      { 0.03, all / 2, 1e-5, 3e-5 },
							      { 0.3, all - 1, 1e-5, 1e-5 } }));
	Scene<2> with = bed(true), without = bed(false);
	advance(without, rest(with, all));
	loadMore(with, all - 1, share);
	loadMore(without, all - 1, share);
	CHECK(mostAwake(with, 3000) <= mostOf);
	advance(without, 3000);
	CHECK(sleepers(with) == all); // again
	CHECK(farthest(centres(with), centres(without)) < places * radius);
	const double weight = weightOf(with, all);
	for (int plane : { -1, -2, -3 })
		CHECK((reaction(with, plane) - reaction(without, plane)).norm() < forces * weight);
	CHECK(std::abs(total(with) - total(without)) < 1e-5 * with.system.energy().elastic);
}

TEST_CASE("Sleep: what is pushed suddenly hands on what it does without sleep", "[sleep]")
{
	enum class How { kicked, loaded, loadedAwake };
	const How how = GENERATE(How::kicked, How::loaded, How::loadedAwake);
	const auto velocities = [](const Scene<2>& scene) {
		return ofWholes(scene, &WholeGrain<2>::velocity);
	};
	Scene<2> with = bed(true), without = bed(false);
	advance(without, rest(with, all));
	for (Scene<2>* scene : { &with, &without }) {
		loadMore(*scene, below + 3, 0.); // as the host, which tells all loads in each step
		if (how == How::kicked) kick(*scene, below + 3, { 0.6, -0.8 });
		if (how == How::loadedAwake) scene->system.activity().wake(below + 3);
		if (how != How::kicked) loadMore(*scene, below + 3, 20.);
	}
	double fastest = 0, dropped = 0;
	for (int n = 0; n < 20; ++n) {
		dropped += with.advance(0.5 * with.system.criticalTimeStep()).dropped.momentum;
		advance(without, 1);
		fastest = std::max(fastest, without.whole(below + 3).velocity.norm());
		CHECK(farthest(velocities(with), velocities(without)) < 2e-3 * fastest);
	}
	CHECK(dropped < 0.01 * without.whole(below + 3).mass * fastest);
}

TEMPLATE_TEST_CASE_SIG("Sleep: one that is held beside another gets no velocity, and wakes in time",
		       "[sleep]", ((int dim), dim), 2, 3)
{
	Scene<dim> scene; // one upon the other, between walls
	scene.add(dampedGrainsAt<dim>({ Vec<dim>::Zero(), 1.99 * radius * Vec<dim>::Unit(1) },
				      criticalDamping));
	scene.addPairs(0.3);
	scene.addPlane(0, -radius * Vec<dim>::Unit(1), Vec<dim>::Unit(1)).second = -1;
	for (int g : { 0, 1 })
		for (int axis = 0; axis < dim; ++axis)
			for (double side : { -1., 1. }) {
				if (axis == 1) continue;
				const Vec<dim> out = side * Vec<dim>::Unit(axis);
				scene.addPlane(g, radius * out, -out).second =
					-2 - 2 * axis - (side > 0);
			}
	weigh(scene);
	rest(scene, 2);
	const double weight = weightOf(scene, 2), onFloor = reaction(scene, -1)[1];
	const Vec<dim> centre = scene.whole(0).centre;
	loadMore(scene, 1, 2e-3);
	CHECK(mostAwake(scene, 400) == 1);
	CHECK(scene.whole(0).velocity.isZero(0));
	CHECK(scene.whole(0).centre == centre);
	CHECK(reaction(scene, -1)[1] == onFloor);
	loadMore(scene, 1, 0.1);
	CHECK(mostAwake(scene, 4000) == 2);
	CHECK(scene.whole(0).centre[1] < centre[1]);
	CHECK(std::abs((reaction(scene, -1)[1] - onFloor) / weight - 0.05) < 2e-3);
}
