// Sharp edges that cross: in space two edges touch between their nodes, where no node of one is
// near a side of the other.
#pragma once

#include "Vector.hpp"
#include "contact/Contact.hpp"
#include "contact/ContactOutline.hpp"

#include <array>
#include <optional>

namespace softgrain {

/// A straight piece of an edge.
struct EdgePiece {
	Vec<3> from, to;
};

/// One where the body is convex, and the directions (unit, across it) in which the sides that meet
/// there leave it; that of a plate counts as both.
struct ConvexEdge : EdgePiece {
	std::array<Vec<3>, 2> side;
};

/// Shares of the ways from `from` to `to` at which the lines of two pieces are nearest to each
/// other, if both are between the ends, and the lines not parallel within 6 degrees.
std::optional<std::array<double, 2>> nearestBetweenEnds(const EdgePiece& first,
							const EdgePiece& second);

/// The places at which two edges are nearest.
struct EdgeCrossing {
	double onFirst, onSecond; ///< shares of the ways from `from` to `to`
	Vec<3> normal;            ///< unit, across both, from the first body to the second
	double gap;               ///< m, negative for an overlap
};

/// None where one of the edges ends before, or where nodes hold what the edges do: where these are
/// parallel within 6 degrees, or the normal does not lead out between the sides of both, by so
/// much. Nor, of acute edges, where those that seem to overlap lie before a side of the other.
std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second);

/// A piece of a sharp edge of an outline as it is now; none where the outline is not convex there.
std::optional<ConvexEdge> edgeOf(const ContactOutline<3>& body, int number);

/// The contact at a crossing of an edge of an outline, which is the first, but for its key. The
/// outline bears it.
Contact<3> contactAt(const EdgeCrossing& crossing, const ContactOutline<3>& body, int number);

EdgePiece pieceOf(const ContactOutline<3>& body, int number);

/// Edges of an outline that may come within `reach` (m) of a region.
std::vector<int> edgesNear(const ContactOutline<3>& body, const Box<3>& region, double reach);

/// Appends the contacts of edges that cross with a gap below `reach` (m, > 0) to `list`, in the
/// order of their keys.
void findCrossingEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list);

} // namespace softgrain
