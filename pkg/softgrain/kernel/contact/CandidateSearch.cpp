#include "contact/CandidateSearch.hpp"
#include "contact/NodesInLanes.hpp"
#include "contact/PlaceOnOutline.hpp"

#include <optional>

namespace softgrain {

namespace {

/// Candidates are looked for this far beyond the reach, in dr: much less makes them short-lived,
/// much more makes too many.
constexpr double candidateMargin = 0.5;

template <int dim>
double finerSpacing(const ContactBody<dim>& first, const ContactBody<dim>& second)
{
	return std::min(first.pointSpacing, second.pointSpacing);
}

/// Gaps up to this make candidates, m.
template <int dim>
double candidateReach(const ContactBody<dim>& first, const ContactBody<dim>& second, double reach)
{
	return reach + candidateMargin * finerSpacing(first, second);
}

/// A gap within reach changes by no more than so many times the ways of nodes. 2D: the sum of the
/// sizes of the weights of OutlineCurve. 3D: 1 for the flat facet, a third for the bulge over it
/// (the normals at its corners turn), the rest since normals are those of the arc, which turn more
/// the farther a node is off: 1.4 for balls, 2.0 for creased ones, half a dr off
/// (doc/decisions/0028-search.md).
double wayOfPlaces(const ContactBody<2>&, const ContactBody<2>&, double) { return 1.25; }
double wayOfPlaces(const ContactBody<3>& first, const ContactBody<3>& second, double reach)
{
	return 2 + reach / finerSpacing(first, second);
}

/// The same of the way of all nodes together.
template <int dim> constexpr double wayOfBodies = dim == 2 ? 1 : 1.05;

/// By how much, in dr, a gap may jump where the nearest place goes over to another facet. (In 2D it
/// is the distance to a smooth curve; in 3D normals are those of the arc, the nearest place is that
/// on the flat facets.)
template <int dim> constexpr double jumpOfGaps = dim == 2 ? 0 : 0.1;

template <int dim> double jumpBetween(const ContactBody<dim>& first, const ContactBody<dim>& second)
{
	return jumpOfGaps<dim> * finerSpacing(first, second);
}

/// Deeper overlaps, in dr, are looked at: before the tip of a fold, as outlines have them about
/// pores that have almost closed, a node may lie behind the line of the flank that is nearest.
constexpr double trustedOverlap = 0.05;

/// Takes in how far nodes and places on the other outline may have come towards each other since
/// the last search.
template <int dim>
void followBodies(const ContactBody<dim>& first, const ContactBody<dim>& second, double reach,
		  ContactCandidates<dim>& candidates)
{
	const Vec<dim> apart = first.carried - second.carried;
	const double travelled = first.travelled + second.travelled;
	if (travelled < candidates.travelled) candidates = {}; // those of other bodies
	candidates.approached +=
		wayOfBodies<dim> * (apart - candidates.apart).norm() +
		wayOfPlaces(first, second, reach) * (travelled - candidates.travelled);
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
				{ side, s, place.facet,
				  gap - jumpBetween(body, other) + candidates.approached });
	});
}

template <int dim>
void renewCandidates(const ContactBody<dim>& first, const ContactBody<dim>& second, double reach,
		     ContactList<dim>& list)
{
	ContactCandidates<dim>& candidates = list.candidates;
	if (reach + candidates.approached <= candidates.covered) return;
	const double within = candidateReach(first, second, reach);
	candidates.clear();
	candidates.covered = within - jumpBetween(first, second) + candidates.approached;
	findCandidates(first, second, 0, within, list);
	findCandidates(second, first, 1, within, list);
}

/// A place on a facet, its share of the way along it.
struct PlaceAlong {
	int facet;
	double t;
};

/// The place on a facet nearest to `x` if it is not an end, and of both facets beside it no place
/// but the common end is near.
std::optional<PlaceAlong> placeBeneath(const Vec<2>& x, const ContactBody<2>& body, int facet)
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
PlaceAlong followOutline(const Vec<2>& x, const ContactBody<2>& body, int facet)
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
		lanes_.add(x, other(node), place.facet, place.t);
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

/// Calls `use` for the candidates that may be within reach.
template <int dim, class Use>
void forCandidates(double reach, ContactCandidates<dim>& candidates, Use&& use)
{
	for (auto& node : candidates.nodes)
		if (node.clearance - candidates.approached < reach) use(node);
}

void measureCandidates(const ContactBody<2>& first, const ContactBody<2>& second, double reach,
		       ContactList<2>& list)
{
	thread_local NodesInLanes lanes; // to make them anew for each pair takes a tenth of it
	CandidatesInLanes near(lanes, first, second, reach, list);
	forCandidates(reach, list.candidates, [&](auto& node) { near.add(node); });
	near.measure();
}

/// Of the candidates of a side. Facets within `within` now are all that can be the nearest until
/// candidates are renewed: until then reach + approached stays below what is covered.
std::vector<FacetNear<3>> facetsOfCandidates(const ContactBody<3>& body,
					     const ContactBody<3>& other, double within,
					     std::vector<int>& kept)
{
	std::vector<FacetNear<3>> facets;
	if (kept.empty()) {
		facets = facetsNear(body, other, within);
		for (const FacetNear<3>& facet : facets)
			kept.push_back(facet.facet);
	} else
		for (int facet : kept)
			facets.push_back(ballAbout(other, facet));
	return facets;
}

/// One by one, each against all facets that may be nearer than that which it had.
void measureCandidates(const ContactBody<3>& first, const ContactBody<3>& second, double reach,
		       ContactList<3>& list)
{
	const std::array<const ContactBody<3>*, 2> body { &first, &second };
	std::array<std::optional<std::vector<FacetNear<3>>>, 2> facets; // by side of the node
	const double within =
		candidateReach(first, second, list.candidates.covered - list.candidates.approached);
	forCandidates(reach, list.candidates, [&](auto& node) {
		const ContactBody<3>&own = *body[node.side], &other = *body[1 - node.side];
		auto& near = facets[node.side];
		if (!near)
			near = facetsOfCandidates(own, other, within,
						  list.candidates.facets[node.side]);
		const Vec<3>& x = own.position[node.node];
		const auto place =
			nearestPlace(x, other, *near, anyFacet, placeOnFacet(x, other, node.facet));
		const Contact<3> contact = contactAt(x, other, place);
		++list.tested;
		node.facet = place.facet;
		node.clearance = contact.gap - jumpBetween(own, other) + list.candidates.approached;
		if (contact.gap < reach)
			append({ node.side, node.node, -1 }, contact, own, other, list);
	});
}

} // namespace

template <int dim>
void findContactsOfCandidates(const ContactBody<dim>& first, const ContactBody<dim>& second,
			      double reach, ContactList<dim>& list)
{
	followBodies(first, second, reach, list.candidates);
	renewCandidates(first, second, reach, list);
	if (!list.candidates.nodes.empty()) measureCandidates(first, second, reach, list);
}

template void findContactsOfCandidates<2>(const ContactBody<2>&, const ContactBody<2>&, double,
					  ContactList<2>&);
template void findContactsOfCandidates<3>(const ContactBody<3>&, const ContactBody<3>&, double,
					  ContactList<3>&);

} // namespace softgrain
