#include "contact/OutlineSearch.hpp"
#include "contact/CandidateSearch.hpp"
#include "contact/PlaceOnOutline.hpp"

#include <algorithm>
#include <optional>

namespace softgrain {

template <int dim> double contactDepth(const ContactOutline<dim>& a, const ContactOutline<dim>& b)
{
	constexpr double deepestContact = 1.5; // in dr
	return deepestContact * std::max(a.pointSpacing, b.pointSpacing);
}

namespace {

/// The facet over which the curve is nearest to a far place: it may be next to the nearest facet.
int facetBelow(const Vec<2>& x, const ContactOutline<2>& body, int facet)
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

/// Whether the centre of a ball behind the nearest facet is in the grain. (About a corner that is
/// squeezed hard the outline may be folded, and a facet face inwards.)
template <int dim>
bool isInside(const Vec<dim>& centre, const ContactOutline<dim>& body, const Vec<dim>& fromOutline)
{
	return fromOutline.isZero(0) || body.encloses(centre);
}

/// The curve's place nearest to the centre of a ball, which may be far from it.
void leanOnOutline(const Vec<2>& centre, const ContactOutline<2>& body,
		   const PlaceOnOutline<2>& place, Contact<2>& contact)
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
	if (contact.gap <= 0 && isInside(centre, body, apart)) return;
	contact.gap = apart.norm();
	contact.normal = apart / contact.gap;
}

/// In 3D the place on the flat facet stands for that on the outline; the arc over it lifts it.
void leanOnOutline(const Vec<3>& centre, const ContactOutline<3>& body,
		   const PlaceOnOutline<3>& place, Contact<3>& contact)
{
	measureGap(centre, body, place, contact);
	Vec<3> foot = Vec<3>::Zero();
	for (int i = 0; i < 3; ++i)
		foot += contact.weight[i] * body.position[contact.partner[i]];
	const Vec<3> apart = centre - foot;
	const double height = apart.dot(contact.normal);
	if (height <= 0 && isInside(centre, body, apart)) return;
	const double bulge = height - contact.gap;
	contact.normal = apart.normalized();
	contact.gap = apart.norm() - bulge;
}

/// Whether the outline is indented at a corner: what lies beyond the ends of both sides is inside.
bool isIndented(const ContactOutline<2>& body, int corner)
{
	const auto& side = body.mesh->sharp.at(corner);
	const Vec<2> in = body.areaOfFacet(side[0]), out = body.areaOfFacet(side[1]);
	return cross(in, out) < 0;
}

/// In 3D there are blocks only.
bool isIndented(const ContactOutline<3>&, int) { return false; }

/// What is beyond an edge by less, in dr, lies over the facet still. Of a node, which is held
/// against facets that it faces only: where two edges lie upon each other the direction from one to
/// the other is that of rounding. In a notch, and of the tip of a rigid body, only where there is
/// no direction.
constexpr double edgeWidth = 0.05, noWidth = 1e-9;

/// Whether the place nearest to `x` is a sharp edge or corner of the outline with `x` beyond the
/// end of the facet: no facet lies under `x` then, and the distance to the edge is the gap,
/// negative below an indentation. `width`: of the edge, in dr.
template <int dim>
bool isBeyondEdge(const Vec<dim>& x, const ContactOutline<dim>& body,
		  const PlaceOnOutline<dim>& place, double width, Contact<dim>& contact)
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
	const Vec<dim> normal = body.normalOfFacet(place.facet);
	const double beyond = (apart - apart.dot(normal) * normal).norm();
	if (beyond < (indented ? noWidth : width) * body.pointSpacing) return false;
	const double sign = indented && body.encloses(x) ? -1 : 1;
	contact.normal = sign * apart.normalized();
	contact.gap = sign * apart.norm();
	return true;
}

/// Whether a place outside of a grain lies before a facet, not behind it on the far side of a thin
/// arm.
bool isBefore(const Vec<2>& x, const ContactOutline<2>& body, int facet)
{
	const Vec<2>& start = body.position[body.mesh->facet[facet][0]];
	return (x - start).dot(body.normalOfFacet(facet)) >= -OutlineCurve(body, facet).bulge();
}

/// In 3D no grain has thin arms.
bool isBefore(const Vec<3>&, const ContactOutline<3>&, int) { return true; }

/// The shares that the nodes of a place have of what leans on it, without those beside the facet.
void setShares(const PlaceOnOutline<2>& place, Contact<2>& contact)
{
	contact.weight = { 0, place.weight[0], place.weight[1], 0 }; // carriers
}
void setShares(const PlaceOnOutline<3>& place, Contact<3>& contact)
{
	contact.weight = place.weight;
}

/// What is well inside and nearest to where facets join goes out there: where the outline turns
/// back on itself, as about the edge of a plate that stands in the grain, the arcs over them have
/// no use. (Less deep the way out has no direction: in a dent it would be another one in every
/// step.)
template <int dim>
void goOutAtJoint(const Vec<dim>& x, const ContactOutline<dim>& body,
		  const PlaceOnOutline<dim>& place, Contact<dim>& contact)
{
	Vec<dim> foot = Vec<dim>::Zero();
	for (int i = 0; i < dim; ++i) {
		const int node = body.mesh->facet[place.facet][i];
		if (place.weight[i] > 0 && body.isSharp(node)) return;
		foot += place.weight[i] * body.position[node];
	}
	const bool isAtJoint = *std::min_element(place.weight.begin(), place.weight.end()) <= 0;
	const double depth = (foot - x).norm();
	constexpr double certain = 0.05; // in dr
	if (!isAtJoint || depth < certain * body.pointSpacing || !body.encloses(x)) return;
	setShares(place, contact);
	contact.normal = (foot - x) / depth;
	contact.gap = -depth;
}

/// Deeper nodes, in dr, are looked at once more: whether they are inside at all. Bent sides feign 1
/// to 2; what is pressed in stays far below, and need not be looked at.
constexpr double trustedDepth = 0.5;

/// A place on a facet that counts for a search from the beginning: most nodes lie against a facet
/// near that of the node before.
template <int dim, class Admissible>
PlaceOnOutline<dim> startAt(const Vec<dim>& x, const ContactOutline<dim>& body, int facet,
			    Admissible&& admissible, const PlaceOnOutline<dim>& start)
{
	if (facet < 0 || !admissible(facet)) return start;
	const PlaceOnOutline<dim> place = placeOnFacet(x, body, facet);
	return comesBefore(place, start) ? place : start;
}

/// Nodes of `body` against the outline of `other`, where one of them has corners or indentations.
template <int dim>
void nodesFacingOutline(const ContactOutline<dim>& body, const ContactOutline<dim>& other, int side,
			double reach, ContactList<dim>& list)
{
	const double deep = contactDepth(body, other);
	const double shallow = std::max(deep - other.bulge(), 0.); // nothing so near is deep
	const bool irregular = other.mesh->irregular;
	PlaceOnOutline<dim> within; // what is farther counts as no facing facet
	within.squaredDistance = deep * deep;
	int last = -1;
	// Near a corner or in a notch the nearest facet need not be the one that a node lies
	// against: there only facets count that the node faces. One that is outside must be before
	// them, not behind the far side of a thin arm.
	forNodesNear(body, other, reach, list, [&](int s, const auto& facets) {
		const Vec<dim>& x = body.position[s];
		const NodeFacing<dim> facing(body, s);
		std::optional<bool> enclosed; // once it is asked for
		auto mayBeInside = [&] {
			if (!enclosed) enclosed = !irregular || other.encloses(x);
			return *enclosed;
		};
		auto bears = [&](int f) {
			return facing.isAgainst(other.normalOfFacet(f)) &&
			       ((irregular && isBefore(x, other, f)) || mayBeInside());
		};
		PlaceOnOutline<dim> place = nearestPlace(x, other, facets, bears,
							 startAt(x, other, last, bears, within));
		// None near: the node lies against no side of the grain, but it may be inside.
		const bool faces = place.facet >= 0;
		if (!faces) {
			if (!mayBeInside()) return;
			place = startAt(x, other, last, anyFacet, {});
			if (place.squaredDistance < shallow * shallow) return;
			place = nearestPlace(x, other, facets, anyFacet, place);
		}
		last = place.facet;
		Contact<dim> contact = contactAt(x, other, place);
		if (isBeyondEdge(x, other, place, edgeWidth, contact) &&
		    !facing.isAgainst(contact.normal))
			return;
		if (contact.gap >= (faces ? reach : -deep)) return;
		// behind the line of a side that has been bent, and outside all the same
		const bool doubtful = contact.gap < -trustedDepth * other.pointSpacing;
		if (doubtful && !irregular && !other.encloses(x)) return;
		append({ side, s, -1 }, contact, body, other, list);
	});
}

} // namespace

template <int dim>
void findOutlineContacts(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
			 double reach, ContactList<dim>& list)
{
	const bool corners = !first.mesh->sharp.empty() || !second.mesh->sharp.empty();
	const bool irregular = first.mesh->irregular || second.mesh->irregular;
	if (corners || irregular) {
		nodesFacingOutline(first, second, 0, reach, list);
		nodesFacingOutline(second, first, 1, reach, list);
	} else
		findContactsOfCandidates(first, second, reach, list);
}

template <int dim>
std::optional<Contact<dim>> ballOnOutline(const Vec<dim>& centre, double radius,
					  const ContactOutline<dim>& body, double reach)
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
		goOutAtJoint(centre, body, place, contact);
	}
	isBeyondEdge(centre, body, place, noWidth, contact);
	contact.gap -= radius;
	if (contact.gap >= reach) return std::nullopt;
	return contact;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::optional<Contact<dim>> ballOnOutline<dim>(                                   \
		const Vec<dim>&, double, const ContactOutline<dim>&, double);                      \
	template double contactDepth<dim>(const ContactOutline<dim>&, const ContactOutline<dim>&); \
	template void findOutlineContacts<dim>(const ContactOutline<dim>&,                         \
					       const ContactOutline<dim>&, double,                 \
					       ContactList<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
