// Sharp edges and corners of an outline: what is nearest to one lies over no facet.
#pragma once

#include "contact/Contact.hpp"
#include "contact/search/PlaceOnOutline.hpp"

namespace softgrain {

/// Whether the outline is indented at a corner, where a facet begins or ends: what lies beyond the
/// ends of both sides is inside.
inline bool isIndented(const ContactOutline<2>& body, int facet, int corner)
{
	const auto [before, begin, end, after] = body.mesh->carriers(facet);
	const int last = corner == begin ? before : begin, next = corner == begin ? end : after;
	const std::vector<Vec<2>>& x = body.position;
	return cross(x[corner] - x[last], x[next] - x[corner]) < 0;
}

/// In 3D there are blocks only.
inline bool isIndented(const ContactOutline<3>&, int, int) { return false; }

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
		indented = indented || isIndented(body, place.facet, vertex);
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

} // namespace softgrain
