// Ends of floors of plates and blocks: what hangs over them, and what is beside them.
#include "contact/search/RigidLists.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <vector>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double R = 0.01, L = 8 * R;

/// Level, at height 0, from one place to another.
RigidSurface<2> box(double from, double to)
{
	return BlockSurface<2> { { 0.5 * (from + to), -R },
				 Mat<2>::Identity(),
				 { 0.5 * (to - from), R } };
}
RigidSurface<2> plate(double from, double to)
{
	return PlateSurface<2> { { Vec<2>(from, 0), Vec<2>(to, 0) } };
}

/// Equilateral, a side at the bottom; the circle inside has radius 1.
TemplateRecipe triangleRecipe(double zeta)
{
	Ring ring { { { -std::sqrt(3), -1 }, { std::sqrt(3), -1 }, { 0, 2 } }, { 0, 1, 2 } };
	return polygonRecipe(zeta, ring);
}

template <int dim> std::vector<Contact<dim>> tipsAmong(std::vector<Contact<dim>> contacts)
{
	std::erase_if(contacts, [](const Contact<dim>& c) { return c.key.side == 0; });
	return contacts;
}

} // namespace

TEST_CASE("the end of a floor holds what hangs over it between two nodes", "[rigid]")
{
	const auto reference = makeGrainTemplate<2>(recipe(GENERATE(0.1, 0.25)));
	const double dr = reference->pointSpacing() * R;
	const auto floor = GENERATE(0, 1) ? box : plate;
	for (double past = -0.9; past < 0.95; past += 0.1) // of the centre, in dr
		for (const double depth : { 0.001, 0.05, 0.3 }) {
			const double rest = std::sqrt(R * R - std::pow(past * dr, 2));
			const Vec<2> centre(past * dr, rest - depth * dr);
			const ContactBody<2> body = contactBody<2>(*reference, R, centre);
			auto tips = [&](const std::vector<RigidSurface<2>>& surfaces) {
				return tipsAmong<2>(contactsWith<2>(surfaces, body, 0.01 * dr));
			};
			CAPTURE(dr, past, depth);
			const auto end = tips({ floor(-L, 0) });
			REQUIRE(end.size() == 1);
			CHECK(std::abs(end[0].gap - centre.norm() + R) < 1e-3 * dr);
			CHECK((end[0].normal + centre.normalized()).norm() < 2e-3);
			CHECK(tips({ floor(-L, 0), floor(0, L) }).empty());
			CHECK(tips({ floor(-L, 0), floor(0.02 * dr, L) }).empty());
		}
}

TEST_CASE("the end of a floor holds a ball that hangs over it", "[rigid]")
{
	const auto reference = makeGrainTemplate<3>(recipe(0.3));
	const double dr = reference->pointSpacing() * R;
	const std::array<Vec<3>, 4> corner { Vec<3>(-L, 0, -L), Vec<3>(0, 0, -L), Vec<3>(0, 0, L),
					     Vec<3>(-L, 0, L) };
	const std::vector<RigidSurface<3>> plates {
		PlateSurface<3> { { corner[0], corner[1], corner[2] } },
		PlateSurface<3> { { corner[0], corner[2], corner[3] } }
	};
	const std::vector<RigidSurface<3>> boxes { BlockSurface<3> {
		{ -0.5 * L, -R, 0 }, Mat<3>::Identity(), { 0.5 * L, R, L } } };
	const auto floor = GENERATE(0, 1) ? boxes : plates;
	for (double past = -0.6; past < 0.65; past += 0.2)
		for (const double along : { 0., 0.13, 0.31 }) {
			const Vec<3> centre(past * dr, R - 0.1 * dr, along * dr);
			const ContactBody<3> body = contactBody<3>(*reference, R, centre);
			const auto contacts = contactsWith<3>(floor, body, 0.01 * dr);
			const auto tips = tipsAmong<3>(contacts);
			CAPTURE(past, along, contacts.size());
			CHECK(!tips.empty());
			for (const Contact<3>& c : tips)
				CHECK(c.normal[1] < -0.9);
		}
}

TEST_CASE("a corner of a grain flush with that of a box is not held from beside", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double dr = 0.25 * R;
	for (const double past : { -1e-3, -1e-9, 0., 1e-9, 1e-3, 0.02 })
		for (const double depth : { 0., 1e-9, 1e-3 }) {
			CAPTURE(past, depth);
			const Vec<2> centre(past * dr - R, R - depth * dr);
			const ContactBody<2> body = contactBody<2>(*reference, R, centre);
			for (const Contact<2>& c : contactsWith<2>({ box(-L, 0) }, body, 0.1 * dr))
				CHECK(std::abs(c.normal[0]) < 0.5);
		}
}

TEST_CASE("a corner on a stair of plates is not held by what is beneath", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double dr = 0.25 * R, lean = GENERATE(0.3, 0.7, 1.2);
	const Mat<2> turn = Eigen::Rotation2Dd(lean).toRotationMatrix();
	const Vec<2> fromCorner = turn * Vec<2>(R, R);
	const Vec<2> end(0, 0), foot(0, -R);
	const std::array<RigidSurface<2>, 2> risers { PlateSurface<2> { { end, foot } },
						      PlateSurface<2> { { foot, end } } };
	for (const RigidSurface<2>& riser : risers)
		for (const double before : { 1e-9, 0.01, 0.1, 0.3 }) // the end of the tread, in dr
			for (const double depth : { -1e-9, 0., 1e-9, 1e-3, 0.04 }) {
				CAPTURE(lean, before, depth);
				const Vec<2> corner(-before * dr, -depth * dr);
				const ContactBody<2> body =
					contactBody<2>(*reference, R, corner + fromCorner, turn);
				for (const Contact<2>& c :
				     contactsWith<2>({ plate(-L, 0), riser }, body, 0.4 * dr))
					if (c.key.side == 0) CHECK(c.normal[0] > -0.5);
			}
}

TEST_CASE("a corner between a floor of plates and one upright on it stays before both", "[rigid]")
{
	TemplateRecipe square = recipe(0.25);
	square.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(square);
	const double dr = 0.25 * R, side = GENERATE(-1., 1.);
	const RigidSurface<2> upright = PlateSurface<2> { { Vec<2>(0, 0), Vec<2>(0, R) } };
	for (const double past : { 0., 1e-9, 1e-3, 0.02 }) // the upright, in dr
		for (const double depth : { -0.05, -1e-3, 0., 1e-9, 1e-3, 0.02 }) {
			CAPTURE(side, past, depth);
			const Vec<2> centre(side * (past * dr - R), R - depth * dr);
			const ContactBody<2> body = contactBody<2>(*reference, R, centre);
			const auto contacts = contactsWith<2>(
				{ plate(-L, 0), plate(0, L), upright }, body, 0.1 * dr);
			auto heldAtCorner = [&](const Vec<2>& normal) {
				const Vec<2> corner = centre + Vec<2>(side * R, -R);
				auto holds = [&](const Contact<2>& c) {
					return c.key.side == 0 && c.normal.dot(normal) > 0.9 &&
					       (body.position[c.key.node] - corner).norm() <
						       0.01 * dr;
				};
				return std::count_if(contacts.begin(), contacts.end(), holds);
			};
			CHECK(heldAtCorner({ 0, 1 }) == 1);
			CHECK(heldAtCorner({ -side, 0 }) == 1);
		}
}

TEST_CASE("what tips over the end of a plate has not come through it", "[rigid]")
{
	TemplateRecipe cube = recipe(0.3);
	cube.form.form = Form::block;
	const auto reference = makeGrainTemplate<2>(cube);
	for (const double angle : { 0.12, 0.2, 0.3, 0.5 })
		for (const double past : { 0.05, 0.25, 0.5 }) { // of the middle of its base, over R
			CAPTURE(angle, past);
			const Mat<2> turn = Eigen::Rotation2Dd(-angle).toRotationMatrix();
			const Vec<2> centre = turn * Vec<2>(past * R, R); // its base on the edge
			const ContactBody<2> body = contactBody<2>(*reference, R, centre, turn);
			for (const Contact<2>& c :
			     contactsWith<2>({ plate(-L, 0) }, body, 0.01 * R))
				CHECK(c.gap > -1e-9 * R);
		}
}

TEST_CASE("a corner that hangs over a ridge has not come through its far side", "[rigid]")
{
	const double zeta = GENERATE(0.2, 0.3);
	const auto reference = makeGrainTemplate<2>(triangleRecipe(zeta));
	const double dr = zeta * R, slope = GENERATE(0.3, 0.5);
	const std::vector<RigidSurface<2>> ridge {
		PlateSurface<2> { { Vec<2>(-L, -slope * L), Vec<2>(0, 0) } },
		PlateSurface<2> { { Vec<2>(0, 0), Vec<2>(L, -slope * L) } }
	};
	for (const double lean : { 0., 0.1, 0.2, 0.28 })
		for (const double past : { 0.3, 0.6, 0.9, 1.2, 1.8 }) { // of the corner, in dr
			CAPTURE(zeta, slope, lean, past);
			const Mat<2> turn = Eigen::Rotation2Dd(-lean).toRotationMatrix();
			const Vec<2> corner = turn * Vec<2>(-past * dr, 0); // its side on the ridge
			const Vec<2> centre = corner + turn * Vec<2>(std::sqrt(3) * R, R);
			const ContactBody<2> body = contactBody<2>(*reference, R, centre, turn);
			for (const Contact<2>& c : contactsWith<2>(ridge, body, 0.01 * dr))
				CHECK(c.gap > -1e-9 * R);
		}
}

TEST_CASE("what is above a slot is not behind its upright sides", "[rigid]")
{
	const double half = GENERATE(0.15, 0.2, 0.25) * R; // of its width
	const auto reference = makeGrainTemplate<2>(recipe(GENERATE(0.1, 0.25)));
	const double dr = reference->pointSpacing() * R, rest = std::sqrt(R * R - half * half);
	std::vector<RigidSurface<2>> lips;
	for (const double side : { -1., 1. }) {
		const Vec<2> edge(side * half, 0);
		lips.push_back(PlateSurface<2> { { edge, edge + side * Vec<2>(8 * R, 0) } });
		lips.push_back(PlateSurface<2> { { edge - Vec<2>(0, 2 * R), edge } });
	}
	for (double x = -0.1; x <= 0.1; x += 0.01)
		for (const double depth : { -0.01, 0., 0.05 }) {
			CAPTURE(half, dr, x, depth);
			const Vec<2> centre(x * dr, rest - depth * dr);
			const ContactBody<2> body = contactBody<2>(*reference, R, centre);
			for (const Contact<2>& c : contactsWith<2>(lips, body, 0.1 * dr))
				CHECK(c.gap > -(depth + 0.15) * dr);
		}
}
