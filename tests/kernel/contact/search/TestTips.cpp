// Outlines that turn by much at a node: tips of needles, dents, folds.
#include "Helpers.hpp"
#include "contact/search/RigidLists.hpp"
#include "contact/search/Search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double degree = std::numbers::pi / 180;

Vec<2> turnedBy(double angle, const Vec<2>& v) { return Eigen::Rotation2Dd(angle) * v; }

/// A triangle whose tip, of this half angle, points down and turned by another angle.
struct Tip {
	std::shared_ptr<const GrainTemplate<2>> reference;
	ContactBody<2> body;
	int node = 0; ///< the tip

	explicit Tip(double half, double turn = 0)
	{
		const double length = 1.5, wide = length * std::tan(half);
		Ring ring { { { 0, 0 }, { wide, length }, { -wide, length } }, { 0, 1, 2 } };
		reference = makeGrainTemplate<2>(polygonRecipe(0.5, ring));
		body = contactBody<2>(*reference, 1, Vec<2>::Zero(),
				      Eigen::Rotation2Dd(turn).toRotationMatrix());
		auto isLower = [](const Vec<2>& a, const Vec<2>& b) { return a[1] < b[1]; };
		node = static_cast<int>(
			std::min_element(body.position.begin(), body.position.end(), isLower) -
			body.position.begin());
		REQUIRE(body.isSharp(node));
	}
	/// Puts the tip there.
	void moveTo(const Vec<2>& place)
	{
		const Vec<2> way = place - body.position[node];
		for (Vec<2>& x : body.position)
			x += way;
		body.updateGeometry();
	}
};

/// Of a contact of the tip.
void checkTip(const std::vector<Contact<2>>& contacts, int side, const Tip& tip, double gap)
{
	const auto found = std::find_if(contacts.begin(), contacts.end(), [&](const auto& c) {
		return c.key.side == side && c.key.node == tip.node;
	});
	REQUIRE(found != contacts.end());
	CHECK((found->normal - Vec<2>(0, 1)).norm() < 1e-12);
	CHECK(std::abs(found->gap - gap) < 1e-12);
}

} // namespace

TEST_CASE("Tips: a corner faces whatever lies between its sides", "[contact]")
{
	const double half = GENERATE(1, 5, 30, 45) * degree;
	const Tip tip(half);
	const NodeFacing<2> facing(tip.body, tip.node);
	const double fan = 0.5 * std::numbers::pi - half; // to either side
	for (double angle : { 0., 0.3, -0.75, 1.02 })
		if (std::abs(angle) < fan) {
			const double most = std::max(std::cos(fan - std::abs(angle)), 0.5);
			CHECK(std::abs(facing(turnedBy(angle, { 0, 1 })) - most) < 1e-12);
		}
	for (double beyond : { 0.1, 1., 1.5 })
		for (double sign : { -1., 1. }) {
			const Vec<2> direction = turnedBy(sign * (fan + beyond), { 0, 1 });
			CHECK(std::abs(facing(direction) - std::cos(beyond)) < 1e-12);
		}
	CHECK(facing.isAgainst({ 0, 1 }));
	CHECK_FALSE(facing.isAgainst({ 0, -1 }));
}

TEST_CASE("Tips: needles meet grains and rigid bodies head-on", "[contact]")
{
	const double half = GENERATE(1, 3, 5, 15) * degree;
	const double turn = GENERATE(0., 0.5, -0.9) * half;
	Tip tip(half, turn);
	TemplateRecipe block = recipe(0.5);
	block.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(block);
	const auto below = contactBody<2>(*reference, 2, { 0, -2 });
	const RigidSurface<2> plate = PlateSurface<2> { { Vec<2>(-3, 0), Vec<2>(3.1, 0) } };
	const RigidSurface<2> box = BlockSurface<2> { { 0.1, -1 }, Mat<2>::Identity(), { 3, 1 } };
	for (double gap : { 0.01, 0., -1e-3, -0.05 }) {
		CAPTURE(half, turn, gap);
		tip.moveTo({ 0.17, gap });
		auto list = pairList<2>();
		findContacts(below, tip.body, 0.02, list);
		checkTip(list.contacts, 1, tip, gap);
		for (const RigidSurface<2>& surface : { plate, box })
			checkTip(contactsWith<2>({ surface }, tip.body, 0.02), 0, tip, gap);
	}
}

TEST_CASE("Tips: where a smooth outline is bent it faces as a corner does", "[contact]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.25));
	const auto round = contactBody<2>(*reference, 2, { 0.1, 0.2 });
	CHECK(!round.bent);
	constexpr int node = 7;
	for (double height : { -3., -1., 1., 3. }) { // over the longest edge
		ContactOutline<2> body = round;
		const Vec<2> out = round.normal[node];
		body.position[node] += height * round.longestEdge * out;
		body.updateGeometry();
		CHECK(body.bent);
		CHECK(body.isBent(node));
		CHECK_FALSE(body.isBent(node + 9));
		const NodeFacing<2> facing(body, node);
		for (int facet : body.mesh->facetsAbout[node]) // flanks are faced in full
			CHECK(std::abs(facing.ofSides(-body.normalOfFacet(facet)) - 1) < 1e-12);
		if (height > 0) CHECK(facing(-out) >= 0.5);
	}
}

TEST_CASE("Tips: a node before the dent of a coarse outline is not within the grain", "[contact]")
{
	Ring bean; // smooth, dented at the top
	for (int k = 0; k < 72; ++k) {
		const double t = 2 * std::numbers::pi * k / 72;
		const double fromTop = (t - 0.5 * std::numbers::pi) / 0.6;
		const double r = 1 - 0.35 * std::exp(-fromTop * fromTop);
		bean.vertex.emplace_back(r * std::cos(t), r * std::sin(t));
	}
	const auto reference = makeGrainTemplate<2>(polygonRecipe(0.3, bean));
	const auto dented = contactBody<2>(*reference, 1, Vec<2>::Zero());
	int dents = 0;
	for (std::size_t f = 0; f < dented.mesh->facet.size(); ++f) {
		const auto [begin, end] = dented.mesh->facet[f];
		const Vec<2> out = dented.normalOfFacet(static_cast<int>(f));
		const Vec<2> along = dented.position[end] - dented.position[begin];
		const double turn = cross(dented.normal[begin], dented.normal[end]);
		if (turn > -0.05) continue; // not dented here
		++dents;
		const Vec<2> middle = 0.5 * (dented.position[begin] + dented.position[end]);
		Tip tip(15 * degree);
		tip.body.position[0] = middle - 1e-3 * along.norm() * out; // inside of the polygon
		REQUIRE(dented.encloses(tip.body.position[0]));
		const Vec<2> place = tip.body.position[0];
		for (int s = 1; s < tip.body.nodes(); ++s) // all others farther away
			tip.body.position[s] = place + 0.05 * s * out;
		tip.body.updateGeometry();
		auto list = pairList<2>();
		findContacts(dented, tip.body, 1e-9, list);
		CAPTURE(f);
		CHECK(std::isfinite(list.deepest));
	}
	CHECK(dents >= 2);
}
