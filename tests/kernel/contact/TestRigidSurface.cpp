#include "Helpers.hpp"
#include "contact/OutlineSearch.hpp"
#include "contact/Search.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <limits>
#include <set>

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

/// Contacts with surfaces beside each other, of which the former come first.
template <int dim>
std::vector<Contact<dim>> contactsWith(const std::vector<RigidSurface<dim>>& surfaces,
				       const ContactBody<dim>& body, double reach)
{
	std::vector<Contact<dim>> all;
	for (std::size_t k = 0; k < surfaces.size(); ++k) {
		auto list = listWith<dim>(surfaces[k]);
		list.rigid->others = [&] {
			std::vector<SurfaceBeside<dim>> others;
			for (std::size_t j = 0; j < surfaces.size(); ++j)
				if (j != k) others.push_back({ surfaces[j], j < k });
			return others;
		};
		findContacts<dim>(body, reach, list);
		CHECK(list.deepest < 0.5); // in dr
		all.insert(all.end(), list.contacts.begin(), list.contacts.end());
	}
	return all;
}

/// How many contact nodes have a contact; that none has two is checked.
template <int dim> int nodesOnce(const std::vector<Contact<dim>>& contacts)
{
	std::set<int> nodes;
	int count = 0;
	for (const Contact<dim>& c : contacts) {
		if (c.key.side == 1) continue;
		nodes.insert(c.key.node);
		++count;
	}
	CHECK(static_cast<int>(nodes.size()) == count);
	return count;
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
	CHECK(static_cast<int>(gaps.size()) <= below + 1); // alone, both bear the lowest node
}

TEST_CASE("a node above a seam touches what comes first", "[rigid]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.1));
	const double R = 0.01, dr = 0.1 * R;
	for (const double gap : { -0.02, 0., 1e-4, 0.3 })
		for (const double aside : { 0., 1e-16, 1e-13, 1e-9, 1e-6, 1e-4, 1e-2, -1e-12 }) {
			CAPTURE(gap, aside);
			const ContactBody<2> body =
				contactBody<2>(*reference, R, { aside * dr, R + gap * dr });
			const double reach = 0.5 * dr;
			using Floor = std::vector<RigidSurface<2>>;
			const Vec<2> left(-2 * R, 0), right(2 * R, 0), seam(0, 0);
			auto box = [&](double x, double width) {
				return BlockSurface<2> { { x, -R },
							 Mat<2>::Identity(),
							 { width, R } };
			};
			const auto whole = contactsWith<2>({ PlateSurface<2> { { left, right } } },
							   body, reach);
			const int nodes = nodesOnce(whole);
			CHECK(nodes > 1);
			for (const Floor& floor :
			     { Floor { PlateSurface<2> { { left, seam } },
				       PlateSurface<2> { { seam, right } } },
			       Floor { PlateSurface<2> { { right, seam } },
				       PlateSurface<2> { { left, seam } } },
			       Floor { box(-R, R), box(R, R) }, Floor { box(R, R), box(-R, R) },
			       Floor { box(-R, R), PlateSurface<2> { { seam, right } } } })
				CHECK(nodesOnce(contactsWith<2>(floor, body, reach)) == nodes);
		}
}

TEST_CASE("in space a node above the seams of many surfaces counts once", "[rigid]")
{
	const double R = 0.01;
	// right beneath the lowest node of a fine grain, and beside that of a coarse one
	const bool isCoarse = GENERATE(false, true);
	const auto reference = makeGrainTemplate<3>(recipe(isCoarse ? 0.5 : 0.2));
	ContactBody<3> body = contactBody<3>(*reference, R, { 0, 0, 0 });
	const auto lowest =
		std::min_element(body.position.begin(), body.position.end(),
				 [](const Vec<3>& a, const Vec<3>& b) { return a[2] < b[2]; });
	const Vec<3> corner =
		isCoarse ? Vec<3>(1e-3 * R, 2e-3 * R, (*lowest)[2] - 1e-3 * R) : *lowest;
	const double r = 4 * R;
	const std::array<Vec<3>, 4> round { Vec<3>(r, 0, 0), Vec<3>(0, r, 0), Vec<3>(-r, 0, 0),
					    Vec<3>(0, -r, 0) };
	std::vector<RigidSurface<3>> plates, blocks;
	for (int k = 0; k < 4; ++k) {
		const Vec<3> a = corner + round[k], b = corner + round[(k + 1) % 4];
		plates.push_back(PlateSurface<3> { { corner, a, b } });
		BlockSurface<3> block;
		block.centre = corner + 0.5 * (round[k] + round[(k + 1) % 4]) - Vec<3>(0, 0, r / 2);
		block.halfSides = Vec<3>::Constant(r / 2);
		blocks.push_back(block);
	}
	BlockSurface<3> whole;
	whole.centre = corner - Vec<3>(0, 0, r);
	whole.halfSides = Vec<3>::Constant(r);
	const double reach = 0.3 * body.pointSpacing;
	const int nodes = nodesOnce(contactsWith<3>({ whole }, body, reach));
	CHECK(nodes > 0);
	for (const auto& floor : { plates, blocks })
		CHECK(nodesOnce(contactsWith<3>(floor, body, reach)) == nodes);
}

TEST_CASE("blocks flush with boxes and facets of a floor touch each node once", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double R = 0.01, dr = 0.25 * R, L = 6 * R;
	auto box = [&](double from, double to) {
		return BlockSurface<2> { { (from + to) / 2, -R },
					 Mat<2>::Identity(),
					 { (to - from) / 2, R } };
	};
	auto plate = [&](double from, double to) {
		return PlateSurface<2> { { Vec<2>(from, 0), Vec<2>(to, 0) } };
	};
	using Floor = std::vector<RigidSurface<2>>;
	for (const double gap : { -0.01, 0., 0.01 })
		for (const double at : { -R, R, -R / 4 }) {
			const ContactBody<2> body =
				contactBody<2>(*reference, R, { 0, R + gap * dr });
			CAPTURE(gap, at);
			const int nodes =
				nodesOnce(contactsWith<2>({ plate(-L, L) }, body, 0.1 * dr));
			for (const double overlap : { 0., 1e-3 * R, 0.01 * R })
				for (const Floor& floor :
				     { Floor { box(-L, at + overlap), box(at, L) },
				       Floor { box(at, L), box(-L, at + overlap) } })
					CHECK(nodesOnce(contactsWith<2>(floor, body, 0.1 * dr)) ==
					      nodes);
			for (const Floor& floor : { Floor { box(-L, at), plate(at, L) },
						    Floor { plate(-L, at), box(at, L) },
						    Floor { plate(at, L), box(-L, at) } })
				CHECK(nodesOnce(contactsWith<2>(floor, body, 0.1 * dr)) == nodes);
		}
}

TEST_CASE("a cube flush over the crossing of four boxes touches with all nodes", "[rigid]")
{
	TemplateRecipe cube = recipe(0.5);
	cube.form.form = Form::block;
	const auto reference = makeGrainTemplate<3>(cube);
	const double R = 0.01, dr = 0.5 * R, r = 3 * R;
	for (const double gap : { -0.01, 0., 0.01 })
		for (const Vec<3>& at :
		     { Vec<3>(0, 0, 0), Vec<3>(R, 0, 0), Vec<3>(R, R, 0), Vec<3>(-R, R, 0) }) {
			const ContactBody<3> body =
				contactBody<3>(*reference, R, { 0, 0, R + gap * dr });
			std::vector<RigidSurface<3>> boxes;
			for (const double x : { -r, r })
				for (const double y : { -r, r }) {
					BlockSurface<3> box;
					box.centre = at + Vec<3>(x, y, -r);
					box.halfSides = Vec<3>::Constant(r);
					boxes.push_back(box);
				}
			const auto below =
				std::count_if(body.position.begin(), body.position.end(),
					      [&](const Vec<3>& x) { return x[2] < 0.1 * dr; });
			CAPTURE(gap, at[0], at[1]);
			CHECK(nodesOnce(contactsWith<3>(boxes, body, 0.1 * dr)) ==
			      static_cast<int>(below));
		}
}

TEST_CASE("the inside corner of two walls holds a corner on both", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double R = 0.01, dr = 0.25 * R, L = 6 * R;
	using Walls = std::vector<RigidSurface<2>>;
	const Vec<2> corner(0, 0);
	const Walls plates { PlateSurface<2> { { corner, Vec<2>(L, 0) } },
			     PlateSurface<2> { { Vec<2>(0, L), corner } } };
	const Walls boxes { BlockSurface<2> { { L, -R }, Mat<2>::Identity(), { L, R } },
			    BlockSurface<2> { { -R, 0 }, Mat<2>::Identity(), { R, L } } };
	for (const Walls& walls : { plates, boxes })
		for (const double gap : { -0.02, -0.001, 0.01 }) {
			const ContactBody<2> body =
				contactBody<2>(*reference, R, { R + gap * dr, R + gap * dr });
			bool isLeft = false, isDown = false; // of the corner
			for (const Contact<2>& c : contactsWith<2>(walls, body, 0.1 * dr)) {
				if (c.key.side == 1 ||
				    (body.position[c.key.node] - Vec<2>(gap * dr, gap * dr))
						    .norm() > 0.1 * dr)
					continue;
				isLeft = isLeft || c.normal[0] > 0.99;
				isDown = isDown || c.normal[1] > 0.99;
			}
			CAPTURE(gap, std::holds_alternative<BlockSurface<2>>(walls[0]));
			CHECK(isLeft);
			CHECK(isDown);
		}
}

TEST_CASE("a cube fits into the inside corner of two boxes", "[rigid]")
{
	TemplateRecipe cube = recipe(0.5);
	cube.form.form = Form::block;
	const auto reference = makeGrainTemplate<3>(cube);
	const double R = 0.01, dr = 0.5 * R;
	BlockSurface<3> floor, wall;
	floor.centre = { 2 * R, -R, 0 };
	floor.halfSides = { 2 * R, R, 5 * R };
	wall.centre = { -R, R, 0 };
	wall.halfSides = { R, 2 * R, 5 * R };
	for (const double gap : { -0.01, -1e-6, -1e-16, 0., 1e-6, 0.01 }) {
		const ContactBody<3> body =
			contactBody<3>(*reference, R, { R + gap * dr, R + gap * dr, R });
		CAPTURE(gap);
		int onFloor = 0, onWall = 0, below = 0;
		for (const Contact<3>& c : contactsWith<3>({ floor, wall }, body, 0.1 * dr)) {
			onFloor += c.key.side == 0 && c.normal[1] > 0.99;
			onWall += c.key.side == 0 && c.normal[0] > 0.99;
		}
		for (const Vec<3>& x : body.position)
			below += x[1] < 0.1 * dr;
		CHECK(onFloor == below);
		CHECK(onWall == below);
	}
}

TEST_CASE("the top of a pyramid enters an outline once", "[rigid]")
{
	const double R = 0.01, r = 4 * R;
	const auto reference = makeGrainTemplate<3>(recipe(0.5));
	const ContactBody<3> body = contactBody<3>(*reference, R, { 0, 0, 0 });
	const Vec<3> top(0.22 * R, 0.13 * R, -0.93 * R);
	const std::array<Vec<3>, 4> round { Vec<3>(r, 0, -r), Vec<3>(0, r, -r), Vec<3>(-r, 0, -r),
					    Vec<3>(0, -r, -r) };
	std::vector<RigidSurface<3>> pyramid;
	auto tips = [&](const std::vector<RigidSurface<3>>& surfaces) {
		const auto contacts = contactsWith<3>(surfaces, body, 0.01 * body.pointSpacing);
		return std::count_if(contacts.begin(), contacts.end(),
				     [](const Contact<3>& c) { return c.key.side == 1; });
	};
	for (int k = 0; k < 4; ++k) {
		pyramid.push_back(
			PlateSurface<3> { { top, top + round[k], top + round[(k + 1) % 4] } });
		CHECK(tips({ pyramid.back() }) == 1);
	}
	CHECK(tips(pyramid) == 1);
}

TEST_CASE("an edge at which another surface goes on is none", "[rigid]")
{
	TemplateRecipe square = recipe(0.2);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	// its lower right corner is level with a plate that begins a little further on
	const double R = 0.01, dr = 0.2 * R, edge = R + 0.05 * dr;
	const ContactBody<2> body = contactBody<2>(*reference, R, { 0, R + 1e-6 });
	auto headOn = [&](const std::vector<RigidSurface<2>>& beside) {
		std::vector<SurfaceBeside<2>> others;
		for (const RigidSurface<2>& surface : beside)
			others.push_back({ surface });
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

TEST_CASE("a corner beneath the seam of two boxes or plates is borne by one of them", "[rigid]")
{
	TemplateRecipe square = recipe(0.2);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double R = 0.01, dr = 0.2 * R;
	for (const double depth : { 0.01 * dr, 0.2 * dr })
		for (const double share : { -0.5, 0., 0.5 }) {
			const ContactBody<2> body = contactBody<2>(*reference, R, { 0, R - depth });
			const double seam = R + share * depth; // near the lower right corner
			auto box = [&](double x) {
				return BlockSurface<2> { { x, -R },
							 Mat<2>::Identity(),
							 { 3 * R, R } };
			};
			auto plate = [&](double from, double to) {
				return PlateSurface<2> { { Vec<2>(from, 0), Vec<2>(to, 0) } };
			};
			using Floor = std::vector<RigidSurface<2>>;
			for (const Floor& floor :
			     { Floor { box(seam - 3 * R), box(seam + 3 * R) },
			       Floor { plate(-3 * R, seam), plate(seam, 3 * R) },
			       Floor { plate(seam, 3 * R), plate(-3 * R, seam) } }) {
				int bearing = 0;
				for (const auto& c : contactsWith<2>(floor, body, 0.1 * dr)) {
					CAPTURE(depth, share, c.key.side, c.normal[0], c.normal[1]);
					CHECK(std::abs(c.normal[0]) < 1e-12);
					const bool atCorner =
						c.key.side == 0 &&
						body.position[c.key.node][0] > 0.99 * R;
					bearing += atCorner && std::abs(c.gap + depth) < 1e-9;
				}
				CHECK(bearing == 1);
			}
		}
}

TEST_CASE("all nodes of a cube stand on a floor of triangles, its corners on the diagonal",
	  "[rigid]")
{
	TemplateRecipe cube = recipe(0.5);
	cube.form.form = Form::block;
	const auto reference = makeGrainTemplate<3>(cube);
	const double R = 0.01, r = 3 * R;
	const Vec<3> a(-r, -r, 0), b(r, -r, 0), c(r, r, 0), d(-r, r, 0);
	for (const double depth : { 0., 1e-4, 0.01, 0.1 })
		for (const double aside : { 0., 1e-9, 1e-4 }) {
			const double dr = 0.5 * R;
			const ContactBody<3> body =
				contactBody<3>(*reference, R, { aside * dr, 0, R - depth * dr });
			const auto below =
				std::count_if(body.position.begin(), body.position.end(),
					      [&](const Vec<3>& x) { return x[2] < 1e-3 * R; });
			const auto contacts = contactsWith<3>({ PlateSurface<3> { { a, b, c } },
								PlateSurface<3> { { a, c, d } } },
							      body, 0.1 * dr);
			CAPTURE(depth, aside);
			CHECK(nodesOnce(contacts) == static_cast<int>(below));
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
