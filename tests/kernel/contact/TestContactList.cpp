#include "contact/Contact.hpp"

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
	RigidSide<dim> fast, moving, driven;
	fast.speed = 1e-9;
	moving.moves = true;
	driven.hasVelocity = true;
	CHECK(restsOn({}));
	CHECK_FALSE(restsOn(fast));
	CHECK_FALSE(restsOn(moving));
	CHECK_FALSE(restsOn(driven));
	CHECK_FALSE(restsOn({}, Vec<dim>::Unit(dim - 1)));
}
