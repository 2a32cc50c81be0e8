#include "Helpers.hpp"
#include "contact/search/PlaceOnRigid.hpp"
#include "contact/search/RigidTips.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <limits>
#include <set>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr auto anySide = [](const auto&) { return 1.; };
constexpr auto noWay = [](const auto&, const auto&) { return false; };

/// Distance to the surface of a block by sampling it.
template <int dim> double sampledDistance(const BlockSurface<dim>& block, const Vec<dim>& x)
{
	constexpr int samples = 60;
	double nearest = std::numeric_limits<double>::infinity();
	const int places = static_cast<int>(std::pow(samples + 1, dim - 1));
	for (int a = 0; a < dim; ++a)
		for (const double side : { -1., 1. })
			for (int k = 0; k < places; ++k) {
				Vec<dim> y;
				int rest = k;
				for (int b = 0; b < dim; ++b) {
					y[b] = b == a ? side
						      : 2. * (rest % (samples + 1)) / samples - 1;
					if (b != a) rest /= samples + 1;
				}
				const Vec<dim> place =
					block.centre + block.axes * y.cwiseProduct(block.halfSides);
				nearest = std::min(nearest, (x - place).norm());
			}
	return nearest;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("gap and normal of a block are those of its surface", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	Random random(1);
	BlockSurface<dim> block { random.vector<dim>(), random.rotation<dim>(), Vec<dim>::Ones() };
	for (int a = 0; a < dim; ++a)
		block.halfSides[a] = random.uniform(0.5, 1.5);
	int inside = 0;
	for (int k = 0; k < 200; ++k) {
		const Vec<dim> x = block.centre + random.vector<dim>(2);
		const auto place = placeOn<dim>(block, x, anySide);
		REQUIRE(place);
		const Vec<dim> y = block.axes.transpose() * (x - block.centre);
		const bool isInside = (y.cwiseAbs() - block.halfSides).maxCoeff() < 0;
		inside += isInside;
		CHECK((place->gap < 0) == isInside);
		CHECK(std::abs(std::abs(place->gap) - sampledDistance<dim>(block, x)) < 0.02);
		CHECK(std::abs(distanceTo<dim>(block, x) - std::max(place->gap, 0.)) < 1e-12);
		CHECK(std::abs(place->normal.norm() - 1) < 1e-12);
		const Vec<dim> foot = x - place->gap * place->normal;
		const Vec<dim> atFoot = block.axes.transpose() * (foot - block.centre);
		CHECK(std::abs((atFoot.cwiseAbs() - block.halfSides).maxCoeff()) < 1e-12);
	}
	CHECK(inside > 5);
}

TEMPLATE_TEST_CASE_SIG("a plate is touched on the side that the outline faces", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	PlateSurface<dim> plate;
	plate.corner[0] = Vec<dim>::Zero();
	for (int a = 1; a < dim; ++a)
		plate.corner[a] = Vec<dim>::Unit(a - 1);
	const Vec<dim> up = Vec<dim>::Unit(dim - 1);
	const Vec<dim> above = Vec<dim>::Constant(0.2);
	for (const double side : { 1., -1. }) {
		auto facing = [&](const Vec<dim>& n) { return side * up.dot(n); };
		const auto place = placeOn<dim>(plate, above, facing);
		REQUIRE(place);
		CHECK((place->normal - side * up).norm() < 1e-15);
		CHECK(std::abs(place->gap - side * 0.2) < 1e-15);
	}
	// beyond an end its distance is the gap
	Vec<dim> beyond = Vec<dim>::Zero();
	beyond[0] = -0.3;
	beyond[dim - 1] = 0.4;
	const auto place = placeOn<dim>(plate, beyond, anySide);
	REQUIRE(place);
	CHECK(std::abs(place->gap - 0.5) < 1e-12);
	CHECK(!placeOn<dim>(plate, beyond, [](const auto&) { return -1.; }));
}

TEST_CASE("a sharp corner that leans touches the side that it faces more", "[rigid]")
{
	const Vec<2> beneath = Vec<2>(0.12, -1).normalized(), above = Vec<2>(-1, 0.4).normalized();
	auto facing = [&](const Vec<2>& n) { return -std::min(beneath.dot(n), above.dot(n)); };
	const Vec<2> high(0, 1), low(0, -1);
	for (const RigidSurface<2>& upright :
	     { RigidSurface<2>(PlateSurface<2> { { low, high } }),
	       RigidSurface<2>(PlateSurface<2> { { high, low } }),
	       RigidSurface<2>(BlockSurface<2> { { 0, 0 }, Mat<2>::Identity(), { 0, 1 } }),
	       RigidSurface<2>(BlockSurface<2> { { -1, 0 }, Mat<2>::Identity(), { 1, 1 } }) })
		for (const double gap : { 0.01, 1e-17, 0., -1e-17, -0.01 }) {
			CAPTURE(upright.index(), gap);
			const auto place = placeOn<2>(upright, { gap, 0 }, facing);
			REQUIRE(place);
			CHECK((place->normal - Vec<2>(1, 0)).norm() < 1e-15);
			CHECK(std::abs(place->gap - gap) < 1e-15);
		}
}

TEST_CASE("at the edge of two sides a point lies before that which the outline faces more",
	  "[rigid]")
{
	const double sunk = 0.01;
	const Vec<2> edge(0, 0), right(1, 0), up(0, 1);
	const RigidSurface<2> block = BlockSurface<2> { { -1, -1 }, Mat<2>::Identity(), { 1, 1 } };
	const RigidSurface<2> top = PlateSurface<2> { { Vec<2>(-2, 0), edge } };
	const RigidSurface<2> side = PlateSurface<2> { { edge, Vec<2>(0, -2) } };
	auto goesAlong = [&](const Vec<2>& way) -> GoesOn<2> {
		return [way](const auto&, const Vec<2>& there) { return there.dot(way) > 0.9; };
	};
	for (const double angle : { 10., 40., 50., 80. })
		for (const double beneath : { 1e-9, 1e-4, 0.009 })
			for (const double beside : { 1e-9, 1e-4, 0.009 }) {
				CAPTURE(angle, beneath, beside);
				const double a = angle * M_PI / 180;
				const Vec<2> faced(std::sin(a), std::cos(a)), x(-beside, -beneath);
				auto facing = [&](const Vec<2>& n) { return faced.dot(n); };
				const bool isOnTop = angle < 45;
				const auto place = placeOn<2>(block, x, facing, noWay, sunk);
				REQUIRE(place);
				CHECK(place->normal == (isOnTop ? up : right));
				CHECK(placeOn<2>(top, x, facing, goesAlong(-up), sunk)
					      .has_value() == isOnTop);
				CHECK(placeOn<2>(side, x, facing, goesAlong(-right), sunk)
					      .has_value() != isOnTop);
			}
}

TEMPLATE_TEST_CASE_SIG("a plate that pokes into an outline has no side beneath its edge", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	PlateSurface<dim> plate; // upright, its upper edge at height 0
	plate.corner.fill(Vec<dim>::Zero());
	plate.corner[0][dim - 1] = -1;
	if (dim == 3) {
		plate.corner[1][1] = -1;
		plate.corner[2][1] = 1;
	}
	Vec<dim> x = Vec<dim>::Zero(), down = -Vec<dim>::Unit(dim - 1);
	x[0] = -0.3; // on the left, where the outline faces down and a little to the left
	x[dim - 1] = -0.01;
	const Vec<dim> outward = (down - 0.13 * Vec<dim>::Unit(0)).normalized();
	auto facing = [](const Vec<dim>& m) {
		return [m](const Vec<dim>& n) { return -m.dot(n); };
	};
	CHECK(!placeOn<dim>(plate, x, facing(outward)));
	const auto overlap = placeOn<dim>(plate, x, facing(-Vec<dim>::Unit(0)));
	REQUIRE(overlap); // an outline that faces the right side has passed through
	CHECK(std::abs(overlap->gap + 0.3) < 1e-12);
	x[dim - 1] = -0.4; // deeper than wide
	REQUIRE(placeOn<dim>(plate, x, facing(outward)));
}

TEMPLATE_TEST_CASE_SIG("what has come through a block touches the side that it faces", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	BlockSurface<dim> block; // upright, thin, its upper edge at height 0
	const double half = GENERATE(0., 1e-9, 0.01);
	block.halfSides[0] = half;
	block.centre[dim - 1] = -1;
	const Vec<dim> right = Vec<dim>::Unit(0), up = Vec<dim>::Unit(dim - 1);
	auto facing = [](const Vec<dim>& outward) {
		return [outward](const Vec<dim>& n) { return -outward.dot(n); };
	};
	const Vec<dim> x = -(half + 0.05) * right - 0.2 * up;
	const auto place = placeOn<dim>(block, x, facing(-right));
	REQUIRE(place);
	CHECK(place->isBehind);
	CHECK((place->normal - right).norm() < 1e-15);
	CHECK(std::abs(place->gap + 2 * half + 0.05) < 1e-15);
	const auto before = placeOn<dim>(block, x, facing(right));
	REQUIRE(before);
	CHECK(!before->isBehind);
	CHECK(std::abs(before->gap - 0.05) < 1e-15);
	// where the upper edge pokes into the outline, it has no side
	const Vec<dim> beneath = -(half + 0.05) * right - 0.01 * up;
	CHECK(!placeOn<dim>(block, beneath, facing((-right - up).normalized())));
	// an outline that lies upon either side lies along it at a corner
	const Vec<dim> corner = block.centre + block.halfSides;
	auto side = [&](const Vec<dim>& normal, double spacing) {
		return sideAlong<dim>(block, corner, normal, 0.1, spacing);
	};
	const auto ofRight = side(-right, 0.1), ofLeft = side(right, 0.1);
	REQUIRE(ofRight);
	CHECK(*ofRight == right);
	REQUIRE(ofLeft.has_value() == (half < 1e-8));
	if (ofLeft) CHECK(*ofLeft == -right);
	// one that stands on its narrow upper side does so where nodes are nearer than that is wide
	CHECK(!side(-up, 0.1));
	CHECK(side(-up, 0.001).has_value() == (half > 1e-3));
}

TEST_CASE("points of edges in space: as near as asked for, with numbers of their own", "[rigid]")
{
	Random random(3);
	const BlockSurface<3> block { random.vector<3>(), random.rotation<3>(), { 1, 0.5, 2 } };
	const double spacing = 0.3;
	const Box<3> everywhere { Vec<3>::Constant(-9), Vec<3>::Constant(9) };
	const auto all = tipsOf<3>(block, everywhere, spacing);
	const int points = 4 * (6 + 3 + 13); // of edges 2, 1 and 4 long
	CHECK(all.size() == 8 + points);
	for (const Tip<3>& tip : all) {
		const Vec<3> y = block.axes.transpose() * (tip.ball.centre - block.centre);
		const auto outer = (y.cwiseAbs() - block.halfSides).array().abs() < 1e-12;
		CHECK(outer.count() >= 2);
		for (const Tip<3>& other : all)
			CHECK((&tip == &other || tip.number != other.number));
	}
	const Box<3> about = Box<3> { all[20].ball.centre, all[20].ball.centre }.grown(0.5);
	int inside = 0;
	for (const Tip<3>& tip : tipsOf<3>(block, about, spacing)) {
		const bool found = std::any_of(all.begin(), all.end(), [&](const Tip<3>& other) {
			return other.number == tip.number && other.ball.centre == tip.ball.centre;
		});
		CHECK(found);
		inside += about.contains(tip.ball.centre);
	}
	CHECK(inside == std::count_if(all.begin(), all.end(), [&](const Tip<3>& tip) {
		      return about.contains(tip.ball.centre);
	      }));
}

TEST_CASE("an edge that is along an axis but for rounding has no points far away", "[rigid]")
{
	const Box<3> box { Vec<3>(-1, -1, 1), Vec<3>(1, 1, 2) };
	for (const double rounding : { 0., 2.8e-17, -2.8e-17, 1e-300 }) {
		const PlateSurface<3> plate { { Vec<3>(-1, -1, rounding), Vec<3>(1, -1, 0),
						Vec<3>(0, 1, -rounding) } };
		CHECK(tipsOf<3>(plate, box, 0.1).size() == 3); // the corners
	}
}

TEMPLATE_TEST_CASE_SIG("distance of plates and balls", "[rigid]", ((int dim), dim), 2, 3)
{
	Random random(7);
	PlateSurface<dim> plate;
	for (Vec<dim>& corner : plate.corner)
		corner = random.vector<dim>();
	const BallSurface<dim> ball { random.vector<dim>(), 0.3 };
	for (int k = 0; k < 100; ++k) {
		const Vec<dim> x = random.vector<dim>(2);
		double nearest = std::numeric_limits<double>::infinity();
		constexpr int samples = 200;
		for (int i = 0; i <= samples; ++i)
			for (int j = 0; j <= (dim == 2 ? 0 : samples - i); ++j) {
				Vec<dim> place = plate.corner[0];
				place += (plate.corner[1] - plate.corner[0]) * i / samples;
				if (dim == 3)
					place += (plate.corner[dim - 1] - plate.corner[0]) * j /
						 samples;
				nearest = std::min(nearest, (x - place).norm());
			}
		CHECK(distanceTo<dim>(plate, x) <= nearest + 1e-12);
		CHECK(distanceTo<dim>(plate, x) > nearest - 0.02);
		const double toBall = (x - ball.centre).norm() - 0.3;
		CHECK(std::abs(distanceTo<dim>(ball, x) - std::max(toBall, 0.)) < 1e-12);
	}
}

TEST_CASE("Tips: rounding of a body that turns changes no numbers", "[rigid]")
{
	Random random(7);
	const double spacing = 0.1;
	const Box<3> everywhere { Vec<3>::Constant(-9), Vec<3>::Constant(9) };
	std::size_t tips = 0;
	for (int k = 0; k < 200; ++k) {
		const BlockSurface<3> block { random.vector<3>(), random.rotation<3>(),
					      Vec<3>(4, 5, 8) * spacing };
		const auto found = tipsOf<3>(block, everywhere, spacing);
		if (k == 0) tips = found.size();
		CHECK(found.size() == tips);
	}
	CHECK(tips == 8 + 4 * (7 + 9 + 15));
}
