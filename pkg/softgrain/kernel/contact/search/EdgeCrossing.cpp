#include "contact/search/EdgeCrossing.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Sine of the angle within which edges are parallel: nodes hold what they do.
constexpr double parallel = 0.1;

/// Sine of the angle at least by which a normal leads out from a side: along a side nodes hold what
/// edges do, which sink between them by no more than this, in dr of the coarser body. (With 0.1
/// contacts of edges under load went on and off.)
constexpr double leastLean = 0.03;

/// Of pieces that lie in a row none is to lose the place between them; of sides none is to be both
/// before and behind.
constexpr double rounding = 1e-9;

/// So far past its end, in its length, a piece may have what is between it and the next. (Edges
/// that are bent by 45 degrees and overlap by 0.25 dr.)
constexpr double mostPastEnd = 0.2;
/// The same from its middle.
constexpr double mostFromMiddle = 0.5 + mostPastEnd;

/// Overlaps, in dr, that are believed: what lies deeper may have a shorter way out.
constexpr double trustedDepth = 0.25;

/// The way out may be longer than that to what is nearest by so much: from a ridge of right angle
/// it is 1.4 times as long. (With 2 a blade of facets in a soft bar had overlaps of edges twice as
/// deep as it was, and the run stopped.)
constexpr double mostDetour = 1.7;

/// Whether a direction leads out of the body at an edge, away from both sides.
bool leadsOut(const ConvexEdge& edge, const Vec<3>& way)
{
	return way.dot(edge.side[0]) < -leastLean && way.dot(edge.side[1]) < -leastLean;
}

/// Whether what it leads out of there is behind both sides. (An edge of a plate has one.)
bool leadsThroughSides(const ConvexEdge& edge, const Vec<3>& way)
{
	const auto& [a, b] = edge.side;
	const double cosine = a.dot(b);
	return way.dot(cosine * a - b) >= -rounding && way.dot(cosine * b - a) >= -rounding;
}

} // namespace

std::optional<NearestPlaces> nearestPlaces(const EdgePiece& first, const EdgePiece& second)
{
	const Vec<3> a = first.to - first.from, b = second.to - second.from;
	const Vec<3> apart = second.from - first.from;
	const Vec<3> across = a.cross(b);
	const double squared = across.squaredNorm();
	if (!(squared > parallel * parallel * a.squaredNorm() * b.squaredNorm()))
		return std::nullopt;
	return NearestPlaces { apart.cross(b).dot(across) / squared,
			       apart.cross(a).dot(across) / squared };
}

bool isBetweenEnds(double share) { return share >= -rounding && share <= 1 + rounding; }

bool isOnPiece(double share, const ContactOutline<3>& body, int number, const EdgePiece& other)
{
	if (isBetweenEnds(share)) return true;
	const int end = share > 0.5;
	if (std::abs(share - end) > mostPastEnd) return false;
	const SharpEdge& sharp = body.mesh->sharpEdge[number];
	const int next = sharp.next[end];
	if (next < 0) return false;
	const auto nearest = nearestPlaces(pieceOf(body, next), other);
	if (!nearest) return true;
	const int joint = end == 0 ? sharp.from : sharp.to;
	return body.mesh->sharpEdge[next].from == joint ? nearest->onFirst < -rounding
							: nearest->onFirst > 1 + rounding;
}

std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second,
				       const NearestPlaces& nearest)
{
	const Vec<3> a = first.to - first.from, b = second.to - second.from;
	const Vec<3> across = a.cross(b).normalized();
	for (const Vec<3>& normal : { across, Vec<3>(-across) }) {
		const double gap = (second.from - first.from).dot(normal);
		if (!leadsOut(first, normal) || !leadsOut(second, -normal)) continue;
		if (gap >= 0 ||
		    (leadsThroughSides(first, normal) && leadsThroughSides(second, -normal)))
			return EdgeCrossing { nearest, normal, gap };
	}
	return std::nullopt;
}

bool isWayOut(const EdgeCrossing& crossing, const Vec<3>& x, const ContactOutline<3>& body,
	      double spacing)
{
	if (crossing.gap >= -trustedDepth * spacing) return true;
	if (!body.encloses(x)) return false;
	const auto around = Box<3> { x, x }.grown(-crossing.gap);
	const auto place = nearestPlace(x, body, facetsIn(body, around), anyFacet);
	return -crossing.gap <= mostDetour * std::sqrt(place.squaredDistance);
}

EdgePiece pieceOf(const ContactOutline<3>& body, int number)
{
	const SharpEdge& sharp = body.mesh->sharpEdge[number];
	return { body.position[sharp.from], body.position[sharp.to] };
}

std::optional<ConvexEdge> edgeOf(const ContactOutline<3>& body, int number)
{
	const SharpEdge& sharp = body.mesh->sharpEdge[number];
	ConvexEdge edge { pieceOf(body, number), {} };
	const Vec<3> along = (edge.to - edge.from).normalized();
	for (int i : { 0, 1 }) {
		const Vec<3> away = body.position[sharp.opposite[i]] - edge.from;
		edge.side[i] = (away - away.dot(along) * along).normalized();
	}
	const bool isConvex = edge.side[1].dot(body.areaOfFacet(sharp.facet[0])) < 0;
	return isConvex ? std::optional(edge) : std::nullopt;
}

Contact<3> contactAt(const EdgeCrossing& crossing, const ContactOutline<3>& body, int number)
{
	const SharpEdge& sharp = body.mesh->sharpEdge[number];
	Contact<3> contact;
	contact.facet = sharp.facet[0];
	contact.partners = mostPartners<3>;
	contact.partner = body.mesh->facet[contact.facet];
	for (int i = 0; i < 3; ++i) {
		if (contact.partner[i] == sharp.from) contact.weight[i] = 1 - crossing.onFirst;
		if (contact.partner[i] == sharp.to) contact.weight[i] = crossing.onFirst;
	}
	contact.normal = crossing.normal;
	contact.gap = crossing.gap;
	return contact;
}

std::vector<int> edgesNear(const ContactOutline<3>& body, const Box<3>& region, double reach)
{
	const Box<3> around = region.grown(reach + mostFromMiddle * body.longestEdge);
	return numbersThat(static_cast<int>(body.mesh->sharpEdge.size()),
			   [&](int k) { return around.contains(pieceOf(body, k).middle()); });
}

/// (What overlaps lies in the box of the other body.)
void findCandidateEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
			double reach, ContactCandidates<3>& candidates)
{
	candidates.edges.reset();
	const auto others = edgesNear(second, first.box, reach);
	if (others.empty()) return;
	const double within = reach + contactDepth(first, second) +
			      mostFromMiddle * (first.longestEdge + second.longestEdge);
	std::vector<std::array<int, 2>> near;
	for (int e : edgesNear(first, second.box, reach)) {
		const Vec<3> middle = pieceOf(first, e).middle();
		for (int o : others)
			if ((pieceOf(second, o).middle() - middle).squaredNorm() < within * within)
				near.push_back({ e, o });
	}
	if (!near.empty()) candidates.edges.emplace() = std::move(near);
}

/// (The sides at an edge are looked at last: few pieces cross.)
void findCrossingEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list)
{
	if (!list.candidates.edges) return;
	const double deep = contactDepth(first, second);
	const double coarser = std::max(first.pointSpacing, second.pointSpacing);
	for (const auto& [e, o] : *list.candidates.edges) {
		const EdgePiece piece = pieceOf(first, e), other = pieceOf(second, o);
		const auto nearest = nearestPlaces(piece, other);
		if (!nearest || !isOnPiece(nearest->onFirst, first, e, other) ||
		    !isOnPiece(nearest->onSecond, second, o, piece))
			continue;
		const auto edge = edgeOf(first, e), otherEdge = edgeOf(second, o);
		if (!edge || !otherEdge) continue;
		const auto crossing = crossingOf(*edge, *otherEdge, *nearest);
		if (!crossing || crossing->gap >= reach || crossing->gap < -deep) continue;
		if (!isWayOut(*crossing, other.at(nearest->onSecond), first, coarser) ||
		    !isWayOut(*crossing, piece.at(nearest->onFirst), second, coarser))
			continue;
		list.noteOverlap(crossing->gap, meanSpacing(first, second));
		Contact<3>& contact = list.contacts.emplace_back(contactAt(*crossing, first, e));
		contact.key = { ContactKey::edges, e, o };
		const SharpEdge& sharp = second.mesh->sharpEdge[o];
		static_cast<PlaceOnEdge<3>&>(contact) = { sharp.from, sharp.to,
							  crossing->onSecond };
	}
}

} // namespace softgrain
