// The contacts of one pair of bodies.
#pragma once

#include "Rare.hpp"
#include "Vector.hpp"
#include "contact/Contact.hpp"
#include "contact/ContactCandidates.hpp"
#include "contact/Interface.hpp"
#include "contact/OverlapAccount.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/RigidSide.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <tuple>
#include <vector>

namespace softgrain {

/// How the first body of a pair sees the second one in a periodic space: displaced by a period, and
/// moving as the period changes. All zero for the body itself.
template <int dim> struct PairImage {
	Vec<dim> shift = Vec<dim>::Zero();    ///< at t_n, m
	Vec<dim> velocity = Vec<dim>::Zero(); ///< of the shift in the step at hand, m/s
};

/// What the contacts of a pair do together, on its first body.
template <int dim> struct PairImpulse {
	Vec<dim> normal = Vec<dim>::Zero(), shear = Vec<dim>::Zero(); ///< N s
	Vec<dim> point = Vec<dim>::Zero();    ///< mean of the contact points by the size of their
					      ///< normal forces, m
	int active = 0;                       ///< contacts with an impulse
	Spin<dim> moment = Spin<dim>::Zero(); ///< on a rigid partner, N m s
};

/// Of a pair that is asleep: both bodies lie still, and contacts and impulses stay as they are.
struct PairRest {
	double kick = 0;                   ///< time over which the impulses acted, s; 0: awake
	std::vector<double> placeOfSecond; ///< ContactList::placeOfSecond then
	bool changed = false; ///< a body or the friction, since: the pair is to be woken
	bool found = true;    ///< contacts are complete; after loading only keys and impulses are
	bool kept = false;    ///< impulses were those of the step before in the last step
};

/// What a pair did to a grain when that fell asleep, in balance with all else that acts on it.
template <int dim> struct ForceAtRest {
	Vec<dim> force = Vec<dim>::Zero(); ///< on the first body of the pair, N
	Vec<dim> point = Vec<dim>::Zero(); ///< where, m
};

/// All contacts of two bodies, sorted by key.
template <int dim> struct ContactList {
	int first = -1; ///< index of the first body
	/// Index of the second body; negative: `rigid` or `plane`, the number its name.
	int second = -1;
	Plane<dim> plane;
	Rare<RigidSide<dim>> rigid;         ///< its surface as the image has it
	PairImage<dim> image;               ///< of a second grain or a rigid body
	double friction = 0;                ///< coefficient mu
	Rare<PairInterface<dim>> interface; ///< what acts besides, if anything does
	/// Largest overlap met by the search, in dr; infinite for nested grains.
	double deepest = 0;
	std::vector<Contact<dim>> contacts;
	PairImpulse<dim> impulse; ///< of the last step, if there are contacts
	OverlapAccount account;
	PairRest rest;
	/// With another grain, by its two grains: of one that sleeps. (Of one that is awake it
	/// means nothing.)
	std::array<Rare<ForceAtRest<dim>>, 2> atRest;
	ContactCandidates<dim> candidates;
	int tested = 0; ///< nodes that the last search measured against the other body

	int grain(int side) const { return side == 0 ? first : second; } ///< negative: none
	bool isAsleep() const { return rest.kick > 0 && !rest.changed; }
	/// Of its impulses of the last step, which acted for `kick`.
	ForceAtRest<dim> meanForce(double kick) const
	{
		return { (impulse.normal + impulse.shear) / kick, impulse.point };
	}
	/// It holds what was when one of its grains fell asleep.
	bool isKeptForSleepers() const { return rest.kick > 0 || atRest[0] || atRest[1]; }
	/// Whether the second body is a plane or a rigid body that neither moves nor is moved by
	/// impulses, as far as it is known.
	bool hasStillSupport() const;
	/// Where the plane or the rigid body is, or the image of the second grain if it is
	/// displaced, in numbers.
	std::vector<double> placeOfSecond() const;
	void clearContacts()
	{
		contacts.clear();
		deepest = 0;
		if (interface) interface->beginSearch();
	}
	/// Keeps the deepest; `pointSpacing` is the mean dr of the two grains, m.
	void noteOverlap(double gap, double pointSpacing)
	{
		deepest = std::max(deepest, -gap / pointSpacing);
	}
	/// Number of the second body among `grains` grains and the rigid partners after them, if
	/// what the contacts do to it is felt by other pairs; else -1.
	int sharedSecond(int grains) const
	{
		if (rigid && rigid->moves) return grains + rigid->partner;
		return std::max(second, -1);
	}
	/// The contact at which contact k is bonded: itself, or, since an end of a rigid body
	/// stands for no area, that of the node that the end leans on most, of those within reach.
	/// (Nor do edges that cross; those of two grains bear no bond.)
	std::optional<std::size_t> placeOfBond(std::size_t k) const;
	/// Mean of the normals by the size of their normal forces, towards the first body, unit;
	/// zero without forces.
	Vec<dim> direction() const;
	/// By first body; its planes and rigid bodies in the order of their names, then its grains.
	std::tuple<int, bool, int> sweepOrder() const
	{
		return { first, second >= 0, std::abs(second) };
	}
};

} // namespace softgrain
