// A contact and the contacts of one pair of bodies.
#pragma once

#include "Rare.hpp"
#include "Vector.hpp"
#include "Vectors.hpp"
#include "contact/Interface.hpp"
#include "contact/NearbyFacets.hpp"
#include "contact/OverlapAccount.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/RigidSurface.hpp"
#include "reference/Outline.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <optional>
#include <tuple>
#include <vector>

namespace softgrain {

/// Names a contact from step to step: the node, and for disk against disk the other node too.
struct ContactKey {
	static constexpr int edges = 2; ///< side, where sharp edges cross

	int side;  ///< 0: the node belongs to the pair's first body, 1: to the second
	int node;  ///< where edges cross, the number of that of the first body
	int other; ///< node of the other body, or -1 against an outline or a plane; where edges
		   ///< cross, the number of that of the second body

	bool isOfEdges() const { return side == edges; }
	/// On which body of the pair the impulse acts, the other one bears it: 0 the first, 1 the
	/// second, as where edges cross.
	int body() const { return side == 0 ? 0 : 1; }

	bool operator<(const ContactKey& o) const
	{
		return std::tie(side, node, other) < std::tie(o.side, o.node, o.other);
	}
	bool operator==(const ContactKey& o) const
	{
		return side == o.side && node == o.node && other == o.other;
	}
};

/// How far a contact with a rigid body turned about its normal in the last step, as that did. In
/// the plane it cannot. (About facets of grains local vibrations turn by more than the grain:
/// impulses that followed these would amplify rounding.)
template <int dim> struct ContactTwist {
	void setTwist(double) {}
};
template <> struct ContactTwist<3> {
	double twist = 0; ///< rad
	void setTwist(double angle) { twist = angle; }
};

/// Where, in space, what acts at a crossing of edges acts on the second body, if that is a grain:
/// between two of its nodes.
template <int dim> struct PlaceOnEdge {
	constexpr bool isOnEdge() const { return false; }
};
template <> struct PlaceOnEdge<3> {
	int from = -1, to = -1; ///< nodes; -1: not on an edge
	double share = 0;       ///< of the way between them

	bool isOnEdge() const { return from >= 0; }
};

/// Calls with the nodes, and their shares, on which the impulse of a contact acts: one, `node`, if
/// not on an edge.
template <int dim, class Use> void forOwnNodes(const PlaceOnEdge<dim>& place, int node, Use&& use)
{
	if constexpr (dim == 3)
		if (place.isOnEdge()) {
			use(place.from, 1 - place.share);
			use(place.to, place.share);
			return;
		}
	use(node, 1.);
}

/// One contact node of one body against a place on another body, or two edges.
template <int dim> struct Contact : ContactTwist<dim>, PlaceOnEdge<dim> {
	ContactKey key;
	int partners = 0; ///< nodes of the other body it leans on: 0 (plane), 1 or `mostPartners`
	int facet = -1;   ///< of the other body that it lies against, where that has facets
	std::array<int, mostPartners<dim>> partner {};   ///< these nodes
	std::array<double, mostPartners<dim>> weight {}; ///< their shares, sum 1
	Vec<dim> normal = Vec<dim>::Zero();              ///< unit, from the other body to the node
	double gap = 0;                                  ///< m, negative for an overlap
	Vec<dim> impulse = Vec<dim>::Zero();             ///< r on the node, -r on the partners, N s

	/// forOwnNodes; none of a rigid body.
	template <class Use> void forOwnNodes(Use&& use) const
	{
		if (key.isOfEdges() && !this->isOnEdge()) return;
		softgrain::forOwnNodes<dim>(*this, key.node, use);
	}
};

/// Rigid plane with prescribed motion; the grain is on the side of the normal.
template <int dim> struct Plane {
	Vec<dim> point = Vec<dim>::Zero();
	Vec<dim> normal = Vec<dim>::Zero();
	Vec<dim> velocity = Vec<dim>::Zero(); ///< m/s
};

/// A surface beside a rigid one.
template <int dim> struct SurfaceBeside {
	RigidSurface<dim> surface;
	bool comesFirst = false; ///< a place on the seam of both touches this one only
};

/// A rigid body in place of the second grain. Contacts of side 1 are those of its own ends
/// (tipsOf); edges that cross are its own and the grain's.
template <int dim> struct RigidSide {
	RigidSurface<dim> surface;
	Vec<dim> pivot = Vec<dim>::Zero(); ///< moments of the impulses are about it, m
	VectorRange<dim> velocities;       ///< of the places of the surface, m/s
	int partner = -1;                  ///< its motion: number in the step at hand
	/// RigidPartner::moves and hasVelocity, known from the begin of a step until the next
	/// search.
	bool moves = false, hasVelocity = false;
	/// Other surfaces about the grain, during a search: asked for where it meets an edge. May
	/// be empty.
	std::function<std::vector<SurfaceBeside<dim>>()> others;
};

/// How the first body of a pair sees the second one in a periodic space: displaced by a period, and
/// moving as the period changes. All zero for the body itself.
template <int dim> struct PairImage {
	Vec<dim> shift = Vec<dim>::Zero();    ///< at t_n, m
	Vec<dim> velocity = Vec<dim>::Zero(); ///< of the shift in the step at hand, m/s
};

/// Nodes that may come into contact while their bodies have moved little since they were found.
template <int dim> struct ContactCandidates {
	struct Node {
		int side, node; ///< as in ContactKey
		int facet;      ///< of the other body: the nearest when the node was found, or, of
				///< round outlines in the plane, when it was last looked for
		double clearance; ///< its gap is at least this less `approached`, m
	};
	/// What is near one of them, and `apart` and `travelled` when it was looked for.
	struct Nearby {
		NearbyFacets<dim> facets;
		Vec<dim> apart = Vec<dim>::Zero();
		double travelled = 0;
	};
	std::vector<Node> nodes;
	/// With the nodes, where they need it. (In the plane round outlines are followed from the
	/// facet that was the nearest.)
	Rare<std::vector<Nearby>> nearby;
	/// In space, of bodies with sharp edges: pieces of the first and of the second that may
	/// cross (EdgeCrossing.hpp), if there are any.
	Rare<std::vector<std::array<int, 2>>> edges;
	double covered = 0;    ///< all nodes with a gap below this less `approached` are in it, m
	double approached = 0; ///< no gap has lost more than this so far, m
	/// At the last search: ContactOutline::carried of the first body less that of the second,
	/// and what their nodes may have travelled besides.
	Vec<dim> apart = Vec<dim>::Zero();
	double travelled = 0;

	void clear()
	{
		nodes.clear();
		if (nearby) nearby->clear();
		edges.reset();
	}
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
	int second =
		-1; ///< index of the second body; negative: `rigid` or `plane`, the number its name
	Plane<dim> plane;
	Rare<RigidSide<dim>> rigid;         ///< its surface as the image has it
	PairImage<dim> image;               ///< of a second grain or a rigid body
	double friction = 0;                ///< coefficient mu
	Rare<PairInterface<dim>> interface; ///< what acts besides, if anything does
	double deepest =
		0; ///< largest overlap met by the search, in dr; infinite for nested grains
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
	bool hasStillSupport() const
	{
		if (rigid)
			return !rigid->moves && !rigid->hasVelocity &&
			       rigid->velocities.largestNorm() == 0 && image.velocity.isZero(0);
		return second < 0 && plane.velocity.isZero(0);
	}
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
	/// By first body; its planes and rigid bodies in the order of their names, then its grains.
	std::tuple<int, bool, int> sweepOrder() const
	{
		return { first, second >= 0, std::abs(second) };
	}
};

template <int dim> std::optional<std::size_t> ContactList<dim>::placeOfBond(std::size_t k) const
{
	const Contact<dim>& c = contacts[k];
	if (!rigid && c.key.isOfEdges()) return std::nullopt;
	if (!rigid || c.key.side == 0) return k;
	std::optional<std::size_t> place;
	double most = 0;
	for (int i = 0; i < c.partners; ++i) {
		const ContactKey key { 0, c.partner[i], -1 };
		const auto found = std::lower_bound(
			contacts.begin(), contacts.end(), key,
			[](const Contact<dim>& a, const ContactKey& b) { return a.key < b; });
		if (c.weight[i] <= most || found == contacts.end() || !(found->key == key))
			continue;
		most = c.weight[i];
		place = found - contacts.begin();
	}
	return place;
}

template <int dim> std::vector<double> ContactList<dim>::placeOfSecond() const
{
	if (second >= 0 && image.shift.isZero(0)) return {};
	if (second >= 0) return { image.shift.begin(), image.shift.end() };
	if (rigid) return placeNumbers<dim>(rigid->surface);
	std::vector<double> place(plane.point.begin(), plane.point.end());
	place.insert(place.end(), plane.normal.begin(), plane.normal.end());
	return place;
}

} // namespace softgrain
