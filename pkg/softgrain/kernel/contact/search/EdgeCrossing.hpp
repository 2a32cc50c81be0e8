// Sharp edges that cross: in space two edges touch between their nodes, where no node of one is
// near a side of the other.
#pragma once

#include "Vector.hpp"
#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"

#include <array>
#include <optional>

namespace softgrain {

/// A straight piece of an edge.
struct EdgePiece {
	Vec<3> from, to;

	Vec<3> middle() const { return at(0.5); }
	Vec<3> at(double share) const { return from + share * (to - from); }
};

/// One where the body is convex, and the directions (unit, across it) in which the sides that meet
/// there leave it; that of a plate counts as both.
struct ConvexEdge : EdgePiece {
	std::array<Vec<3>, 2> side;
};

/// The places at which the lines of two pieces are nearest to each other.
struct NearestPlaces {
	double onFirst, onSecond; ///< shares of the ways from `from` to `to`
};

/// None where the lines are parallel within 6 degrees: then nodes hold what edges do.
std::optional<NearestPlaces> nearestPlaces(const EdgePiece& first, const EdgePiece& second);

/// Whether a place is on a piece that ends where it ends.
bool isBetweenEnds(double share);

/// Whether a place is on a piece of an edge of an outline, nearest to `other`, or a little past an
/// end and between this piece and the next: where an edge is bent inwards, places nearest to
/// something that has come through are on neither. Then both may have it.
bool isOnPiece(double share, const ContactOutline<3>& body, int number, const EdgePiece& other);

struct EdgeCrossing : NearestPlaces {
	Vec<3> normal; ///< unit, across both, from the first body to the second
	double gap;    ///< m, negative for an overlap
};

/// None where nodes hold what the edges do: where the normal does not lead out between the sides of
/// both. Nor, of acute edges, where those that seem to overlap lie before a side of the other.
std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second,
				       const NearestPlaces& nearest);

/// Whether a crossing is the way out of a body for a place `x` of the other one: within 0.25
/// `spacing` (dr of the coarser body, m) it is, deeper where the body encloses x and nothing of its
/// outline is much nearer.
bool isWayOut(const EdgeCrossing& crossing, const Vec<3>& x, const ContactOutline<3>& body,
	      double spacing);

/// A piece of a sharp edge of an outline as it is now; none where the outline is not convex there.
std::optional<ConvexEdge> edgeOf(const ContactOutline<3>& body, int number);

/// The contact at a crossing of an edge of an outline, which is the first, but for its key. The
/// outline bears it.
Contact<3> contactAt(const EdgeCrossing& crossing, const ContactOutline<3>& body, int number);

EdgePiece pieceOf(const ContactOutline<3>& body, int number);

/// Edges of an outline that may come within `reach` (m) of a region.
std::vector<int> edgesNear(const ContactOutline<3>& body, const Box<3>& region, double reach);

/// Notes the pieces of two outlines that may cross with a gap below `reach` (m, > 0) while their
/// bodies have come no nearer to each other than by that.
void findCandidateEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
			double reach, ContactCandidates<3>& candidates);

/// Appends the contacts of those that cross with a gap below `reach` (m, > 0) to the list, in the
/// order of their keys.
void findCrossingEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list);

} // namespace softgrain
