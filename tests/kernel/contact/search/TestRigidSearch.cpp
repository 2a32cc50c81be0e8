#include "contact/search/BallOnOutline.hpp"
#include "contact/search/RigidLists.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <limits>
#include <numeric>
#include <vector>

using namespace softgrain;
using namespace softgrain::testing;

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

namespace {

/// A disk of radius 1 into which a plate along the negative x axis, of edge at 0, has cut: its
/// nodes at x < 0 next to the plate lie on it, on both sides, and one where the slit ends.
ContactBody<2> slitDisk(const GrainTemplate<2>& reference, double end)
{
	ContactBody<2> body = contactBody<2>(reference, 1, Vec<2>::Zero());
	const int count = body.nodes();
	const auto byX = [&](int a, int b) { return body.position[a][0] < body.position[b][0]; };
	std::vector<int> order(count);
	std::iota(order.begin(), order.end(), 0);
	const int middle = *std::min_element(order.begin(), order.end(), byX);
	auto node = [&](int k) -> Vec<2>& { return body.position[(middle + k + count) % count]; };
	node(0) = { end, 0 };
	for (const int side : { -1, 1 })
		for (int k = 1; k <= 3; ++k)
			node(side * k) = { end - 0.3 * k, side * -1e-3 };
	body.updateGeometry();
	return body;
}

} // namespace

TEST_CASE("the edge of a plate in a slit leaves it where the slit ends", "[rigid]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.25));
	for (const double end : { 0.05, 0.2, -0.05 }) {
		const ContactBody<2> body = slitDisk(*reference, end);
		const auto contact = ballOnOutline<2>({ 0, 0 }, 0, body, 1);
		CAPTURE(end);
		REQUIRE(body.encloses({ 0, 0 }) == (end < 0));
		REQUIRE(contact);
		if (end < 0) {
			CHECK((contact->normal - Vec<2>(-1, 0)).norm() < 1e-6);
			CHECK(std::abs(contact->gap - end) < 1e-6);
		} else
			CHECK(contact->gap > -1e-2);
	}
}

TEST_CASE("the way from a node is inside unless it leads through the outline", "[contact]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.25));
	const ContactBody<2> body = slitDisk(*reference, 0);
	const auto top =
		std::max_element(body.position.begin(), body.position.end(),
				 [](const Vec<2>& a, const Vec<2>& b) { return a[1] < b[1]; });
	const int node = static_cast<int>(top - body.position.begin());
	const Vec<2> across(-0.45, -0.2), beside(0.4, -0.2), before(-0.45, 0.2);
	REQUIRE(body.encloses(across));
	CHECK(!body.encloses(node, across));
	CHECK(body.encloses(node, beside));
	CHECK(body.encloses(node, before));
	CHECK(!body.encloses(node, { 0.4, 2 }));
}

TEST_CASE("the way from a node is inside unless it leads through the outline, in 3D", "[contact]")
{
	const auto reference = makeGrainTemplate<3>(recipe(0.3));
	ContactBody<3> body = contactBody<3>(*reference, 1, Vec<3>::Zero());
	for (Vec<3>& x : body.position) // an hourglass about the z axis
		x.head<2>() *= 0.2 + x[2] * x[2];
	body.updateGeometry();
	const auto top = std::max_element(
		body.position.begin(), body.position.end(),
		[](const Vec<3>& a, const Vec<3>& b) { return a[2] - a[0] < b[2] - b[0]; });
	const int node = static_cast<int>(top - body.position.begin());
	const Vec<3> sameSide = body.position[node].cwiseProduct(Vec<3>(0.8, 0.8, -0.9));
	REQUIRE(body.encloses(sameSide));
	CHECK(!body.encloses(node, sameSide));
	CHECK(body.encloses(node, Vec<3>(0, 0, 0.3)));
}
