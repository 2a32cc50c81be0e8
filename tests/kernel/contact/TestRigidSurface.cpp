#include "Helpers.hpp"
#include "contact/OutlineSearch.hpp"
#include "contact/Search.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr auto anySide = [](const auto&, double) { return true; };

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

template <int dim> ContactList<dim> listWith(const RigidSurface<dim>& surface)
{
	ContactList<dim> list;
	list.first = 0;
	list.rigid.emplace();
	list.rigid->surface = surface;
	return list;
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
		auto faces = [&](const Vec<dim>& n, double) { return side * up.dot(n) > 0.1; };
		const auto place = placeOn<dim>(plate, above, faces);
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
	CHECK(!placeOn<dim>(plate, beyond, [](const auto&, double) { return false; }));
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
	auto faces = [](const Vec<dim>& m) {
		return [m](const Vec<dim>& n, double least) { return m.dot(n) < -least; };
	};
	CHECK(!placeOn<dim>(plate, x, faces(outward)));
	const auto overlap = placeOn<dim>(plate, x, faces(-Vec<dim>::Unit(0)));
	REQUIRE(overlap); // an outline that faces the right side has passed through
	CHECK(std::abs(overlap->gap + 0.3) < 1e-12);
	x[dim - 1] = -0.4; // deeper than wide
	REQUIRE(placeOn<dim>(plate, x, faces(outward)));
}

TEMPLATE_TEST_CASE_SIG("what has come through a block touches the side that it faces", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	BlockSurface<dim> block; // upright, thin, its upper edge at height 0
	const double half = GENERATE(0., 1e-9, 0.01);
	block.halfSides[0] = half;
	block.centre[dim - 1] = -1;
	const Vec<dim> right = Vec<dim>::Unit(0), up = Vec<dim>::Unit(dim - 1);
	auto faces = [](const Vec<dim>& outward) {
		return [outward](const Vec<dim>& n, double least) {
			return outward.dot(n) < -least;
		};
	};
	const Vec<dim> x = -(half + 0.05) * right - 0.2 * up;
	const auto place = placeOn<dim>(block, x, faces(-right));
	REQUIRE(place);
	CHECK(place->isBehind);
	CHECK((place->normal - right).norm() < 1e-15);
	CHECK(std::abs(place->gap + 2 * half + 0.05) < 1e-15);
	const auto before = placeOn<dim>(block, x, faces(right));
	REQUIRE(before);
	CHECK(!before->isBehind);
	CHECK(std::abs(before->gap - 0.05) < 1e-15);
	// where the upper edge pokes into the outline, it has no side
	const Vec<dim> beneath = -(half + 0.05) * right - 0.01 * up;
	CHECK(!placeOn<dim>(block, beneath, faces((-right - up).normalized())));
	// an outline that lies upon either side lies along it at a corner
	const Tip<dim> corner { { block.centre + block.halfSides, 0 }, 0 };
	CHECK(liesAlongSide<dim>(block, corner, -right, 0.1, 0.1));
	CHECK(liesAlongSide<dim>(block, corner, right, 0.1, 0.1) == (half < 1e-8));
	// one that stands on its narrow upper side does so where nodes are nearer than that is wide
	CHECK(!liesAlongSide<dim>(block, corner, -up, 0.1, 0.1));
	CHECK(liesAlongSide<dim>(block, corner, -up, 0.1, 0.001) == (half > 1e-3));
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

TEMPLATE_TEST_CASE_SIG("a ball leans on the outline where it is nearest", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	const auto reference = makeGrainTemplate<dim>(recipe(0.2));
	const Vec<dim> centre = Vec<dim>::Constant(0.01);
	const ContactBody<dim> body = contactBody<dim>(*reference, 0.01, centre);
	Random random(2);
	const double exactness = (dim == 2 ? 3e-3 : 0.06) * body.pointSpacing;
	for (const double radius : { 0.0005, 0.01, 0.2 })
		for (int k = 0; k < 50; ++k) {
			const double gap = random.uniform(-0.2, 0.2) * body.pointSpacing;
			const Vec<dim> away = random.direction<dim>();
			const Vec<dim> place = centre + (0.01 + radius + gap) * away;
			const auto contact =
				ballOnOutline<dim>(place, radius, body, body.pointSpacing);
			REQUIRE(contact);
			CHECK(std::abs(contact->gap - gap) < exactness);
			CHECK(contact->normal.dot(away) > 0.99);
			double sum = 0;
			for (int i = 0; i < contact->partners; ++i)
				sum += contact->weight[i];
			CHECK(std::abs(sum - 1) < 1e-12);
		}
	CHECK(!ballOnOutline<dim>(centre + Vec<dim>::Unit(0) * 0.025, 0.01, body, 0.001));
}

TEST_CASE("nodes near a ball and the ball itself are contacts", "[rigid]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.2));
	const ContactBody<2> body = contactBody<2>(*reference, 0.01, { 0, 0 });
	// much smaller than a facet, in its middle: no node is within reach
	const auto& facet = body.mesh->facet[3];
	const Vec<2> middle = 0.5 * (body.position[facet[0]] + body.position[facet[1]]);
	auto list = listWith<2>(BallSurface<2> { middle.normalized() * 0.0103, 0.0003 });
	findContacts<2>(body, 1e-5, list);
	REQUIRE(list.contacts.size() == 1);
	CHECK(list.contacts[0].key.side == 1);
	CHECK(std::abs(list.contacts[0].gap) < 2e-6);
	// a large one
	list = listWith<2>(BallSurface<2> { { 0, 0.0199 }, 0.01 });
	findContacts<2>(body, 1e-3, list);
	CHECK(std::is_sorted(list.contacts.begin(), list.contacts.end(),
			     [](const auto& a, const auto& b) { return a.key < b.key; }));
	CHECK(std::count_if(list.contacts.begin(), list.contacts.end(),
			    [](const auto& c) { return c.key.side == 1; }) == 1);
	CHECK(list.contacts.size() > 3);
	CHECK(list.deepest > 0);
	// one in the other
	for (const double radius : { 0.001, 0.05 }) {
		list = listWith<2>(BallSurface<2> { { 0.001, 0 }, radius });
		findContacts<2>(body, 1e-3, list);
		CHECK(list.deepest > 1);
	}
}

TEMPLATE_TEST_CASE_SIG("what touches a grain pressed flat is not inside it", "[contact][rigid]",
		       ((int dim), dim), 2, 3)
{
	// semi-axes 1.6 and 0.3, aslant: the box is wide, its centre near to whatever touches
	Mat<dim> turn = Mat<dim>::Identity(), stretch = Mat<dim>::Identity();
	turn.template topLeftCorner<2, 2>() = Eigen::Rotation2Dd(0.25 * M_PI).toRotationMatrix();
	stretch(0, 0) = 1.6;
	stretch(1, 1) = 0.3;
	const auto reference = makeGrainTemplate<dim>(recipe(0.2));
	const ContactBody<dim> flat =
		contactBody<dim>(*reference, 1, Vec<dim>::Zero(), turn * stretch);
	for (const double radius : { 0.1, 0.3 })
		for (const double along : { 0., 0.5 }) {
			const bool inside = along > 0 && radius < 0.2;
			const Vec<dim> centre = inside ? Vec<dim>(along * turn.col(0))
						       : Vec<dim>((0.3 + radius) * turn.col(1) +
								  along * turn.col(0));
			auto ball = listWith<dim>(BallSurface<dim> { centre, radius });
			findContacts<dim>(flat, 0.01, ball);
			auto pair = pairList<dim>();
			const auto grain = contactBody<dim>(*reference, radius, centre);
			findContacts<dim>(flat, grain, 0.01, pair);
			auto back = pairList<dim>();
			findContacts<dim>(grain, flat, 0.01, back);
			for (const auto& list : { ball, pair, back })
				CHECK(std::isinf(list.deepest) == inside);
		}
}

TEST_CASE("a grain on a seam of two plates touches it as one", "[rigid]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.1));
	const ContactBody<2> body = contactBody<2>(*reference, 0.01, { 0, 0.00995 });
	std::vector<double> gaps;
	for (const double x : { -0.02, 0. }) {
		auto list = listWith<2>(PlateSurface<2> { { Vec<2>(x, 0), Vec<2>(x + 0.02, 0) } });
		findContacts<2>(body, 5e-5, list);
		for (const Contact<2>& c : list.contacts) {
			if (c.key.side == 1) continue;
			CHECK((c.normal - Vec<2>(0, 1)).norm() < 1e-12);
			CHECK(std::abs(c.gap - body.position[c.key.node][1]) < 1e-15);
			gaps.push_back(c.gap);
		}
	}
	const auto below = std::count_if(body.position.begin(), body.position.end(),
					 [](const Vec<2>& x) { return x[1] < 5e-5; });
	CHECK(static_cast<int>(gaps.size()) >= below);
	CHECK(static_cast<int>(gaps.size()) <= below + 1); // the lowest node may be on both
}

TEST_CASE("an edge at which another surface goes on is none", "[rigid]")
{
	TemplateRecipe square = recipe(0.2);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	// its lower right corner is level with a plate that begins a little further on
	const double R = 0.01, dr = 0.2 * R, edge = R + 0.05 * dr;
	const ContactBody<2> body = contactBody<2>(*reference, R, { 0, R + 1e-6 });
	auto headOn = [&](const std::vector<RigidSurface<2>>& others) {
		auto list = listWith<2>(PlateSurface<2> { { Vec<2>(edge, 0), Vec<2>(0.05, 0) } });
		list.rigid->others = [&] { return others; };
		findContacts<2>(body, 0.2 * dr, list);
		return std::count_if(list.contacts.begin(), list.contacts.end(),
				     [](const auto& c) { return c.normal[0] < -0.9; });
	};
	auto plate = [&](double x, double y, double height = 0) {
		return PlateSurface<2> { { Vec<2>(x, y), Vec<2>(edge, height) } };
	};
	auto box = [&](double top) {
		return BlockSurface<2> { { 0, top - R }, Mat<2>::Identity(), { edge, R } };
	};
	CHECK(headOn({}) == 1);
	CHECK(headOn({ plate(-0.05, 0) }) == 0);
	CHECK(headOn({ plate(edge - 0.01, -0.005) }) == 0); // the top of a slope
	CHECK(headOn({ plate(edge - 0.01, 0.005) }) == 0);  // the foot of one
	CHECK(headOn({ box(0) }) == 0);
	CHECK(headOn({ plate(-0.05, -0.01 * dr, -0.01 * dr) }) == 0);
	CHECK(headOn({ plate(-0.05, -0.5 * dr, -0.5 * dr), box(-0.5 * dr) }) == 1); // a step
	CHECK(headOn({ plate(edge, -0.05) }) == 1);                                 // its face
	CHECK(headOn({ PlateSurface<2> { { Vec<2>(0.03, 0), Vec<2>(0.04, 0.01) } } }) == 1);
}

TEST_CASE("a corner beneath the seam of two boxes is borne by their upper sides", "[rigid]")
{
	TemplateRecipe square = recipe(0.2);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double R = 0.01, dr = 0.2 * R;
	for (const double depth : { 0.01 * dr, 0.2 * dr })
		for (const double aside : { -0.5 * depth, 0.5 * depth }) {
			const ContactBody<2> body = contactBody<2>(*reference, R, { 0, R - depth });
			const double seam = R + aside; // near the lower right corner
			const BlockSurface<2> left { { seam - 3 * R, -R },
						     Mat<2>::Identity(),
						     { 3 * R, R } },
				right { { seam + 3 * R, -R }, Mat<2>::Identity(), { 3 * R, R } };
			int bearing = 0;
			for (const auto& [own, other] :
			     { std::pair(left, right), { right, left } }) {
				auto list = listWith<2>(own);
				const std::vector<RigidSurface<2>> others { other };
				list.rigid->others = [&] { return others; };
				findContacts<2>(body, 0.1 * dr, list);
				for (const auto& c : list.contacts) {
					CAPTURE(depth, aside, c.key.side, c.normal[0], c.normal[1]);
					CHECK(std::abs(c.normal[0]) < 1e-12);
					const bool atCorner =
						c.key.side == 0 &&
						body.position[c.key.node][0] > 0.99 * R;
					bearing += atCorner && std::abs(c.gap + depth) < 1e-9;
				}
			}
			CHECK(bearing == 1);
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
