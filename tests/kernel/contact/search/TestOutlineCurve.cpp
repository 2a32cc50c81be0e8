#include "Helpers.hpp"
#include "contact/search/OutlineCurve.hpp"

#include <catch2/catch_test_macros.hpp>
#include <numeric>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

std::shared_ptr<const GrainTemplate<2>> templateOf(Form form)
{
	TemplateRecipe r = recipe(0.25);
	r.form.form = form;
	return makeGrainTemplate<2>(r);
}

} // namespace

TEST_CASE("Outline curve: smooth, through the nodes, with weights that move along", "[contact]")
{
	Random random(1);
	const auto reference = templateOf(Form::ball);
	auto body = contactBody<2>(*reference, 2, random.vector<2>());
	for (Vec<2>& x : body.position)
		x += random.vector<2>(0.05);
	for (int f = 0; f < body.nodes(); ++f) {
		const OutlineCurve curve(body, f), next(body, (f + 1) % body.nodes());
		const auto& facet = body.mesh->facet[f];
		CHECK((curve.at(0).position - body.position[facet[0]]).norm() < 1e-14);
		CHECK((curve.at(1).position - body.position[facet[1]]).norm() < 1e-14);
		CHECK((curve.at(1).tangent - next.at(0).tangent).norm() < 1e-14);
		const double t = random.uniform(0, 1), step = 1e-6;
		const auto place = curve.at(t);
		const auto weight = curve.weights(t);
		CHECK(std::abs(std::accumulate(weight.begin(), weight.end(), -1.)) < 1e-14);
		const Vec<2> difference = curve.at(t + step).position - curve.at(t - step).position;
		CHECK((place.tangent - difference / (2 * step)).norm() < 1e-8);
		Vec<2> sum = Vec<2>::Zero();
		for (int k = 0; k < 4; ++k)
			sum += weight[k] * body.position[curve.nodes()[k]];
		CHECK((place.position - sum).norm() < 1e-14);
		const Vec<2> chord =
			(1 - t) * body.position[facet[0]] + t * body.position[facet[1]];
		CHECK((place.position - chord).norm() <= curve.bulge());
	}
}

TEST_CASE("Outline curve: nearest place", "[contact]")
{
	Random random(2);
	const auto reference = templateOf(Form::ball);
	const auto body = contactBody<2>(*reference, 1, Vec<2>::Zero());
	for (int f = 0; f < body.nodes(); ++f) {
		const OutlineCurve curve(body, f);
		const double t = random.uniform(0.05, 0.95);
		const auto place = curve.at(t);
		const Vec<2> normal = Vec<2>(place.tangent[1], -place.tangent[0]).normalized();
		const auto found = curve.nearest(place.position - 0.05 * normal, t + 0.05);
		// two steps, each of which leaves gap times curvature, 0.05
		CHECK((found.position - place.position).norm() < 0.05 * 0.05 * 0.05 * 0.3);
		CHECK(curve.nearest(place.position + 10 * place.tangent, t).t == 1);
	}
}

TEST_CASE("Outline curve: sides of a block stay straight up to their corners", "[contact]")
{
	Random random(3);
	const auto reference = templateOf(Form::block);
	const auto body = contactBody<2>(*reference, 1, Vec<2>::Zero());
	for (int f = 0; f < static_cast<int>(body.mesh->facet.size()); ++f) {
		const OutlineCurve curve(body, f);
		const auto& facet = body.mesh->facet[f];
		const Vec<2> along = body.position[facet[1]] - body.position[facet[0]];
		const double t = random.uniform(0, 1);
		const auto place = curve.at(t);
		CHECK((place.tangent - along).norm() < 1e-14);
		CHECK((place.position - body.position[facet[0]] - t * along).norm() < 1e-14);
		for (int k : { 0, 3 })
			if (body.isSharp(facet[k / 2 > 0])) CHECK(curve.weights(t)[k] == 0);
	}
}
