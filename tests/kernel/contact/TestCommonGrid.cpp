#include "step/Scene.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

TemplateRecipe onGrid(double zeta)
{
	TemplateRecipe r = recipe(zeta);
	r.contact = ContactGeometry::nodes;
	return r;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Common grid: nodes get all mass, its centre and its gradient", "[contact]",
		       ((int dim), dim), 2, 3)
{
	Random random(3);
	GridPoints<dim> points;
	double mass = 0;
	Vec<dim> first = Vec<dim>::Zero();
	for (int p = 0; p < 200; ++p) {
		points.position.push_back(random.vector<dim>(1.5));
		points.mass.push_back(random.uniform(0.1, 1));
		mass += points.mass.back();
		first += points.mass.back() * points.position.back();
	}
	const double spacing = 0.4;
	const auto nodes = nodesOnGrid(points, spacing);
	Vec<dim> gradient = Vec<dim>::Zero(), centre = first;
	for (std::size_t J = 0; J < nodes.size(); ++J) {
		mass -= nodes[J].mass;
		centre -= nodes[J].mass * nodes[J].centre;
		gradient += nodes[J].gradient;
		double shares = 0;
		for (const auto& [p, share] : nodes[J].share)
			shares += share;
		CHECK(std::abs(shares - 1) < 1e-13);
		if (J > 0) CHECK(nodes[J - 1].index < nodes[J].index);
	}
	CHECK(std::abs(mass) < 1e-11);
	CHECK(centre.norm() < 1e-11);
	CHECK(gradient.norm() < 1e-10); // the hats sum to 1
}

TEST_CASE("Common grid: two disks collide, conserve momentum and part again", "[contact]")
{
	Scene<2> scene;
	// gaps jump where a body begins to give mass to a node: not to be made good at once
	scene.settings.solver.overlapSpeed = 0.04;
	auto grain = paperGrain<2>();
	for (double side : { -1., 1. }) {
		grain.origin = { 0.0105 * side, 0.001 * side };
		auto batch = singleGrain<2>(onGrid(0.2), grain);
		batch.place(0, Mat<2>::Identity(), { -side, 0 }, Mat<2>::Zero());
		scene.add(std::move(batch));
	}
	scene.addPairs(0.3);
	int active = 0;
	while (scene.time < 0.004) {
		const StepReport report = scene.advance();
		active += report.solver.active > 0;
		CHECK(scene.momentum().norm() < 1e-13);
	}
	CHECK(active > 20);
	CHECK(scene.whole(0).velocity[0] < -0.3);
	CHECK(scene.whole(1).velocity[0] > 0.3);
	CHECK(scene.deepest < 1);
}

TEST_CASE("Common grid: a wall stops a disk near its outline", "[contact]")
{
	Scene<2> scene;
	scene.settings.solver.overlapSpeed = 0.04;
	auto grain = paperGrain<2>();
	grain.origin = { 0.003, 0.011 };
	auto batch = singleGrain<2>(onGrid(0.1), grain);
	batch.place(0, Mat<2>::Identity(), { 0, -0.5 }, Mat<2>::Zero());
	scene.add(std::move(batch));
	scene.addPlane(0, { 0, 0 }, { 0, 1 });
	double lowest = 1;
	while (scene.time < 0.01) {
		scene.advance();
		for (const Vec<2>& x : scene.system.body(0).position)
			lowest = std::min(lowest, x[1]);
	}
	CHECK(scene.whole(0).velocity[1] > 0.2);
	CHECK(std::abs(lowest) < 0.5 * scene.system.body(0).gridSpacing);
}
