// What a search keeps for the next steps.
#pragma once

#include "Rare.hpp"
#include "Vector.hpp"
#include "contact/NearbyFacets.hpp"

#include <array>
#include <vector>

namespace softgrain {

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

} // namespace softgrain
