#include "contact/ContactList.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;

TEMPLATE_TEST_CASE_SIG("Contact list: a support lies still only if nothing of it moves",
		       "[contact]", ((int dim), dim), 2, 3)
{
	ContactList<dim> onGrain;
	onGrain.second = 0;
	CHECK_FALSE(onGrain.hasStillSupport());

	ContactList<dim> onPlane;
	CHECK(onPlane.hasStillSupport());
	onPlane.plane.velocity[0] = 1e-9;
	CHECK_FALSE(onPlane.hasStillSupport());

	auto restsOn = [](const RigidSide<dim>& side, const Vec<dim>& ofImage = Vec<dim>::Zero()) {
		ContactList<dim> list;
		list.rigid.emplace() = side;
		list.image.velocity = ofImage;
		return list.hasStillSupport();
	};
	RigidSide<dim> fast, turning, moving, driven;
	fast.velocities.middle[0] = 1e-9;
	turning.velocities.spread = 1e-9;
	moving.moves = true;
	driven.hasVelocity = true;
	CHECK(restsOn({}));
	CHECK_FALSE(restsOn(fast));
	CHECK_FALSE(restsOn(turning));
	CHECK_FALSE(restsOn(moving));
	CHECK_FALSE(restsOn(driven));
	CHECK_FALSE(restsOn({}, Vec<dim>::Unit(dim - 1)));
}

TEST_CASE("Contact list: an end of a rigid body is bonded at the node it leans on most",
	  "[contact]")
{
	ContactList<2> list;
	for (int node : { 3, 5, 6 }) {
		Contact<2> c;
		c.key = { 0, node, -1 };
		list.contacts.push_back(c);
	}
	Contact<2> end;
	end.key = { 1, 0, -1 };
	end.partners = 4;
	end.partner = { 4, 5, 6, 7 }; // the node 4 is out of reach
	end.weight = { 0.6, 0.1, 0.35, -0.05 };
	list.contacts.push_back(end);
	CHECK(list.placeOfBond(3) == 3U); // of another grain
	list.rigid.emplace();
	CHECK(list.placeOfBond(1) == 1U);
	CHECK(list.placeOfBond(3) == 2U);
	list.contacts[3].partner = { 8, 9, 10, 11 };
	CHECK_FALSE(list.placeOfBond(3));
}
