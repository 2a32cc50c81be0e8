#include "contact/OutlineSearch.hpp"
#include "contact/Facets.hpp"
#include "contact/OutlineCurve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace softgrain {

template <int dim> double contactDepth(const ContactBody<dim>& a, const ContactBody<dim>& b)
{
	constexpr double deepestContact = 1.5; // in dr
	return deepestContact * std::max(a.pointSpacing, b.pointSpacing);
}

namespace {

template <int dim> struct PlaceOnOutline {
	int facet = -1;
	std::array<double, dim> weight {};
	double squaredDistance = std::numeric_limits<double>::infinity();
};

/// A facet and a ball that holds it.
template <int dim> struct FacetNear {
	int facet;
	Vec<dim> centre;
	double radius;
};

/// Nearest place to `x` on those of the facets of `body` that `admissible` lets pass.
template <int dim, class Admissible>
PlaceOnOutline<dim> nearestPlace(const Vec<dim>& x, const ContactBody<dim>& body,
				 const std::vector<FacetNear<dim>>& facets, Admissible&& admissible)
{
	PlaceOnOutline<dim> best;
	double distance = std::numeric_limits<double>::infinity();
	for (const FacetNear<dim>& f : facets) {
		const double farthest = distance + f.radius;
		if ((x - f.centre).squaredNorm() > farthest * farthest) continue;
		if (!admissible(f.facet)) continue;
		std::array<Vec<dim>, dim> corner;
		for (int i = 0; i < dim; ++i)
			corner[i] = body.position[body.mesh->facet[f.facet][i]];
		const auto weight = nearestOnFacet(x, corner);
		Vec<dim> nearest = Vec<dim>::Zero();
		for (int i = 0; i < dim; ++i)
			nearest += weight[i] * corner[i];
		const double squared = (x - nearest).squaredNorm();
		if (squared >= best.squaredDistance) continue;
		best = { f.facet, weight, squared };
		distance = std::sqrt(squared);
	}
	return best;
}

/// The nearest place of all is wanted.
constexpr auto anyFacet = [](int) { return true; };

/// Gap and normal at a place on a 2D outline: of the smooth curve over the facet. What leans on the
/// curve moves and pushes its nodes with the curve's own weights.
void measureGap(const Vec<2>& x, const OutlineCurve& curve, const PlaceOnOutline<2>& place,
		Contact<2>& contact)
{
	const OutlineCurve::Place foot = curve.nearest(x, place.weight[1]);
	contact.partners = mostPartners<2>;
	contact.facet = place.facet;
	contact.partner = curve.nodes();
	contact.weight = curve.weights(foot.t);
	contact.normal = Vec<2>(foot.tangent[1], -foot.tangent[0]).normalized();
	contact.gap = (x - foot.position).dot(contact.normal);
}

void measureGap(const Vec<2>& x, const ContactBody<2>& body, const PlaceOnOutline<2>& place,
		Contact<2>& contact)
{
	measureGap(x, OutlineCurve(body, place.facet), place, contact);
}

/// The same in 3D: between its vertices the outline bulges over the flat facet by
/// 1/2 sum_(i<j) w_i w_j (n_j - n_i).(x_j - x_i), which is the arc through the vertices to second
/// order.
void measureGap(const Vec<3>& x, const ContactBody<3>& body, const PlaceOnOutline<3>& place,
		Contact<3>& contact)
{
	const auto& vertex = body.mesh->facet[place.facet];
	Vec<3> foot = Vec<3>::Zero(), normal = Vec<3>::Zero();
	double bulge = 0;
	for (int i = 0; i < 3; ++i) {
		foot += place.weight[i] * body.position[vertex[i]];
		normal += place.weight[i] * body.normalAt(place.facet, vertex[i]);
		for (int j = 0; j < i; ++j)
			bulge += 0.5 * place.weight[i] * place.weight[j] *
				 (body.normalAt(place.facet, vertex[j]) -
				  body.normalAt(place.facet, vertex[i]))
					 .dot(body.position[vertex[j]] - body.position[vertex[i]]);
	}
	contact.partners = mostPartners<3>;
	contact.facet = place.facet;
	contact.partner = vertex;
	contact.weight = place.weight;
	contact.normal = normal.normalized();
	contact.gap = (x - foot).dot(contact.normal) - bulge;
}

/// The facet over which the curve is nearest to a far place: it may be next to the nearest facet.
int facetBelow(const Vec<2>& x, const ContactBody<2>& body, int facet)
{
	const int count = static_cast<int>(body.mesh->facet.size());
	auto ahead = [&](int f, double end) {
		const OutlineCurve::Place place = OutlineCurve(body, f).at(end);
		return (x - place.position).dot(place.tangent);
	};
	const auto [first, last] = body.mesh->facet[facet];
	if (!body.isSharp(first) && ahead(facet, 0) < 0) return (facet + count - 1) % count;
	if (!body.isSharp(last) && ahead(facet, 1) > 0) return (facet + 1) % count;
	return facet;
}

/// The curve's place nearest to the centre of a ball, which may be far from it.
void leanOnOutline(const Vec<2>& centre, const ContactBody<2>& body, const PlaceOnOutline<2>& place,
		   Contact<2>& contact)
{
	contact.facet = facetBelow(centre, body, place.facet);
	const OutlineCurve curve(body, contact.facet);
	const OutlineCurve::Place foot = curve.nearestToFar(centre);
	contact.partners = mostPartners<2>;
	contact.partner = curve.nodes();
	contact.weight = curve.weights(foot.t);
	contact.normal = Vec<2>(foot.tangent[1], -foot.tangent[0]).normalized();
	contact.gap = (centre - foot.position).dot(contact.normal);
	const Vec<2> apart = centre - foot.position; // at the end of the curve not along its normal
	if (contact.gap <= 0) return;
	contact.gap = apart.norm();
	contact.normal = apart / contact.gap;
}

/// In 3D the place on the flat facet stands for that on the outline; the arc over it lifts it.
void leanOnOutline(const Vec<3>& centre, const ContactBody<3>& body, const PlaceOnOutline<3>& place,
		   Contact<3>& contact)
{
	measureGap(centre, body, place, contact);
	Vec<3> foot = Vec<3>::Zero();
	for (int i = 0; i < 3; ++i)
		foot += contact.weight[i] * body.position[contact.partner[i]];
	const Vec<3> apart = centre - foot;
	const double height = apart.dot(contact.normal);
	if (height <= 0) return; // the centre is inside
	const double bulge = height - contact.gap;
	contact.normal = apart.normalized();
	contact.gap = apart.norm() - bulge;
}

/// Whether the outline is indented at a corner: what lies beyond the ends of both sides is inside.
bool isIndented(const ContactBody<2>& body, int corner)
{
	const auto& side = body.mesh->sharp.at(corner);
	const Vec<2> in = body.areaOfFacet(side[0]), out = body.areaOfFacet(side[1]);
	return in[0] * out[1] < in[1] * out[0];
}

/// In 3D there are blocks only.
bool isIndented(const ContactBody<3>&, int) { return false; }

/// Whether the place nearest to `x` is a sharp edge or corner of the outline with `x` beyond the
/// end of the facet: no facet lies under `x` then, and the distance to the edge is the gap,
/// negative below an indentation.
template <int dim>
bool isBeyondEdge(const Vec<dim>& x, const ContactBody<dim>& body, const PlaceOnOutline<dim>& place,
		  Contact<dim>& contact)
{
	Vec<dim> foot = Vec<dim>::Zero();
	bool indented = false;
	for (int i = 0; i < dim; ++i) {
		const int vertex = body.mesh->facet[place.facet][i];
		foot += place.weight[i] * body.position[vertex];
		if (!(place.weight[i] > 0)) continue;
		if (!body.isSharp(vertex)) return false;
		indented = indented || isIndented(body, vertex);
	}
	const Vec<dim> apart = x - foot;
	const Vec<dim> normal = body.areaOfFacet(place.facet).normalized();
	if ((apart - apart.dot(normal) * normal).norm() < 1e-9 * body.pointSpacing) return false;
	const double sign = indented && body.encloses(x) ? -1 : 1;
	contact.normal = sign * apart.normalized();
	contact.gap = sign * apart.norm();
	return true;
}

/// Facets that may reach into a region, in their order.
template <int dim>
std::vector<FacetNear<dim>> facetsIn(const ContactBody<dim>& body, const Box<dim>& region)
{
	const Box<dim> around = region.grown(body.longestEdge);
	std::vector<FacetNear<dim>> found;
	for (std::size_t f = 0; f < body.mesh->facet.size(); ++f) {
		const auto& vertex = body.mesh->facet[f];
		if (!around.contains(body.position[vertex[0]])) continue;
		FacetNear<dim> near { static_cast<int>(f), Vec<dim>::Zero(), 0 };
		for (int i : vertex)
			near.centre += body.position[i] / dim;
		for (int i : vertex)
			near.radius =
				std::max(near.radius, (body.position[i] - near.centre).norm());
		found.push_back(near);
	}
	return found;
}

/// Nodes of `body` that may be inside `other` or within reach of it.
template <int dim>
std::vector<int> nodesNear(const ContactBody<dim>& body, const ContactBody<dim>& other,
			   double reach, double margin)
{
	std::vector<int> found = body.nodesIn(other.box.grown(margin));
	// The ball is the tighter of the two for round grains. The outline bulges out of its facets
	// by less than an eighth of the longest edge (3D: 0.29 of it).
	const double radius = other.circumradius + reach + 0.3 * other.longestEdge;
	const Vec<dim> centre = other.box.centre();
	std::erase_if(found, [&](int s) {
		return (body.position[s] - centre).squaredNorm() > radius * radius;
	});
	return found;
}

/// A contact; what lies deeper is none, but is known by its depth.
template <int dim>
void append(const ContactKey& key, Contact<dim>& contact, const ContactBody<dim>& body,
	    const ContactBody<dim>& other, ContactList<dim>& list)
{
	list.noteOverlap(contact.gap, 0.5 * (body.pointSpacing + other.pointSpacing));
	if (contact.gap < -contactDepth(body, other)) return;
	contact.key = key;
	list.contacts.push_back(contact);
}

/// The contact of a node with a place on an outline, but for its key.
template <int dim>
Contact<dim> contactAt(const Vec<dim>& x, const ContactBody<dim>& other,
		       const PlaceOnOutline<dim>& place)
{
	Contact<dim> contact;
	measureGap(x, other, place, contact);
	return contact;
}

/// Calls `use(node, facets)` for the nodes of `body` that may be within reach of the outline of
/// `other`, with the facets that may be the nearest.
template <int dim, class Use>
void forNodesNear(const ContactBody<dim>& body, const ContactBody<dim>& other, double reach,
		  ContactList<dim>& list, Use&& use)
{
	// The outline bulges out of the box of its vertices, and the facet nearest to a node that
	// overlaps may lie outside the common region: both by less than a contact depth.
	const double margin = std::max(reach, contactDepth(body, other));
	const auto nodes = nodesNear(body, other, reach, margin);
	if (nodes.empty()) return;
	const auto facets = facetsIn(other, body.box.grown(margin));
	if (facets.empty()) return;
	list.tested += static_cast<int>(nodes.size());
	for (int s : nodes)
		use(s, facets);
}

/// Whether a place outside of a grain lies before a facet, not behind it on the far side of a thin
/// arm.
bool isBefore(const Vec<2>& x, const ContactBody<2>& body, int facet)
{
	const Vec<2>& start = body.position[body.mesh->facet[facet][0]];
	return (x - start).dot(body.areaOfFacet(facet).normalized()) >=
	       -OutlineCurve(body, facet).bulge();
}

/// In 3D no grain has thin arms.
bool isBefore(const Vec<3>&, const ContactBody<3>&, int) { return true; }

/// Nodes of `body` against the outline of `other`, where one of them has corners or indentations.
template <int dim>
void nodesFacingOutline(const ContactBody<dim>& body, const ContactBody<dim>& other, int side,
			double reach, ContactList<dim>& list)
{
	const double deep = contactDepth(body, other);
	// Near a corner or in a notch the nearest facet need not be the one that a node lies
	// against: there only facets count that the node faces. One that is outside must be before
	// them, not behind the far side of a thin arm.
	forNodesNear(body, other, reach, list, [&](int s, const auto& facets) {
		const Vec<dim>& x = body.position[s];
		const bool mayBeInside = !other.mesh->irregular || other.encloses(x);
		PlaceOnOutline<dim> place = nearestPlace(x, other, facets, [&](int f) {
			return body.facesAgainst(s, other.areaOfFacet(f).normalized()) &&
			       (mayBeInside || isBefore(x, other, f));
		});
		// None near: the node lies against no side of the grain, but it may be inside.
		const bool faces = place.squaredDistance <= deep * deep;
		if (!faces && !mayBeInside) return;
		if (!faces) place = nearestPlace(x, other, facets, anyFacet);
		Contact<dim> contact = contactAt(x, other, place);
		if (isBeyondEdge(x, other, place, contact) && !body.facesAgainst(s, contact.normal))
			return;
		if (contact.gap < (faces ? reach : -deep))
			append({ side, s, -1 }, contact, body, other, list);
	});
}

template <int dim>
void nodesAgainstOutline(const ContactBody<dim>& body, const ContactBody<dim>& other, int side,
			 double reach, ContactList<dim>& list)
{
	forNodesNear(body, other, reach, list, [&](int s, const auto& facets) {
		const Vec<dim>& x = body.position[s];
		Contact<dim> contact =
			contactAt(x, other, nearestPlace(x, other, facets, anyFacet));
		if (contact.gap < reach) append({ side, s, -1 }, contact, body, other, list);
	});
}

/// Candidates are looked for this far beyond the reach, in dr: much less makes them short-lived,
/// much more makes too many.
constexpr double candidateMargin = 0.3;

/// How far a node and a place on the other outline may have come towards each other: such a place
/// moves by no more than 1.25 times the most that a node does (sum of the sizes of the weights of
/// OutlineCurve).
double approached(double travelled) { return 1.25 * travelled; }

template <int dim>
void findCandidates(const ContactBody<dim>& body, const ContactBody<dim>& other, int side,
		    ContactList<dim>& list)
{
	ContactCandidates& candidates = list.candidates;
	forNodesNear(body, other, candidates.covered, list, [&](int s, const auto& facets) {
		const Vec<dim>& x = body.position[s];
		const auto place = nearestPlace(x, other, facets, anyFacet);
		const double gap = contactAt(x, other, place).gap;
		if (gap < candidates.covered)
			candidates.nodes.push_back(
				{ side, s, place.facet, gap + approached(candidates.travelled) });
	});
}

template <int dim>
void renewCandidates(const ContactBody<dim>& first, const ContactBody<dim>& second, double reach,
		     ContactList<dim>& list)
{
	ContactCandidates& candidates = list.candidates;
	const double travelled = first.travelled + second.travelled;
	const double since = travelled - candidates.travelled; // negative: of other bodies
	if (since >= 0 && reach + approached(since) <= candidates.covered) return;
	candidates.nodes.clear();
	candidates.covered =
		reach + candidateMargin * std::min(first.pointSpacing, second.pointSpacing);
	candidates.travelled = travelled;
	findCandidates(first, second, 0, list);
	findCandidates(second, first, 1, list);
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

void contactsOfCandidates(const ContactBody<2>& first, const ContactBody<2>& second, double reach,
			  ContactList<2>& list)
{
	const double way = approached(first.travelled + second.travelled);
	for (ContactCandidates::Node& node : list.candidates.nodes) {
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

} // namespace

template <int dim>
void findOutlineContacts(const ContactBody<dim>& first, const ContactBody<dim>& second,
			 double reach, ContactList<dim>& list)
{
	const bool corners = !first.mesh->sharp.empty() || !second.mesh->sharp.empty();
	const bool irregular = first.mesh->irregular || second.mesh->irregular;
	if (corners || irregular) {
		nodesFacingOutline(first, second, 0, reach, list);
		nodesFacingOutline(second, first, 1, reach, list);
	} else if constexpr (dim == 2) {
		renewCandidates(first, second, reach, list);
		contactsOfCandidates(first, second, reach, list);
	} else {
		nodesAgainstOutline(first, second, 0, reach, list);
		nodesAgainstOutline(second, first, 1, reach, list);
	}
}

template <int dim>
std::optional<Contact<dim>> ballOnOutline(const Vec<dim>& centre, double radius,
					  const ContactBody<dim>& body, double reach)
{
	const double margin = radius + std::max(reach, contactDepth(body, body));
	if (!body.box.grown(margin).contains(centre)) return std::nullopt;
	const auto facets = facetsIn(body, Box<dim> { centre, centre }.grown(margin));
	if (facets.empty()) return std::nullopt;
	const PlaceOnOutline<dim> place = nearestPlace(centre, body, facets, anyFacet);
	Contact<dim> contact;
	if (radius > 0)
		leanOnOutline(centre, body, place, contact);
	else {
		measureGap(centre, body, place, contact);
		isBeyondEdge(centre, body, place, contact);
	}
	contact.gap -= radius;
	if (contact.gap >= reach) return std::nullopt;
	return contact;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::optional<Contact<dim>> ballOnOutline<dim>(const Vec<dim>&, double,           \
								const ContactBody<dim>&, double);  \
	template double contactDepth<dim>(const ContactBody<dim>&, const ContactBody<dim>&);       \
	template void findOutlineContacts<dim>(const ContactBody<dim>&, const ContactBody<dim>&,   \
					       double, ContactList<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
