#include "contact/search/BallOnOutline.hpp"
#include "contact/search/OutlineEdges.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <algorithm>

namespace softgrain {

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

} // namespace

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

template std::optional<Contact<2>> ballOnOutline<2>(const Vec<2>&, double, const ContactOutline<2>&,
						    double);
template std::optional<Contact<3>> ballOnOutline<3>(const Vec<3>&, double, const ContactOutline<3>&,
						    double);

} // namespace softgrain
