#include "contact/CandidateSearch.hpp"
#include "contact/NodesInLanes.hpp"
#include "contact/PlaceOnOutline.hpp"

namespace softgrain {

namespace {

/// Candidates are looked for this far beyond the reach, in dr: much less makes them short-lived,
/// much more makes too many.
constexpr double candidateMargin = 0.5;

/// A place on an outline moves by no more than so many times what its nodes do (sum of the sizes of
/// the weights of OutlineCurve).
constexpr double wayOfPlaces = 1.25;

/// Deeper overlaps, in dr, are looked at: before the tip of a fold, as outlines have them about
/// pores that have almost closed, a node may lie behind the line of the flank that is nearest.
constexpr double trustedOverlap = 0.05;

/// Takes in how far nodes and places on the other outline may have come towards each other since
/// the last search.
template <int dim>
void followBodies(const ContactBody<dim>& first, const ContactBody<dim>& second,
		  ContactCandidates<dim>& candidates)
{
	const Vec<dim> apart = first.carried - second.carried;
	const double travelled = first.travelled + second.travelled;
	if (travelled < candidates.travelled) candidates = {}; // those of other bodies
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

/// Measures the candidates that may be within reach, some at a time.
class CandidatesInLanes {
public:
	CandidatesInLanes(NodesInLanes& lanes, const ContactBody<2>& first,
			  const ContactBody<2>& second, double reach, ContactList<2>& list)
		: lanes_(lanes)
		, body_ { &first, &second }
		, reach_(reach)
		, list_(list)
	{
		lanes_.clear();
	}

	void add(ContactCandidates<2>::Node& node)
	{
		const Vec<2>& x = own(node).position[node.node];
		const auto place = followOutline(x, other(node), node.facet);
		node.facet = place.facet;
		candidate_[lanes_.count()] = &node;
		lanes_.add(x, other(node), place.facet, place.weight[1]);
		if (lanes_.isFull()) measure();
	}
	/// Those that are left.
	void measure()
	{
		if (lanes_.count() == 0) return;
		lanes_.measure();
		for (int lane = 0; lane < lanes_.count(); ++lane)
			take(lane);
		list_.tested += lanes_.count();
		lanes_.clear();
	}

private:
	using Node = ContactCandidates<2>::Node;

	/// Whether a node that counts as deep is outside all the same.
	bool isBeforeFold(const Node& node, double gap) const
	{
		return gap < -trustedOverlap * other(node).pointSpacing &&
		       !other(node).encloses(own(node).position[node.node]);
	}

	const ContactBody<2>& own(const Node& node) const { return *body_[node.side]; }
	const ContactBody<2>& other(const Node& node) const { return *body_[1 - node.side]; }

	void take(int lane)
	{
		Node& node = *candidate_[lane];
		node.clearance = lanes_.gap(lane) + list_.candidates.approached;
		if (lanes_.gap(lane) >= reach_ || isBeforeFold(node, lanes_.gap(lane))) return;
		if (auto* contact = append({ node.side, node.node, -1 }, lanes_.gap(lane),
					   own(node), other(node), list_))
			lanes_.write(lane, *contact);
	}

	NodesInLanes& lanes_;
	std::array<Node*, laneWidth> candidate_;
	std::array<const ContactBody<2>*, 2> body_;
	double reach_;
	ContactList<2>& list_;
};

} // namespace

void findContactsOfCandidates(const ContactBody<2>& first, const ContactBody<2>& second,
			      double reach, ContactList<2>& list)
{
	followBodies(first, second, list.candidates);
	renewCandidates(first, second, reach, list);
	if (list.candidates.nodes.empty()) return;
	thread_local NodesInLanes lanes; // to make them anew for each pair takes a tenth of it
	CandidatesInLanes near(lanes, first, second, reach, list);
	for (ContactCandidates<2>::Node& node : list.candidates.nodes)
		if (node.clearance - list.candidates.approached < reach) near.add(node);
	near.measure();
}

} // namespace softgrain
