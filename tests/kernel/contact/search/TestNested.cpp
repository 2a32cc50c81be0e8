#include "contact/search/RigidLists.hpp"

#include <catch2/catch_test_macros.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// A bar, 16 long and 2 thick, bent to half a circle and more that opens upwards.
ContactBody<2> bentBar(const GrainTemplate<2>& reference)
{
	constexpr double radius = 5; // of its middle line
	ContactBody<2> body = contactBody<2>(reference, 1, Vec<2>::Zero());
	for (Vec<2>& x : body.position) {
		const double angle = x[0] / radius, r = radius - x[1];
		x = { r * std::sin(angle), radius - r * std::cos(angle) };
	}
	body.updateGeometry();
	return body;
}

} // namespace

TEST_CASE("what lies in the bend of a bar is not inside it", "[contact][rigid]")
{
	TemplateRecipe r = recipe(0.4);
	r.form.form = Form::block;
	r.form.aspect = { 8, 1, 1 };
	const auto reference = makeGrainTemplate<2>(r);
	const auto bar = bentBar(*reference);
	const Vec<2> middle = bar.box.centre();
	REQUIRE(!bar.encloses(middle));
	const double radius = middle[1] - 1 - 0.01; // it touches the bend
	auto rigid = listWith<2>(BallSurface<2> { middle, radius });
	findContacts<2>(bar, 0.05, rigid);
	const auto round = makeGrainTemplate<2>(recipe(0.2));
	const auto disk = contactBody<2>(*round, radius, middle);
	auto list = pairList<2>(), back = pairList<2>();
	findContacts<2>(bar, disk, 0.05, list);
	findContacts<2>(disk, bar, 0.05, back);
	for (const auto* found : { &rigid, &list, &back }) {
		CHECK(!found->contacts.empty());
		CHECK(found->deepest < 0.1);
	}
}
