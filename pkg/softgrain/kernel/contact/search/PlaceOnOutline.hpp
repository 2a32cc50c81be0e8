// The place of an outline that a node lies against: what the searches of outlines have in common.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"
#include "contact/Facets.hpp"
#include "contact/search/FacetBalls.hpp"
#include "contact/search/OutlineCurve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace softgrain {

template <int dim> struct PlaceOnOutline {
	int facet = -1;
	std::array<double, dim> weight {};
	double squaredDistance = std::numeric_limits<double>::infinity();
};

/// Nearest place to `x` on a facet of `body`.
template <int dim>
PlaceOnOutline<dim> placeOnFacet(const Vec<dim>& x, const ContactOutline<dim>& body, int facet)
{
	std::array<Vec<dim>, dim> corner;
	for (int i = 0; i < dim; ++i)
		corner[i] = body.position[body.mesh->facet[facet][i]];
	const auto weight = nearestOnFacet(x, corner);
	Vec<dim> nearest = Vec<dim>::Zero();
	for (int i = 0; i < dim; ++i)
		nearest += weight[i] * corner[i];
	return { facet, weight, (x - nearest).squaredNorm() };
}

/// Whether the first place is nearer, or as near, as at a common edge, and the first in order.
template <int dim> bool comesBefore(const PlaceOnOutline<dim>& a, const PlaceOnOutline<dim>& b)
{
	return a.squaredDistance < b.squaredDistance ||
	       (a.squaredDistance == b.squaredDistance && a.facet < b.facet);
}

/// Nearest place to `x` on those of the facets of `body` that `admissible` lets pass. (`start`: a
/// place that counts, too; facets that are farther are not looked at.)
template <int dim, class Admissible>
PlaceOnOutline<dim> nearestPlace(const Vec<dim>& x, const ContactOutline<dim>& body,
				 const FacetBalls<dim>& facets, Admissible&& admissible,
				 const PlaceOnOutline<dim>& start = {})
{
	PlaceOnOutline<dim> best = start;
	double distance = std::sqrt(start.squaredDistance);
	facets.forNear(x, distance, [&](int facet) {
		if (!admissible(facet)) return;
		const PlaceOnOutline<dim> place = placeOnFacet(x, body, facet);
		if (!comesBefore(place, best)) return;
		best = place;
		distance = std::sqrt(place.squaredDistance);
	});
	return best;
}

/// The nearest place of all is wanted.
constexpr auto anyFacet = [](int) { return true; };

/// Gap and normal at a place on a 2D outline: of the smooth curve over the facet. What leans on the
/// curve moves and pushes its nodes with the curve's own weights.
inline void measureGap(const Vec<2>& x, const ContactOutline<2>& body,
		       const PlaceOnOutline<2>& place, Contact<2>& contact)
{
	const OutlineCurve curve(body, place.facet);
	const OutlineCurve::Place foot = curve.nearest(x, place.weight[1]);
	contact.partners = mostPartners<2>;
	contact.facet = place.facet;
	contact.partner = curve.nodes();
	contact.weight = curve.weights(foot.t);
	contact.normal = foot.normal();
	contact.gap = (x - foot.position).dot(contact.normal);
}

/// The same in 3D: between its vertices the outline bulges over the flat facet by
/// 1/2 sum_(i<j) w_i w_j (n_j - n_i).(x_j - x_i), which is the arc through the vertices to second
/// order.
inline void measureGap(const Vec<3>& x, const ContactOutline<3>& body,
		       const PlaceOnOutline<3>& place, Contact<3>& contact)
{
	const auto& vertex = body.mesh->facet[place.facet];
	Vec<3> foot = Vec<3>::Zero(), normal = Vec<3>::Zero();
	double bulge = 0;
	std::array<Vec<3>, 3> at, normalAt;
	for (int i = 0; i < 3; ++i) {
		at[i] = body.position[vertex[i]];
		normalAt[i] = body.normalAt(place.facet, vertex[i]);
		foot += place.weight[i] * at[i];
		normal += place.weight[i] * normalAt[i];
		for (int j = 0; j < i; ++j)
			bulge += 0.5 * place.weight[i] * place.weight[j] *
				 (normalAt[j] - normalAt[i]).dot(at[j] - at[i]);
	}
	contact.partners = mostPartners<3>;
	contact.facet = place.facet;
	contact.partner = vertex;
	contact.weight = place.weight;
	contact.normal = normal.normalized();
	contact.gap = (x - foot).dot(contact.normal) - bulge;
}

/// Facets that may reach into a region, in their order.
template <int dim> FacetBalls<dim> facetsIn(const ContactOutline<dim>& body, const Box<dim>& region)
{
	const auto& facet = body.mesh->facet;
	const Box<dim> around = region.grown(body.longestEdge);
	return { body, numbersThat(static_cast<int>(facet.size()), [&](int f) {
			 return around.contains(body.position[facet[f][0]]);
		 }) };
}

/// Nodes of `body` that may be inside `other` or within reach of it.
template <int dim>
std::vector<int> nodesNear(const ContactOutline<dim>& body, const ContactOutline<dim>& other,
			   double reach)
{
	const Box<dim> around = other.box.grown(reach + other.bulge());
	// the ball is the tighter of the two for round grains
	const double radius = other.outerRadius() + reach;
	const Vec<dim> centre = other.box.centre();
	return numbersThat(body.nodes(), [&](int s) {
		const Vec<dim>& x = body.position[s];
		return around.contains(x) & ((x - centre).squaredNorm() <= radius * radius);
	});
}

/// Notes the overlap, if there is one; whether a contact with this gap is one: what lies deeper
/// than contacts do is none.
template <int dim>
bool noteAndKeep(double gap, const ContactOutline<dim>& body, const ContactOutline<dim>& other,
		 ContactList<dim>& list)
{
	list.noteOverlap(gap, meanSpacing(body, other));
	return gap >= -contactDepth(body, other);
}

/// Makes room for a contact with this gap, if it is one (else null).
template <int dim>
Contact<dim>* append(const ContactKey& key, double gap, const ContactOutline<dim>& body,
		     const ContactOutline<dim>& other, ContactList<dim>& list)
{
	if (!noteAndKeep(gap, body, other, list)) return nullptr;
	Contact<dim>& contact = list.contacts.emplace_back();
	contact.key = key;
	return &contact;
}

/// The facet nearest to a node that overlaps may lie outside the common region by less than a
/// contact depth.
template <int dim>
double marginOf(const ContactOutline<dim>& body, const ContactOutline<dim>& other, double reach)
{
	return std::max(reach, contactDepth(body, other));
}

/// Facets of `other` that may be the nearest to nodes of `body` within reach.
template <int dim>
FacetBalls<dim> facetsNear(const ContactOutline<dim>& body, const ContactOutline<dim>& other,
			   double reach)
{
	const double margin = marginOf(body, other, reach);
	auto facets = facetsIn(other, body.box.grown(margin));
	// as in nodesNear, the ball about the body is the tighter one
	facets.leaveOutFarFrom(body.box.centre(), body.circumradius + margin);
	return facets;
}

/// Calls `use(node, facets)` for the nodes of `body` that may be within reach of the outline of
/// `other`, with the facets that may be the nearest.
template <int dim, class Use>
void forNodesNear(const ContactOutline<dim>& body, const ContactOutline<dim>& other, double reach,
		  ContactList<dim>& list, Use&& use)
{
	const auto nodes = nodesNear(body, other, reach);
	if (nodes.empty()) return;
	const auto facets = facetsNear(body, other, reach);
	if (facets.empty()) return;
	list.tested += static_cast<int>(nodes.size());
	for (int s : nodes)
		use(s, facets);
}

} // namespace softgrain
