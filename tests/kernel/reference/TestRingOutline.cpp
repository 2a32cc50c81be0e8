#include "Helpers.hpp"
#include "contact/search/Search.hpp"
#include "reference/Quadrature.hpp"
#include "reference/RingOutline.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// An angle iron with arms of width 2 and length 6, about its centroid; the largest circle inside
/// lies in the corner.
Ring angleIron()
{
	Ring ring;
	ring.vertex = { { 0, 0 }, { 6, 0 }, { 6, 2 }, { 2, 2 }, { 2, 6 }, { 0, 6 } };
	const double inradius = 2 * std::sqrt(2) / (1 + std::sqrt(2));
	const Vec<2> centroid = ring.centroid();
	for (Vec<2>& X : ring.vertex)
		X = (X - centroid) / inradius;
	ring.corner = { 0, 1, 2, 3, 4, 5 };
	return ring;
}

TemplateRecipe ironRecipe(double zeta) { return polygonRecipe(zeta, angleIron()); }

/// Five spikes; corner 2 k is a tip, 2 k + 1 a notch.
Ring star()
{
	Ring ring;
	for (int k = 0; k < 10; ++k) {
		const double r = k % 2 ? 1 : 2.2, t = std::numbers::pi * k / 5;
		ring.vertex.emplace_back(r * std::cos(t), r * std::sin(t));
		ring.corner.push_back(k);
	}
	return ring;
}

double momentOfInertia(const Quadrature<2>& q)
{
	double sum = 0;
	for (std::size_t p = 0; p < q.point.size(); ++p)
		sum += q.weight[p] * q.point[p].squaredNorm();
	return sum;
}

} // namespace

TEST_CASE("Ring: cells cut with an indented polygon hold what is inside", "[reference][ring]")
{
	const Ring ring = angleIron();
	const RingOutline outline(ring);
	const double unit = ring.vertex[1][0] - ring.vertex[0][0]; // 6 of the iron's lengths
	CHECK(std::abs(outline.volume() / (20. / 36 * unit * unit) - 1) < 1e-14);
	CHECK(outline.signedDistance((ring.vertex[0] + ring.vertex[3]) / 2) < 0);
	CHECK(outline.signedDistance((ring.vertex[2] + ring.vertex[4]) / 2) > 0);
	// about the inner corner: three quarters of a cell
	const auto inside = outline.cut(ring.vertex[3], Vec<2>(0.2, 0.2));
	REQUIRE(inside);
	CHECK(std::abs(inside->volume - 0.03) < 1e-14);
	CHECK((inside->first / inside->volume - ring.vertex[3] - Vec<2>(-1, -1) / 60).norm() <
	      1e-13);
	// across both arms: two parts
	const Vec<2> between = 0.5 * (ring.vertex[2] + ring.vertex[4]);
	const auto two = outline.cut(between, Vec<2>::Constant(unit));
	CHECK(two->volume > 0);
	CHECK(outline.cut(between, Vec<2>(0.1, 0.1))->volume == 0);
}

TEST_CASE("Ring: moments of the quadrature", "[reference][ring]")
{
	const RingOutline iron(angleIron());
	const double n = 4, a = 1.5;
	const RingOutline round = superdisk(a, 1, n);
	// Dirichlet's integral over a quarter
	auto moment = [&](double p, double q) {
		return 4 * std::pow(a, p) / (n * n) * std::tgamma(p / n) * std::tgamma(q / n) /
		       std::tgamma(1 + (p + q) / n);
	};
	CHECK(std::abs(round.volume() / moment(1, 1) - 1) < 1e-14);
	CHECK(std::abs(round.inradius() - 1) < 1e-8);
	for (double spacing : { 0.05, 0.1, 0.2 }) {
		CAPTURE(spacing);
		for (const RingOutline* outline : { &iron, &round }) {
			const auto q =
				makeQuadrature<2>(QuadratureRule::cutCell, spacing, *outline);
			double area = 0;
			Vec<2> first = Vec<2>::Zero();
			for (std::size_t p = 0; p < q.point.size(); ++p) {
				area += q.weight[p];
				first += q.weight[p] * q.point[p];
			}
			CHECK(std::abs(area / outline->volume() - 1) < 1e-13);
			CHECK(first.norm() < 1e-9 * area);
		}
		// a point loses the moment of its cell about the centre, dr^2/6
		const auto q = makeQuadrature<2>(QuadratureRule::cutCell, spacing, round);
		const double lost = (moment(3, 1) + moment(1, 3) - momentOfInertia(q)) /
				    round.volume() / (spacing * spacing / 6);
		CHECK(lost > 0.5);
		CHECK(lost < 1.01);
	}
}

TEST_CASE("Ring: vertices of a mesh lie on the outline, denser where it turns", "[reference][ring]")
{
	const double spacing = 0.1;
	const auto mesh = superdisk(1, 1, 20).mesh(spacing);
	const int count = static_cast<int>(mesh.vertex.size());
	CHECK(count % 2 != 0);
	CHECK(count % 3 != 0);
	CHECK(!mesh.hasCorners());
	double shortest = 1, longest = 0, jump = 1;
	for (int s = 0; s < count; ++s) {
		const Vec<2> X = mesh.vertex[s], next = mesh.vertex[(s + 1) % count],
			     last = mesh.vertex[(s + count - 1) % count];
		CHECK(std::abs(std::pow(std::abs(X[0]), 20) + std::pow(std::abs(X[1]), 20) - 1) <
		      0.02); // 0.001 in place
		const double edge = (next - X).norm(), before = (X - last).norm();
		shortest = std::min(shortest, edge);
		longest = std::max(longest, edge);
		jump = std::max({ jump, edge / before, before / edge });
	}
	CHECK(longest < 1.1 * spacing);
	CHECK(shortest > 0.4 * spacing);
	CHECK(shortest < 0.8 * spacing);
	CHECK(jump < 1.4);
	const auto iron = RingOutline(angleIron()).mesh(spacing);
	CHECK(std::count(iron.sharp.begin(), iron.sharp.end(), true) == 6);
}

TEST_CASE("Ring: what is no polygon is refused", "[reference][ring]")
{
	auto complaint = [](auto change) {
		Ring ring = angleIron();
		change(ring);
		return complaintOf([&] { ring.validate(); });
	};
	CHECK(complaintOf([] { angleIron().validate(); }).empty());
	CHECK(complaint([](Ring& r) { r.vertex.resize(2); }).find("at least three, not 2") !=
	      std::string::npos);
	CHECK(complaint([](Ring& r) {
		      std::swap(r.vertex[1], r.vertex[4]);
	      }).find("crosses or touches itself") != std::string::npos);
	CHECK(complaint([](Ring& r) {
		      std::reverse(r.vertex.begin(), r.vertex.end());
	      }).find("vertices (area)") == 0);
	CHECK(complaint([](Ring& r) {
		      r.vertex[2] = r.vertex[1];
	      }).find("vertices (length of a side)") == 0);
	CHECK(complaint([](Ring& r) {
		      for (Vec<2>& X : r.vertex)
			      X[0] += 1;
	      }).find("vertices (centroid)") == 0);
	CHECK(complaint([](Ring& r) { r.corner = { 2, 7 }; }).find("corners") == 0);
	CHECK(complaint([](Ring& r) { r.vertex[0][0] = std::nan(""); }).find("vertices") == 0);
}

TEST_CASE("Ring: equal outlines make equal recipes", "[reference][ring]")
{
	const TemplateRecipe a = ironRecipe(0.2), b = ironRecipe(0.2);
	CHECK(!(a < b));
	CHECK(!(b < a));
	TemplateRecipe c = ironRecipe(0.2);
	Ring other = angleIron();
	other.corner.pop_back();
	c.form.ring = std::make_shared<const Ring>(other);
	CHECK((a < c) != (c < a));
}

TEST_CASE("Ring: a small grain in the notch of another touches neither, nor lies inside",
	  "[contact][ring]")
{
	const auto iron = makeGrainTemplate<2>(ironRecipe(0.2)),
		   disk = makeGrainTemplate<2>(recipe(0.2));
	const auto big = contactBody<2>(*iron, 1, { 0, 0 });
	const Ring ring = angleIron();
	const Vec<2> corner = ring.vertex[3];
	auto search = [&](const Vec<2>& centre) {
		const auto small = contactBody<2>(*disk, 0.5, centre);
		auto list = pairList<2>();
		findContacts(big, small, 0.02, list);
		return list;
	};
	// the notch has its corner near the centre of the iron's box
	const auto free = search(corner + Vec<2>(0.6, 0.6));
	CHECK(free.contacts.empty());
	CHECK(free.deepest == 0);
	// against both sides at once
	const auto wedged = search(corner + Vec<2>(0.495, 0.495));
	CHECK(wedged.deepest > 0);
	CHECK(wedged.deepest < 0.1);
	bool left = false, below = false;
	for (const Contact<2>& c : wedged.contacts) {
		if (c.gap > 0) continue;
		CHECK(c.gap > -0.006);
		left = left || std::abs(c.normal[0]) > 0.9;
		below = below || std::abs(c.normal[1]) > 0.9;
	}
	CHECK(left);
	CHECK(below);
	// wholly inside, where no outline is near
	const auto tiny = contactBody<2>(*disk, 0.1, 0.5 * (ring.vertex[0] + corner));
	auto list = pairList<2>();
	findContacts(big, tiny, 0.02, list);
	CHECK(list.deepest == std::numeric_limits<double>::infinity());
	auto same = pairList<2>();
	findContacts(big, big, 0.02, same);
	CHECK(same.deepest == std::numeric_limits<double>::infinity());
}

TEST_CASE("Ring: a tip below the corner of a notch is pushed back to it", "[contact][ring]")
{
	// the tip of one star, on the x axis, in the notch of another, 36 degrees on
	const auto reference = makeGrainTemplate<2>(polygonRecipe(0.25, star()));
	const Vec<2> tip = star().vertex[0], notch = star().vertex[5];
	for (double depth : { 0.01, 0.1 }) {
		CAPTURE(depth);
		const Vec<2> aside(0, 0.3 * depth);
		const auto left = contactBody<2>(*reference, 1, { 0, 0 });
		const auto right =
			contactBody<2>(*reference, 1, tip - notch - Vec<2>(depth, 0) + aside);
		auto list = pairList<2>();
		findContacts(left, right, 0.02, list);
		bool found = false;
		for (const Contact<2>& c : list.contacts) {
			const auto& body = c.key.side == 0 ? left : right;
			if (c.key.side != 0 || (body.position[c.key.node] - tip).norm() > 1e-9)
				continue;
			found = true;
			CHECK(std::abs(c.gap + std::hypot(depth, 0.3 * depth)) < 1e-9);
			CHECK((c.normal - Vec<2>(-1, 0.3).normalized()).norm() < 1e-9);
		}
		CHECK(found);
		CHECK(list.deepest < 1.1 * depth / 0.25);
	}
}

TEST_CASE("Ring: nothing touches through a thin tip", "[contact][ring]")
{
	// the tip of a star and that of its mirror image past each other, flank to flank, where
	// they are thinner than the depth down to which nodes are in contact
	Ring mirrored = star();
	for (Vec<2>& X : mirrored.vertex)
		X = -X;
	const auto one = makeGrainTemplate<2>(polygonRecipe(0.25, star())),
		   image = makeGrainTemplate<2>(polygonRecipe(0.25, mirrored));
	const Vec<2> tip = star().vertex[0], flank = star().vertex[1] - tip;
	const Vec<2> outwards = Vec<2>(flank[1], -flank[0]).normalized();
	for (double gap : { 0.01, 0.05 }) {
		CAPTURE(gap);
		const auto below = contactBody<2>(*one, 1, { 0, 0 });
		const auto above =
			contactBody<2>(*image, 1, 2 * tip + 0.3 * flank + gap * outwards);
		auto list = pairList<2>();
		findContacts(below, above, 0.1, list);
		CHECK(list.contacts.size() > 2);
		for (const Contact<2>& c : list.contacts)
			CHECK(c.gap > 0.99 * gap);
		CHECK(list.deepest == 0);
	}
}
