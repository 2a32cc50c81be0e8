#include "contact/search/SmoothSearch.hpp"
#include "contact/search/CandidateFacets.hpp"
#include "contact/search/Gaps.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <cmath>
#include <optional>
#include <utility>

namespace softgrain {

namespace {

/// Deeper overlaps, in dr, are looked at: before the tip of a fold, as outlines have them about
/// pores that have almost closed, a node may lie behind the line of the flank that is nearest.
constexpr double trustedOverlap = 0.05;

/// A place on a facet, its share of the way along it.
struct PlaceAlong {
	int facet;
	double t;
};

/// (The nearest facet is sought from that of the node before: most others are farther.)
void findCandidates(const ContactOutline<2>& body, const ContactOutline<2>& other, int side,
		    double within, ContactList<2>& list)
{
	struct NodeAtFacet {
		int node, facet;
	};
	ContactCandidates<2>& candidates = list.candidates;
	auto take = [&](const NodeAtFacet& found, const auto& measured) {
		const double gap = measured.gap();
		if (gap < within)
			candidates.nodes.push_back(
				{ side, found.node, found.facet, gap + candidates.approached });
	};
	Gaps<2, NodeAtFacet, decltype(take)> gaps(take);
	PlaceOnOutline<2> place;
	forNodesNear(body, other, within, list, [&](int s, const auto& facets) {
		const Vec<2>& x = body.position[s];
		if (place.facet >= 0) place = placeOnFacet(x, other, place.facet);
		place = nearestPlace(x, other, facets, anyFacet, place);
		gaps.next() = { s, place.facet };
		gaps.add(x, other, place);
	});
	gaps.measure();
}

void findCandidates(const ContactOutline<3>& body, const ContactOutline<3>& other, int side,
		    double within, ContactList<3>& list)
{
	ContactCandidates<3>& candidates = list.candidates;
	PlaceOnOutline<3> place;
	forNodesNear(body, other, within, list, [&](int s, const auto& facets) {
		const Vec<3>& x = body.position[s];
		if (place.facet >= 0) place = placeOnFacet(x, other, place.facet);
		place = nearestPlace(x, other, facets, anyFacet, place);
		Contact<3> contact;
		measureGap(x, other, place, contact);
		if (contact.gap < within)
			candidates.nodes.push_back(
				{ side, s, place.facet,
				  contact.gap - jumpBetween(body, other) + candidates.approached });
	});
}

/// The place on a facet nearest to `x` if it is not an end, and of both facets beside it no place
/// but the common end is near.
std::optional<PlaceAlong> placeBeneath(const Vec<2>& x, const ContactOutline<2>& body, int facet)
{
	const auto& [before, begin, end, after] = body.mesh->carriers(facet);
	auto isAhead = [&](int node, int next) {
		const Vec<2>& corner = body.position[node];
		return (x - corner).dot(body.position[next] - corner) > 0;
	};
	if (isAhead(begin, before) || isAhead(end, after)) return std::nullopt;
	const Vec<2> edge = body.position[end] - body.position[begin];
	const double t = (x - body.position[begin]).dot(edge) / edge.squaredNorm();
	if (!(t > 0 && t < 1)) return std::nullopt;
	return PlaceAlong { facet, t };
}

/// Nearest place to `x`, from facet to facet as long as the next is nearer (of two as near, as at a
/// common end, the first in order).
PlaceAlong followOutline(const Vec<2>& x, const ContactOutline<2>& body, int facet)
{
	if (const auto place = placeBeneath(x, body, facet)) return *place;
	const int count = static_cast<int>(body.mesh->facet.size());
	PlaceOnOutline<2> best = placeOnFacet<2>(x, body, facet);
	for (int step : { 1, count - 1 })
		while (true) {
			const auto next = placeOnFacet<2>(x, body, (best.facet + step) % count);
			if (!comesBefore(next, best)) break;
			best = next;
		}
	return { best.facet, best.weight[1] };
}

/// Whether a node that counts as deep is outside all the same: of the facets, and not under the
/// curve over its own.
bool isBeforeFold(const Vec<2>& x, const ContactOutline<2>& other, int facet, double gap)
{
	const double deep = -gap - trustedOverlap * other.pointSpacing;
	return deep > 0 && deep > OutlineCurve(other, facet).bulge() && !other.encloses(x);
}

/// Whether a node outside is farther from its facet than the gap says: beside the end of the curve
/// over it, where an outline turns sharply. (Such nodes had force at 0.4 to 2 dr; the margin of 0.1
/// dr is far below.)
bool isBesideFold(const Vec<2>& x, const ContactOutline<2>& other, int facet, double gap)
{
	if (!other.folded && !other.bent) return false;
	const double distance = std::sqrt(placeOnFacet(x, other, facet).squaredDistance);
	const double most = gap + 2 * trustedOverlap * other.pointSpacing;
	return most < distance - OutlineCurve(other, facet).bulge() && !other.encloses(x);
}

void measureCandidates(const ContactOutline<2>& first, const ContactOutline<2>& second,
		       double reach, ContactList<2>& list)
{
	using Node = ContactCandidates<2>::Node;
	const std::array<const ContactOutline<2>*, 2> body { &first, &second };
	auto take = [&](Node* node, const auto& measured) {
		const ContactOutline<2>&own = *body[node->side], &other = *body[1 - node->side];
		const double gap = measured.gap();
		++list.tested;
		node->clearance = gap + list.candidates.approached;
		const Vec<2>& x = own.position[node->node];
		if (gap >= reach || isBeforeFold(x, other, node->facet, gap) ||
		    isBesideFold(x, other, node->facet, gap))
			return;
		if (auto* contact = append({ node->side, node->node, -1 }, gap, own, other, list))
			measured.write(*contact);
	};
	Gaps<2, Node*, decltype(take)> gaps(take);
	forCandidates(reach, list.candidates, [&](Node& node) {
		const Vec<2>& x = body[node.side]->position[node.node];
		const ContactOutline<2>& other = *body[1 - node.side];
		const auto place = followOutline(x, other, node.facet);
		node.facet = place.facet;
		gaps.next() = &node;
		gaps.add(x, other, { place.facet, { 1 - place.t, place.t } });
	});
	gaps.measure();
}

/// One by one, each against the facets that may be nearest.
void measureCandidates(const ContactOutline<3>& first, const ContactOutline<3>& second,
		       double reach, ContactList<3>& list)
{
	ContactCandidates<3>& candidates = list.candidates;
	const double within =
		candidateReach(first, second, candidates.covered - candidates.approached);
	const std::array<const ContactOutline<3>*, 2> body { &first, &second };
	std::array<CandidateFacets<3>, 2> facets { { { first, second, within, candidates },
						     { second, first, within, candidates } } };
	forCandidates(reach, candidates, [&](auto& node) {
		const ContactOutline<3>&own = *body[node.side], &other = *body[1 - node.side];
		PlaceOnOutline<3> place;
		facets[node.side].findNearest(node, place);
		Contact<3>& contact = list.contacts.emplace_back();
		contact.key = { node.side, node.node, -1 };
		measureGap(own.position[node.node], other, place, contact);
		++list.tested;
		node.clearance = contact.gap - jumpBetween(own, other) + candidates.approached;
		if (contact.gap >= reach || !noteAndKeep(contact.gap, own, other, list))
			list.contacts.pop_back();
	});
}

} // namespace

template <int dim>
void findContactsOfSmoothOutlines(const ContactOutline<dim>& first,
				  const ContactOutline<dim>& second, double reach,
				  ContactList<dim>& list)
{
	followBodies(first, second, reach, list.candidates);
	// about folds gaps change by jumps, and what is nearest depends on where a node came from
	const bool lasts = !first.folded && !second.folded;
	renewCandidates<dim>(first, second, reach, lasts, jumpBetween(first, second),
			     list.candidates,
			     [&](const auto& body, const auto& other, int side, double within) {
				     findCandidates(body, other, side, within, list);
			     });
	if (!list.candidates.nodes.empty()) measureCandidates(first, second, reach, list);
}

template void findContactsOfSmoothOutlines<2>(const ContactOutline<2>&, const ContactOutline<2>&,
					      double, ContactList<2>&);
template void findContactsOfSmoothOutlines<3>(const ContactOutline<3>&, const ContactOutline<3>&,
					      double, ContactList<3>&);

} // namespace softgrain
