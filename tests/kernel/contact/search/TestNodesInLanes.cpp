#include "Helpers.hpp"
#include "contact/search/NodesInLanes.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Nodes in lanes: each is measured as on its own, bit by bit", "[contact]")
{
	Random random(3);
	const Form form = GENERATE(Form::ball, Form::block);
	CAPTURE(form);
	TemplateRecipe outline = recipe(0.25);
	outline.form.form = form;
	const auto reference = makeGrainTemplate<2>(outline);
	auto body = contactBody<2>(*reference, 2, random.vector<2>());
	for (Vec<2>& x : body.position)
		x += random.vector<2>(0.05);
	NodesInLanes lanes;
	for (int count = 1; count <= NodesInLanes::most; ++count) {
		lanes.clear();
		std::vector<Contact<2>> expected(count);
		for (Contact<2>& contact : expected) {
			const int facet = random.index(body.nodes());
			const double t = random.uniform(0, 1);
			const OutlineCurve curve(body, facet);
			const Vec<2> x = curve.at(t).position + random.vector<2>(0.2);
			measureGap(x, body, { facet, { 1 - t, t }, 0 }, contact);
			lanes.add(x, body, facet, t);
		}
		REQUIRE(lanes.count() == count);
		lanes.measure();
		for (int lane = 0; lane < count; ++lane) {
			Contact<2> contact;
			lanes.write(lane, contact);
			CHECK(lanes.gap(lane) == expected[lane].gap);
			CHECK(contact.gap == expected[lane].gap);
			CHECK(contact.normal == expected[lane].normal);
			CHECK(contact.weight == expected[lane].weight);
			CHECK(contact.partner == expected[lane].partner);
			CHECK(contact.partners == expected[lane].partners);
			CHECK(contact.facet == expected[lane].facet);
		}
	}
}
