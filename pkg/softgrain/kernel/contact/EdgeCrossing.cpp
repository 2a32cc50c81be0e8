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

/// Shares of the ways along two lines at which these are nearest; none for parallel ones.
std::optional<std::array<double, 2>> nearestOfLines(const ConvexEdge& first,
						    const ConvexEdge& second)
{
	const Vec<3> a = first.to - first.from, b = second.to - second.from;
	const Vec<3> apart = second.from - first.from;
	const Vec<3> across = a.cross(b);
	const double squared = across.squaredNorm();
	if (!(squared > heldByNodes * heldByNodes * a.squaredNorm() * b.squaredNorm()))
		return std::nullopt;
	return { { apart.cross(b).dot(across) / squared, apart.cross(a).dot(across) / squared } };
}

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

std::optional<EdgeCrossing> crossingOf(const ConvexEdge& first, const ConvexEdge& second)
{
	const auto shares = nearestOfLines(first, second);
	if (!shares) return std::nullopt;
	const auto [s, t] = *shares;
	if (!isBetweenEnds(s) || !isBetweenEnds(t)) return std::nullopt;
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

std::optional<ConvexEdge> edgeOf(const ContactOutline<3>& body, int number)
{
	const SharpEdge& sharp = body.mesh->sharpEdge[number];
	ConvexEdge edge { body.position[sharp.from], body.position[sharp.to], {} };
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

std::vector<int> edgesNear(const ContactOutline<3>& body, const Box<3>& region, double margin)
{
	const Box<3> around = region.grown(margin + body.longestEdge);
	const std::vector<SharpEdge>& edges = body.mesh->sharpEdge;
	return numbersThat(static_cast<int>(edges.size()),
			   [&](int k) { return around.contains(body.position[edges[k].from]); });
}

void findCrossingEdges(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list)
{
	const double margin = marginOf(first, second, reach);
	const auto others = edgesNear(second, first.box, margin);
	if (others.empty()) return;
	const double within = margin + first.longestEdge + second.longestEdge;
	for (int e : edgesNear(first, second.box, margin)) {
		const Vec<3>& x = first.position[first.mesh->sharpEdge[e].from];
		const auto edge = edgeOf(first, e);
		if (!edge) continue;
		for (int o : others) {
			const SharpEdge& sharp = second.mesh->sharpEdge[o];
			if ((second.position[sharp.from] - x).squaredNorm() > within * within)
				continue;
			const auto other = edgeOf(second, o);
			const auto crossing = other ? crossingOf(*edge, *other) : std::nullopt;
			if (!crossing || crossing->gap >= reach || crossing->gap < -margin ||
			    !isKept(crossing->gap, first, second, list))
				continue;
			Contact<3>& contact =
				list.contacts.emplace_back(contactAt(*crossing, first, e));
			contact.key = { ContactKey::edges, e, o };
			static_cast<PlaceOnEdge<3>&>(contact) = { sharp.from, sharp.to,
								  crossing->onSecond };
		}
	}
}

} // namespace softgrain
