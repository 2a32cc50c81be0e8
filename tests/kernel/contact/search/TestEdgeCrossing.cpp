#include "contact/search/EdgeCrossing.hpp"
#include "contact/search/RigidLists.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

Mat<3> turned(double angle, const Vec<3>& axis)
{
	return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// An edge of right angle along x through the origin, its sides below it.
ConvexEdge ridge()
{
	const double c = std::sqrt(0.5);
	return { { { -1, 0, 0 }, { 1, 0, 0 } }, { { { 0, c, -c }, { 0, -c, -c } } } };
}

ConvexEdge moved(const ConvexEdge& edge, const Mat<3>& turn, const Vec<3>& way)
{
	return { { turn * edge.from + way, turn * edge.to + way },
		 { { turn * edge.side[0], turn * edge.side[1] } } };
}

/// Of pieces that end where they end.
std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second)
{
	const auto nearest = nearestPlaces(first, second);
	if (!nearest || !isBetweenEnds(nearest->onFirst) || !isBetweenEnds(nearest->onSecond))
		return std::nullopt;
	return softgrain::crossingOf(first, second, *nearest);
}

const Mat<3> upsideDown = turned(M_PI, Vec<3>::UnitX());

std::shared_ptr<const GrainTemplate<3>> cubeTemplate(double zeta = 0.5)
{
	TemplateRecipe r = recipe(zeta, 2);
	r.form.form = Form::block;
	return makeGrainTemplate<3>(r);
}

/// The corner of a cube to the left and beneath is at its edge along x, now on top.
const Mat<3> edgeUpAlongX = turned(0.25 * M_PI, Vec<3>::UnitX());
const Mat<3> edgeDownAlongY = turned(0.25 * M_PI, Vec<3>::UnitY());

/// Two cubes of half a side 1 whose edges, one upwards along x, the other downwards along y, cross
/// between their nodes.
struct CrossedCubes {
	std::shared_ptr<const GrainTemplate<3>> reference = cubeTemplate();
	ContactBody<3> lower, upper;
	ContactList<3> list = pairList<3>();

	explicit CrossedCubes(double gap, double reach)
		: lower(contactBody<3>(*reference, 1, Vec<3>::Zero(), edgeUpAlongX))
		, upper(contactBody<3>(*reference, 1, { 0.3, 0.2, 2 * std::sqrt(2) + gap },
				       edgeDownAlongY))
	{
		findContacts<3>(lower, upper, reach, list);
	}
};

} // namespace

TEST_CASE("edges touch where they cross", "[contact]")
{
	Random random(3);
	for (int k = 0; k < 50; ++k) {
		const double gap = random.uniform(-0.3, 0.3), angle = random.uniform(0.2, 2.9);
		const Vec<3> place(random.uniform(-0.5, 0.5), 0, 0);
		const double share = random.uniform(0.1, 0.9);
		const Mat<3> turn = turned(angle, Vec<3>::UnitZ()) * upsideDown;
		ConvexEdge other = moved(ridge(), turn, Vec<3>::Zero());
		const Vec<3> onOther = other.from + share * (other.to - other.from);
		other = moved(ridge(), turn, place - onOther + Vec<3>(0, 0, gap));

		const Mat<3> anyTurn = random.rotation<3>();
		const Vec<3> anyWay = random.vector<3>();
		const ConvexEdge a = moved(ridge(), anyTurn, anyWay),
				 b = moved(other, anyTurn, anyWay);
		const auto crossing = crossingOf(a, b), back = crossingOf(b, a);
		REQUIRE(crossing);
		REQUIRE(back);
		CHECK(std::abs(crossing->gap - gap) < 1e-12);
		CHECK((crossing->normal - anyTurn.col(2)).norm() < 1e-12);
		CHECK(std::abs(crossing->onFirst - 0.5 * (place[0] + 1)) < 1e-12);
		CHECK(std::abs(crossing->onSecond - share) < 1e-12);
		CHECK(std::abs(back->gap - gap) < 1e-12);
		CHECK((back->normal + crossing->normal).norm() < 1e-12);
		CHECK(std::abs(back->onFirst - crossing->onSecond) < 1e-12);
	}
}

TEST_CASE("an edge of a plate is crossed however it lies", "[contact]")
{
	Random random(5);
	const Vec<3> down = -Vec<3>::UnitZ();
	const ConvexEdge plate { ridge(), { down, down } };
	const Mat<3> across = turned(1, Vec<3>::UnitZ()) * upsideDown;
	for (int k = 0; k < 50; ++k) {
		const Mat<3> turn = random.rotation<3>();
		const auto crossing =
			crossingOf(moved(plate, turn, Vec<3>::Zero()),
				   moved(ridge(), turn * across, turn * Vec<3>(0, 0, -0.1)));
		REQUIRE(crossing);
		CHECK(std::abs(crossing->gap + 0.1) < 1e-12);
	}
}

TEST_CASE("edges that nodes hold apart, or that end before, do not cross", "[contact]")
{
	const auto crosses = [](const Mat<3>& turn, const Vec<3>& way) {
		const ConvexEdge other = moved(ridge(), turn, way);
		const auto crossing = crossingOf(ridge(), other), back = crossingOf(other, ridge());
		CHECK(crossing.has_value() == back.has_value());
		return crossing.has_value();
	};
	const Mat<3> across = turned(0.5 * M_PI, Vec<3>::UnitZ()) * upsideDown;
	CHECK(crosses(across, { 0.9, 0.9, 0.1 }));
	CHECK(!crosses(across, { 1.1, 0, 0.1 }));
	CHECK(!crosses(across, { 0, -1.1, 0.1 }));
	CHECK(!crosses(turned(0.05, Vec<3>::UnitZ()) * upsideDown, { 0, 0, 0.1 }));
	// both upwards: one would have to be inside of the other body
	CHECK(!crosses(turned(0.5 * M_PI, Vec<3>::UnitZ()), { 0, 0, 0.1 }));
	// leant on one of its sides, or nearly
	CHECK(crosses(turned(0.6, Vec<3>::UnitX()) * across, { 0, 0, 0.1 }));
	for (const double lean : { 0.77, 0.25 * M_PI, 0.9 })
		CHECK(!crosses(turned(lean, Vec<3>::UnitX()) * across, { 0, 0, 0.1 }));
	// so acute that the other edge is before one of its sides
	const ConvexEdge blade { { { -1, 0, 0 }, { 1, 0, 0 } },
				 { { { 0, 0.2, -0.98 }, { 0, -0.2, -0.98 } } } };
	for (const double gap : { 0.1, -0.1 })
		for (const double lean : { 0., 1.2 }) {
			const Mat<3> turn = turned(lean, Vec<3>::UnitX());
			const Vec<3> way(0, 0, gap);
			const auto crossing = crossingOf(moved(blade, turn, Vec<3>::Zero()),
							 moved(ridge(), across, way));
			CHECK(crossing.has_value() == (gap > 0 || lean == 0));
		}
}

TEST_CASE("the sharp edges of a cuboid are those of its sides", "[contact]")
{
	TemplateRecipe r = recipe(0.4, 2);
	r.form.form = Form::block;
	r.form.aspect = { 1, 1.5, 2 };
	const auto reference = makeGrainTemplate<3>(r);
	const ContactBody<3> body = contactBody<3>(*reference, 1, Vec<3>::Zero());
	double length = 0;
	int ends = 0;
	for (int e = 0; e < static_cast<int>(body.mesh->sharpEdge.size()); ++e) {
		const auto edge = edgeOf(body, e);
		REQUIRE(edge);
		length += (edge->to - edge->from).norm();
		CHECK(std::abs(edge->side[0].dot(edge->side[1])) < 1e-12);
		for (const Vec<3>& side : edge->side)
			CHECK(edge->from.dot(side) < 0); // inwards
		for (const int next : body.mesh->sharpEdge[e].next) {
			ends += next < 0;
			if (next < 0) continue;
			const EdgePiece other = pieceOf(body, next);
			CHECK((edge->to - edge->from).cross(other.to - other.from).norm() < 1e-12);
		}
	}
	CHECK(ends == 2 * 12);
	CHECK(std::abs(length - 4 * (2 + 3 + 4)) < 1e-10);
	CHECK(contactBody<3>(*makeGrainTemplate<3>(recipe(0.4, 2)), 1, Vec<3>::Zero())
		      .mesh->sharpEdge.empty());
}

TEST_CASE("cubes touch where their edges cross between nodes", "[contact]")
{
	for (const double gap : { -0.05, 0.01 }) {
		CAPTURE(gap);
		const CrossedCubes cubes(gap, 0.02);
		REQUIRE(cubes.list.contacts.size() == 1);
		const Contact<3>& c = cubes.list.contacts[0];
		CHECK(std::abs(c.gap - gap) < 1e-12);
		CHECK((c.normal - Vec<3>::UnitZ()).norm() < 1e-12);
		Vec<3> onLower = Vec<3>::Zero(), onUpper = Vec<3>::Zero();
		for (int i = 0; i < c.partners; ++i)
			onLower += c.weight[i] * cubes.lower.position[c.partner[i]];
		c.forOwnNodes(
			[&](int node, double w) { onUpper += w * cubes.upper.position[node]; });
		const Vec<3> place(0.3, 0, std::sqrt(2));
		CHECK((onLower - place).norm() < 1e-12);
		CHECK((onUpper - place - Vec<3>(0, 0, gap)).norm() < 1e-12);
		CHECK(std::abs(cubes.list.deepest - std::max(0., -gap / 0.5)) < 1e-12);
	}
	CHECK(CrossedCubes(0.03, 0.02).list.contacts.empty());
}

namespace {

/// A cube on its edge along y, whose nodes are off by up to so much, up or down.
struct BentCube {
	std::shared_ptr<const GrainTemplate<3>> reference = cubeTemplate();
	ContactBody<3> body;
	std::vector<Vec<3>> edge; ///< its nodes, in a row

	BentCube(double bend, Random& random)
		: body(contactBody<3>(*reference, 1, { 0, 0, std::sqrt(2) }, edgeDownAlongY))
	{
		for (Vec<3>& x : body.position)
			if (std::abs(x[2]) < 1e-9) {
				x[2] += random.uniform(-bend, bend);
				edge.push_back(x);
			}
		std::sort(edge.begin(), edge.end(),
			  [](const Vec<3>& a, const Vec<3>& b) { return a[1] < b[1]; });
		body.updateGeometry();
	}
	double heightAt(double y) const
	{
		std::size_t k = 1;
		while (edge[k][1] < y)
			++k;
		const double share = (y - edge[k - 1][1]) / (edge[k][1] - edge[k - 1][1]);
		return (1 - share) * edge[k - 1][2] + share * edge[k][2];
	}
};

/// Those of edges; by the gap at their places they are the overlap that there is, or on the line of
/// a piece a little past its end.
int crossingsOf(const std::vector<Contact<3>>& contacts, double overlap)
{
	int found = 0;
	for (const Contact<3>& c : contacts) {
		if (!c.key.isOfEdges()) continue;
		++found;
		CHECK(std::abs(c.gap + overlap) < 0.03);
	}
	return found;
}

} // namespace

TEST_CASE("a bent edge is crossed wherever", "[contact][rigid]")
{
	Random random(7);
	for (int k = 0; k < 2000; ++k) {
		const BentCube cube(0.05, random); // 0.1 dr
		const double y = random.uniform(-0.8, 0.8), overlap = random.uniform(0.01, 0.1);
		const double angle = random.uniform(-1, 1), top = cube.heightAt(y) + overlap;
		CAPTURE(k, y, overlap, angle);
		const Vec<3> along(3 * std::cos(angle), 3 * std::sin(angle), 0);
		const Vec<3> place(0, y, top), foot(0.1, y, -4);
		const PlateSurface<3> plate { { place - along, place + along, foot } };
		CHECK(crossingsOf(contactsWith<3>({ plate }, cube.body, 0.02), overlap) >= 1);

		// the same by another grain
		const Mat<3> turn = turned(angle, Vec<3>::UnitZ()) * edgeUpAlongX;
		const auto other =
			contactBody<3>(*cube.reference, 1, { 0.1, y, top - std::sqrt(2) }, turn);
		auto list = pairList<3>();
		findContacts<3>(other, cube.body, 0.02, list);
		CHECK(crossingsOf(list.contacts, overlap) >= 1);
	}
}

TEST_CASE("edges that overlap cross on the nearest way out", "[contact]")
{
	const auto reference = cubeTemplate();
	const auto cube = contactBody<3>(*reference, 1, { 0, 0, std::sqrt(2) }, edgeDownAlongY);
	const double dr = cube.pointSpacing;
	const EdgeCrossing deep { { 0.5, 0.5 }, Vec<3>::UnitZ(), -dr };
	// the distance from the sides is 0.7 of the height above the edge
	for (const double height : { 1., 0.9 })
		CHECK(isWayOut(deep, { 0, 0.3, height * dr }, cube, dr));
	for (const double height : { 0.8, 0.1, -0.1, -1. })
		CHECK(!isWayOut(deep, { 0, 0.3, height * dr }, cube, dr));
	CHECK(isWayOut(deep, { 0, 0.3, 0.1 * dr }, cube, 4 * dr));
	const EdgeCrossing shallow { { 0.5, 0.5 }, Vec<3>::UnitZ(), -0.1 * dr };
	CHECK(isWayOut(shallow, { 0, 0.3, 0.01 * dr }, cube, dr));
}

TEST_CASE("cubes that lie upon each other touch by nodes alone", "[contact]")
{
	const auto reference = cubeTemplate();
	const auto lower = contactBody<3>(*reference, 1, Vec<3>::Zero());
	for (const double angle : { 0., 0.4, 0.25 * M_PI }) {
		auto list = pairList<3>();
		const auto upper = contactBody<3>(*reference, 1, { 0.3, 0.2, 1.99 },
						  turned(angle, Vec<3>::UnitZ()));
		findContacts<3>(lower, upper, 0.02, list);
		CHECK(list.contacts.size() > 20);
		for (const Contact<3>& c : list.contacts)
			CHECK(!c.key.isOfEdges());
	}
}

TEST_CASE("edges of a cube cross those of rigid bodies", "[contact][rigid]")
{
	const auto reference = cubeTemplate();
	const double gap = GENERATE(-0.05, 0.01);
	const Vec<3> centre(0.3, 0.2, std::sqrt(2) + gap); // of a cube whose edge crosses z = 0
	const auto upper = contactBody<3>(*reference, 1, centre, edgeDownAlongY);
	const Vec<3> down(0, 0, -std::sqrt(2));
	const BlockSurface<3> box { down, edgeUpAlongX, { 3, 1, 1 } };
	const Vec<3> left(-3.1, 0, 0), right(2.9, 0, 0);
	const PlateSurface<3> steep { { left, right, Vec<3>(0.1, -3, -4) } },
		other { { right, left, Vec<3>(0.2, 3, -4) } };
	const std::vector<std::vector<RigidSurface<3>>> scenes {
		{ box }, { steep }, { steep, other }, { box, steep }
	};
	for (const auto& surfaces : scenes) {
		const auto contacts = contactsWith<3>(surfaces, upper, 0.02);
		int crossings = 0;
		for (const Contact<3>& c : contacts) {
			if (!c.key.isOfEdges()) continue;
			++crossings;
			CHECK(std::abs(c.gap - gap) < 1e-12);
			CHECK((c.normal + Vec<3>::UnitZ()).norm() <
			      1e-12); // towards the rigid edge
			Vec<3> place = Vec<3>::Zero();
			for (int i = 0; i < c.partners; ++i)
				place += c.weight[i] * upper.position[c.partner[i]];
			CHECK((place - Vec<3>(0.3, 0, gap)).norm() < 1e-12);
		}
		CHECK(crossings == 1);
	}
}

TEST_CASE("an edge over the seams of a floor crosses none", "[contact][rigid]")
{
	const auto reference = cubeTemplate();
	const auto cube =
		contactBody<3>(*reference, 1, { 0.3, 0.2, std::sqrt(2) - 0.01 }, edgeDownAlongY);
	std::vector<RigidSurface<3>> boxes, plates;
	for (const double y : { -1., 1. })
		boxes.push_back(BlockSurface<3> { { 0, y, -1 }, Mat<3>::Identity(), { 3, 1, 1 } });
	const Vec<3> a(-3, -3, 0), b(3, -3, 0), c(3, 3, 0), d(-3, 3, 0);
	plates.push_back(PlateSurface<3> { { a, b, c } });
	plates.push_back(PlateSurface<3> { { a, c, d } });
	for (const auto& floor : { boxes, plates })
		for (const Contact<3>& contact : contactsWith<3>(floor, cube, 0.02))
			CHECK(!contact.key.isOfEdges());
}
