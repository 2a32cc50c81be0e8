#include "contact/HandOn.hpp"

#include <catch2/catch_test_macros.hpp>

using namespace softgrain;

namespace {

InterfaceLaw bondLaw(double strength)
{
	InterfaceLaw law;
	law.bondStrength = strength;
	law.bondEnergy = 1;
	return law;
}

/// A contact node of a grain, bonded to one rigid surface, that came over its seam with the next.
struct Seam {
	static constexpr int node = 1;
	std::vector<ContactBody<2>> bodies = std::vector<ContactBody<2>>(1);
	std::vector<RigidPartner<2>> partners = std::vector<RigidPartner<2>>(2);
	ContactList<2> left, right;

	Seam()
	{
		bodies[0].position = { Vec<2>(0, 0), Vec<2>(1, 0) };
		for (ContactList<2>* list : { &left, &right }) {
			list->first = 0;
			list->rigid.emplace().partner = list == &left ? 0 : 1;
			list->interface.emplace().law = bondLaw(2);
		}
		ContactHistory<2> bonded;
		bonded.bond = Bond::whole;
		bonded.largest = 0.1;
		bonded.isNew = false;
		left.interface->vanished.push_back({ node, Vec<2>(0, 1), bonded });
		Contact<2> contact;
		contact.key = { 0, node, -1 };
		contact.normal = Vec<2>(0, 1);
		right.contacts.push_back(contact);
		right.interface->resize(1);
	}
	Contact<2>& contact() { return right.contacts[0]; }
	ContactHistory<2>& history() { return right.interface->history[0]; }
	/// Whether the bond went on.
	bool holds()
	{
		const long handedOn = handOnHistories<2>({ &left, &right }, bodies, partners);
		CHECK(left.interface->vanished.empty());
		CHECK(handedOn == (history().bond == Bond::whole));
		CHECK(history().largest == (handedOn == 1 ? 0.1 : 0));
		return handedOn == 1;
	}
};

/// The same after a change of the scene.
template <class Change> bool holdsWhere(Change change)
{
	Seam seam;
	change(seam);
	return seam.holds();
}

} // namespace

TEST_CASE("over a seam a contact hands on its history to the same node on the same side",
	  "[interface]")
{
	CHECK(Seam().holds());
	CHECK_FALSE(holdsWhere([](Seam& s) { s.contact().key.node = 0; }));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.contact().key.side = 1; }));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.right.first = 1; }));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.right.rigid.reset(); }));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.right.interface->law = bondLaw(3); }));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.history().isNew = false; }));
	auto inclinedBy = [](double angle) {
		return [angle](Seam& s) {
			s.contact().normal = Vec<2>(std::sin(angle), std::cos(angle));
		};
	};
	CHECK(holdsWhere(inclinedBy(0.7)));
	CHECK_FALSE(holdsWhere(inclinedBy(0.9)));
}

TEST_CASE("a contact hands on its history to a surface that moves alike", "[interface]")
{
	auto free = [](RigidPartner<2>& partner) { partner.inverseMass.setOnes(); };
	CHECK_FALSE(holdsWhere([&](Seam& s) { free(s.partners[1]); }));
	CHECK_FALSE(holdsWhere([&](Seam& s) {
		for (RigidPartner<2>& partner : s.partners)
			free(partner);
	}));
	CHECK(holdsWhere([&](Seam& s) { // members of a clump
		free(s.partners[0]);
		s.right.rigid->partner = 0;
	}));
	CHECK_FALSE(holdsWhere([](Seam& s) { s.partners[0].velocity = Vec<2>(1, 0); }));
	auto turnTogether = [](Seam& s) { // about the origin
		for (RigidPartner<2>& partner : s.partners)
			partner.spin[0] = 3;
		s.partners[1].centre = Vec<2>(2, 1);
		s.partners[1].velocity = spinCross<2>(s.partners[1].spin, s.partners[1].centre);
	};
	CHECK(holdsWhere(turnTogether));
	CHECK_FALSE(holdsWhere([&](Seam& s) {
		turnTogether(s);
		s.right.image.velocity = Vec<2>(1e-3, 0);
	}));
	CHECK(holdsWhere([&](Seam& s) { // seen from a period away
		turnTogether(s);
		for (ContactList<2>* list : { &s.left, &s.right })
			list->image.shift = Vec<2>(5, 0);
		s.bodies[0].position[Seam::node] += Vec<2>(5, 0);
	}));
}
