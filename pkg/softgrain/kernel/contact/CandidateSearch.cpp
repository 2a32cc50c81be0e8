#include "contact/CandidateSearch.hpp"
#include "contact/PlaceOnOutline.hpp"

#include <cmath>

namespace softgrain {

namespace {

/// Candidates are looked for this far beyond the reach, in dr: much less makes them short-lived,
/// much more makes too many.
constexpr double candidateMargin = 0.5;

/// A place on an outline moves by no more than so many times what its nodes do (sum of the sizes of
/// the weights of OutlineCurve).
constexpr double wayOfPlaces = 1.25;

/// Takes in how far nodes and places on the other outline may have come towards each other since
/// the last search.
template <int dim>
void followBodies(const ContactBody<dim>& first, const ContactBody<dim>& second,
		  ContactCandidates<dim>& candidates)
{
	const Vec<dim> apart = first.carried - second.carried;
	const double travelled = first.travelled + second.travelled;
	candidates.approached += (apart - candidates.apart).norm() +
				 wayOfPlaces * (travelled - candidates.travelled);
	candidates.apart = apart;
	candidates.travelled = travelled;
}

template <int dim>
void findCandidates(const ContactBody<dim>& body, const ContactBody<dim>& other, int side,
		    double within, ContactList<dim>& list)
{
	ContactCandidates<dim>& candidates = list.candidates;
	forNodesNear(body, other, within, list, [&](int s, const auto& facets) {
		const Vec<dim>& x = body.position[s];
		const auto place = nearestPlace(x, other, facets, anyFacet);
		const double gap = contactAt(x, other, place).gap;
		if (gap < within)
			candidates.nodes.push_back(
				{ side, s, place.facet, gap + candidates.approached });
	});
}

template <int dim>
void renewCandidates(const ContactBody<dim>& first, const ContactBody<dim>& second, double reach,
		     ContactList<dim>& list)
{
	ContactCandidates<dim>& candidates = list.candidates;
	if (reach + candidates.approached <= candidates.covered) return;
	const double within =
		reach + candidateMargin * std::min(first.pointSpacing, second.pointSpacing);
	candidates.nodes.clear();
	candidates.covered = within + candidates.approached;
	findCandidates(first, second, 0, within, list);
	findCandidates(second, first, 1, within, list);
}

PlaceOnOutline<2> placeOnFacet(const Vec<2>& x, const ContactBody<2>& body, int facet)
{
	const auto& [begin, end] = body.mesh->facet[facet];
	const auto weight = nearestOnFacet(x, { body.position[begin], body.position[end] });
	const Vec<2> nearest = weight[0] * body.position[begin] + weight[1] * body.position[end];
	return { facet, weight, (x - nearest).squaredNorm() };
}

/// Whether of both facets beside this one no place but the common end is near to `x`.
bool isBelow(const Vec<2>& x, const ContactBody<2>& body, int facet)
{
	const auto& [before, begin, end, after] = body.mesh->carriers(facet);
	const auto isBehind = [&](int node, int next) {
		const Vec<2>& corner = body.position[node];
		return (x - corner).dot(body.position[next] - corner) <= 0;
	};
	return isBehind(begin, before) && isBehind(end, after);
}

/// Nearest place to `x`, from facet to facet as long as the next is nearer (of two as near, as at a
/// common end, the first in order).
PlaceOnOutline<2> followOutline(const Vec<2>& x, const ContactBody<2>& body, int facet)
{
	const int count = static_cast<int>(body.mesh->facet.size());
	PlaceOnOutline<2> best = placeOnFacet(x, body, facet);
	if (best.weight[0] > 0 && best.weight[1] > 0 && isBelow(x, body, facet)) return best;
	for (int step : { 1, count - 1 })
		while (true) {
			const auto next = placeOnFacet(x, body, (best.facet + step) % count);
			const bool nearer = next.squaredDistance < best.squaredDistance;
			const bool first = next.squaredDistance == best.squaredDistance &&
					   next.facet < best.facet;
			if (!nearer && !first) break;
			best = next;
		}
	return best;
}

/// A bound of the gap of a node from below that is cheaper than the gap; nothing that would help
/// for nodes inside. (The curve bulges out of its facet, and at the end of a facet the gap may be a
/// little less than the distance.)
double leastGap(const Vec<2>& x, const ContactBody<2>& body, const OutlineCurve& curve,
		const PlaceOnOutline<2>& place)
{
	const Vec<2>& start = body.position[body.mesh->facet[place.facet][0]];
	if ((x - start).dot(body.areaOfFacet(place.facet)) <= 0)
		return -std::numeric_limits<double>::infinity();
	return (std::sqrt(place.squaredDistance) - curve.bulge()) / 1.5;
}

} // namespace

void findContactsOfCandidates(const ContactBody<2>& first, const ContactBody<2>& second,
			      double reach, ContactList<2>& list)
{
	followBodies(first, second, list.candidates);
	renewCandidates(first, second, reach, list);
	const double way = list.candidates.approached;
	for (ContactCandidates<2>::Node& node : list.candidates.nodes) {
		if (node.clearance - way >= reach) continue;
		++list.tested;
		const ContactBody<2>& body = node.side == 0 ? first : second;
		const ContactBody<2>& other = node.side == 0 ? second : first;
		const Vec<2>& x = body.position[node.node];
		const auto place = followOutline(x, other, node.facet);
		node.facet = place.facet;
		const OutlineCurve curve(other, place.facet);
		double gap = leastGap(x, other, curve, place);
		if (gap < reach) {
			Contact<2> contact;
			measureGap(x, curve, place, contact);
			gap = contact.gap;
			if (gap < reach)
				append({ node.side, node.node, -1 }, contact, body, other, list);
		}
		node.clearance = gap + way;
	}
}

} // namespace softgrain
