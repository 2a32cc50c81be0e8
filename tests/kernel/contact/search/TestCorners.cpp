#include "Helpers.hpp"
#include "contact/Pressure.hpp"
#include "contact/search/Search.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

std::shared_ptr<const GrainTemplate<2>> blockTemplate(double zeta, double surfaceSpacing = 1)
{
	TemplateRecipe r = recipe(zeta);
	r.surfaceSpacing = surfaceSpacing;
	r.form.form = Form::block;
	r.form.aspect = { 2, 1, 1 };
	return makeGrainTemplate<2>(r);
}

/// Contacts of a block about the origin, two wide on each side of it and one high, with a congruent
/// one about another place.
struct TwoBlocks {
	std::shared_ptr<const GrainTemplate<2>> reference;
	ContactBody<2> first, second;
	ContactList<2> list = pairList<2>();

	TwoBlocks(double zeta, const Vec<2>& place, double reach)
		: reference(blockTemplate(zeta))
		, first(contactBody<2>(*reference, 1, { 0, 0 }))
		, second(contactBody<2>(*reference, 1, place))
	{
		findContacts(first, second, reach, list);
	}
};

} // namespace

TEST_CASE("Corners: blocks side by side touch on their sides alone", "[contact]")
{
	const auto reference = blockTemplate(0.5);
	for (double overlap : { -0.01, 0., 0.01, 0.2 }) {
		CAPTURE(overlap);
		const auto left = contactBody<2>(*reference, 1, { -2 + overlap / 2, 0 });
		const auto right = contactBody<2>(*reference, 1, { 2 - overlap / 2, 0 });
		auto list = pairList<2>();
		findContacts(left, right, 0.02, list);
		CHECK(list.contacts.size() == 10); // five nodes a side
		for (const Contact<2>& c : list.contacts) {
			CHECK(std::abs(c.normal[0]) > 1 - 1e-12);
			CHECK(std::abs(c.gap + overlap) < 1e-12);
		}
		CHECK(std::abs(list.deepest - std::max(0., overlap / 0.5)) < 1e-12);
	}
}

TEST_CASE("Corners: nodes beyond the end of a side do not touch it", "[contact]")
{
	// a block upon another, half a length aside: the sides meet over one unit of length
	const TwoBlocks blocks(0.5, { 3, 2 - 1e-3 }, 0.02);
	CHECK(blocks.list.contacts.size() == 6);
	for (const Contact<2>& c : blocks.list.contacts) {
		const auto& own = c.key.side == 0 ? blocks.first : blocks.second;
		const auto& x = own.position[c.key.node];
		CHECK((x[0] > 1 - 1e-9 && x[0] < 2 + 1e-9));
		CHECK(std::abs(std::abs(c.normal[1]) - 1) < 1e-12);
		CHECK(std::abs(c.gap + 1e-3) < 1e-12);
	}
}

TEST_CASE("Corners: edges upon edges touch across the faces", "[contact]")
{
	constexpr double dr = 0.5;
	for (double aside : { 0., 1e-12, -1e-12, 0.04 * dr, -0.04 * dr, 0.06 * dr, -0.06 * dr }) {
		CAPTURE(aside);
		const TwoBlocks blocks(dr, { aside, 2 + 1e-6 }, 0.02);
		const bool lostEdges = std::abs(aside) > 0.05 * dr;          // one of each block
		CHECK(blocks.list.contacts.size() == (lostEdges ? 16 : 18)); // nine nodes a side
		for (const Contact<2>& c : blocks.list.contacts) {
			CHECK(std::abs(std::abs(c.normal[1]) - 1) < 1e-12);
			CHECK(std::abs(c.gap - 1e-6) < 1e-12);
		}
	}
}

TEST_CASE("Corners: corner against corner touches across the distance", "[contact]")
{
	const TwoBlocks blocks(0.5, { 4.03, 2.04 }, 0.1);
	REQUIRE(blocks.list.contacts.size() == 2);
	for (const Contact<2>& c : blocks.list.contacts) {
		CHECK(std::abs(c.gap - 0.05) < 1e-12);
		const double sign = c.key.side == 0 ? -1 : 1;
		CHECK((c.normal - sign * Vec<2>(0.6, 0.8)).norm() < 1e-12);
	}
}

TEST_CASE("Corners: a deep overlap of blocks is still noticed", "[contact]")
{
	const TwoBlocks blocks(0.25, { 0.3, 1 }, 0.02);
	CHECK(blocks.list.deepest > 2);
}

TEST_CASE("Pressure: uniform forces give a uniform pressure on both sides", "[contact]")
{
	const double pressure = 700, kick = 1e-3;
	const auto coarse = blockTemplate(0.25), fine = blockTemplate(0.15);
	const auto lower = contactBody<2>(*coarse, 1, { 0, 0 });
	const auto upper = contactBody<2>(*fine, 1, { 0, 2 });
	auto list = pairList<2>();
	findContacts(lower, upper, 0.01, list);
	// half of it by the nodes of each side
	for (Contact<2>& c : list.contacts) {
		const auto area = (c.key.side == 0 ? lower : upper).nodeAreas()[c.key.node];
		c.impulse = 0.5 * kick * pressure * std::abs(area[1]) * c.normal;
	}
	double force[2] = { 0, 0 };
	const auto found = contactPressures<2>(lower, &upper, list.contacts, kick);
	for (std::size_t k = 0; k < found.size(); ++k) {
		CHECK(std::abs(found[k].pressure / pressure - 1) < 0.03);
		force[list.contacts[k].key.side] += found[k].pressure * found[k].area;
	}
	CHECK(std::abs(force[0] / (4 * pressure) - 1) < 0.01);
	CHECK(std::abs(force[1] / (4 * pressure) - 1) < 0.01);
}

TEST_CASE("Pressure: a pattern that no background node feels is not seen", "[contact]")
{
	const auto reference = blockTemplate(0.125);
	const auto body = contactBody<2>(*reference, 1, { 0, 0 });
	ContactList<2> list;
	list.first = 0;
	list.plane = { { 0, -1 }, { 0, 1 }, { 0, 0 } };
	findContacts(body, 0.01, list);
	REQUIRE(list.contacts.size() > 20);
	const double kick = 1e-3;
	int alternating = 1;
	for (Contact<2>& c : list.contacts) { // every second node carries all
		const double area = std::abs(body.nodeAreas()[c.key.node][1]);
		c.impulse = kick * area * (1 + alternating) * c.normal;
		alternating = -alternating;
	}
	const auto found = contactPressures<2>(body, nullptr, list.contacts, kick);
	for (std::size_t k = 0; k < found.size(); ++k)
		if (std::abs(body.position[list.contacts[k].key.node][0]) < 1.4)
			CHECK(std::abs(found[k].pressure - 1) < 0.01);
}
