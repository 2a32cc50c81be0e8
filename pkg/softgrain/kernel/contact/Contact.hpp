// A contact: a node of one body against a place on another, or two edges.
#pragma once

#include "Vector.hpp"
#include "reference/Outline.hpp"

#include <array>
#include <tuple>

namespace softgrain {

/// Names a contact from step to step: the node, and for disk against disk the other node too.
struct ContactKey {
	static constexpr int edges = 2; ///< side, where sharp edges cross

	int side = 0;   ///< 0: the node belongs to the pair's first body, 1: to the second
	int node = -1;  ///< where edges cross, the number of that of the first body; on a common
			///< grid it does not last, and `other` names the grid's node
	int other = -1; ///< node of the other body, or -1 against an outline or a plane; where
			///< edges cross, the number of that of the second body

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

/// By how much a contact with a rigid body turned about its normal in the last step, since the body
/// did: the shear impulse turns with it. In the plane it cannot. (About facets of grains local
/// vibrations turn by more than the grain: impulses that followed these would amplify rounding.)
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

} // namespace softgrain
