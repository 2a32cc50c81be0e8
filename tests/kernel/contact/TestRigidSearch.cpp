#include "contact/OutlineSearch.hpp"
#include "contact/RigidLists.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <limits>

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
