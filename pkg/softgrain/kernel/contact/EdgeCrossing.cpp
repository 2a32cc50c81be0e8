#include "contact/EdgeCrossing.hpp"
#include "contact/OutlineSearch.hpp"
#include "contact/PlaceOnOutline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Sine of the angles within which nodes hold what the edges do: an edge sinks by less than half
/// of it between them, in dr.
constexpr double heldByNodes = 0.1;

/// Of pieces that lie in a row none is to lose the place between them.
constexpr double rounding = 1e-9;

bool isBetweenEnds(double share) { return share >= -rounding && share <= 1 + rounding; }

/// Whether a direction leads out of the body at an edge, away from both sides.
bool leadsOut(const ConvexEdge& edge, const Vec<3>& way)
{
	return way.dot(edge.side[0]) < -heldByNodes && way.dot(edge.side[1]) < -heldByNodes;
}

/// Whether what it leads out of there is behind both sides. (An edge of a plate has one.)
bool leadsThroughSides(const ConvexEdge& edge, const Vec<3>& way)
{
	const auto& [a, b] = edge.side;
	const double cosine = a.dot(b);
	return way.dot(cosine * a - b) >= 0 && way.dot(cosine * b - a) >= 0;
}

} // namespace

std::optional<std::array<double, 2>> nearestBetweenEnds(const EdgePiece& first,
							const EdgePiece& second)
{
	const Vec<3> a = first.to - first.from, b = second.to - second.from;
	const Vec<3> apart = second.from - first.from;
	const Vec<3> across = a.cross(b);
	const double squared = across.squaredNorm();
	if (!(squared > heldByNodes * heldByNodes * a.squaredNorm() * b.squaredNorm()))
		return std::nullopt;
	const double s = apart.cross(b).dot(across) / squared;
	const double t = apart.cross(a).dot(across) / squared;
	if (!isBetweenEnds(s) || !isBetweenEnds(t)) return std::nullopt;
	return { { s, t } };
}

std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second)
{
	const auto shares = nearestBetweenEnds(first, second);
	if (!shares) return std::nullopt;
	const auto [s, t] = *shares;
	const Vec<3> a = first.to - first.from, b = second.to - second.from;
	const Vec<3> across = a.cross(b).normalized();
	for (const Vec<3>& normal : { across, Vec<3>(-across) }) {
		const double gap = (second.from - first.from).dot(normal);
		if (!leadsOut(first, normal) || !leadsOut(second, -normal)) continue;
		if (gap >= 0 ||
		    (leadsThroughSides(first, normal) && leadsThroughSides(second, -normal)))
			return EdgeCrossing { s, t, normal, gap };
	}
	return std::nullopt;
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
	const Box<3> around = region.grown(reach + 0.5 * body.longestEdge);
	return numbersThat(static_cast<int>(body.mesh->sharpEdge.size()), [&](int k) {
		const EdgePiece piece = pieceOf(body, k);
		return around.contains(0.5 * (piece.from + piece.to));
	});
}

/// (What overlaps lies in the box of the other body. The sides at an edge are looked at last: few
/// pieces cross.)
void findCrossingEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list)
{
	const auto others = edgesNear(second, first.box, reach);
	if (others.empty()) return;
	const double margin = marginOf(first, second, reach);
	const double within = margin + first.longestEdge + second.longestEdge;
	for (int e : edgesNear(first, second.box, reach)) {
		const EdgePiece piece = pieceOf(first, e);
		for (int o : others) {
			const EdgePiece other = pieceOf(second, o);
			if ((other.from - piece.from).squaredNorm() > within * within) continue;
			if (!nearestBetweenEnds(piece, other)) continue;
			const auto edge = edgeOf(first, e), otherEdge = edgeOf(second, o);
			if (!edge || !otherEdge) continue;
			const auto crossing = crossingOf(*edge, *otherEdge);
			if (!crossing || crossing->gap >= reach || crossing->gap < -margin ||
			    !isKept(crossing->gap, first, second, list))
				continue;
			Contact<3>& contact =
				list.contacts.emplace_back(contactAt(*crossing, first, e));
			contact.key = { ContactKey::edges, e, o };
			const SharpEdge& sharp = second.mesh->sharpEdge[o];
			static_cast<PlaceOnEdge<3>&>(contact) = { sharp.from, sharp.to,
								  crossing->onSecond };
		}
	}
}

} // namespace softgrain
