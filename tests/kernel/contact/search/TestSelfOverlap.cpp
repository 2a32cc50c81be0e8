#include "Helpers.hpp"
#include "contact/search/SelfOverlap.hpp"

#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double foot = 1.5, gap = 2, height = 6;

/// A fork of two prongs of width 1.5.
TemplateRecipe twoProngs()
{
	Ring ring;
	ring.vertex = { { 0, 0 },      { 5, 0 },      { 5, height },   { 3.5, height },
			{ 3.5, foot }, { 1.5, foot }, { 1.5, height }, { 0, height } };
	ring.corner = { 0, 1, 2, 3, 4, 5, 6, 7 };
	return polygonRecipe(0.25, ring);
}

/// The prong on the right, shortened and leant over so that its tip is `depth` in the other one.
ContactOutline<2> leant(const ContactOutline<2>& upright, double depth)
{
	ContactOutline<2> body = upright;
	const double slot = upright.box.low[1] + foot;
	for (Vec<2>& x : body.position)
		if (x[0] > 0.5 && x[1] > slot) {
			x[0] -= (gap + depth) * (x[1] - slot) / (height - foot);
			x[1] -= 0.1 * (x[1] - slot);
		}
	body.updateGeometry();
	return body;
}

} // namespace

TEST_CASE("Self-overlap: how deep one prong of a fork is in the other", "[contact]")
{
	const auto reference = makeGrainTemplate<2>(twoProngs());
	const auto upright = contactBody<2>(*reference, 1, { 0, 0 });
	CHECK(selfOverlap(upright) == 0);
	CHECK(selfOverlap(leant(upright, -0.05)) == 0);
	for (double depth : { 0.05, 0.4, 1.2 })
		CHECK(selfOverlap(leant(upright, depth)) ==
		      Catch::Approx(depth).margin(2e-3 * upright.pointSpacing));
}

TEST_CASE("Self-overlap: none of what does not reach itself", "[contact]")
{
	const auto disk = makeGrainTemplate<2>(recipe(0.25));
	CHECK(selfOverlap(contactBody<2>(*disk, 2, { 0.1, 0.2 })) == 0);
	TemplateRecipe points = recipe(0.25);
	points.contact = ContactGeometry::points;
	const auto dotted = makeGrainTemplate<2>(points);
	CHECK(selfOverlap(contactBody<2>(*dotted, 2, { 0.1, 0.2 })) == 0);
}
