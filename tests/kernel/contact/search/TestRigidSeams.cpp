// Floors of several plates and blocks, their seams, and inside corners.
#include "contact/search/RigidLists.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

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
	auto box = [](double x, double y, double a, double b) {
		return BlockSurface<2> { { x, y }, Mat<2>::Identity(), { a, b } };
	};
	const Vec<2> corner(0, 0);
	const Walls plates { PlateSurface<2> { { corner, Vec<2>(L, 0) } },
			     PlateSurface<2> { { Vec<2>(0, L), corner } } };
	const Walls boxes { box(L, -R, L, R), box(-R, 0, R, L) };
	const Walls boxesThatMeetAtTheEdge { box(L, -R, L, R), box(-R, L, R, L) };
	const int kind = GENERATE(0, 1, 2);
	const Walls walls = std::array { plates, boxes, boxesThatMeetAtTheEdge }[kind];
	const double gaps[] { -0.04, -0.001, -1e-15, 0., 1e-15, 0.001, 0.01 };
	for (const double left : gaps)
		for (const double down : gaps) {
			const Vec<2> place = dr * Vec<2>(left, down);
			const ContactBody<2> body =
				contactBody<2>(*reference, R, Vec<2>::Constant(R) + place);
			int onLeft = 0, onFloor = 0; // of the corner
			for (const Contact<2>& c : contactsWith<2>(walls, body, 0.1 * dr)) {
				const Vec<2>& x = body.position[c.key.node];
				if (c.key.side == 1 || (x - place).norm() > 0.1 * dr) continue;
				onLeft += c.normal[0] > 0.99 && std::abs(c.gap - x[0]) < 1e-12;
				onFloor += c.normal[1] > 0.99 && std::abs(c.gap - x[1]) < 1e-12;
			}
			CAPTURE(kind, left, down);
			CHECK(onLeft == 1);
			CHECK(onFloor == 1);
		}
}

TEST_CASE("a step of a block that goes on below the floor holds a corner", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double R = 0.01, dr = 0.25 * R;
	for (const double height : { 0.1, 0.5, 0.9, 1.2, 1.7, 3. }) {
		const double low = -2 * R, top = height * dr;
		const BlockSurface<2> step { { 2 * R, 0.5 * (low + top) },
					     Mat<2>::Identity(),
					     { R, 0.5 * (top - low) } };
		const BlockSurface<2> boxes { { -R, -R }, Mat<2>::Identity(), { 2 * R, R } };
		const PlateSurface<2> plate { { Vec<2>(-3 * R, 0), Vec<2>(R, 0) } };
		for (const RigidSurface<2>& floor :
		     { RigidSurface<2>(boxes), RigidSurface<2>(plate) })
			for (const double gap : { -1e-3, -1e-9, 0., 1e-9, 1e-3 }) {
				CAPTURE(height, floor.index(), gap);
				const ContactBody<2> body =
					contactBody<2>(*reference, R, { -gap * dr, R + gap * dr });
				int onStep = 0;
				for (const auto& c :
				     contactsWith<2>({ floor, step }, body, 0.1 * dr)) {
					CHECK(c.gap > -0.01 * dr);
					onStep += c.key.side == 0 && c.normal[0] < -0.99;
				}
				CHECK(onStep >= 1);
			}
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
