// Candidates for contact, found once for several steps: what the searches have in common.
#pragma once

#include "contact/ContactCandidates.hpp"
#include "contact/ContactOutline.hpp"

#include <algorithm>

namespace softgrain {

/// Candidates are looked for this far beyond the reach, in dr: much less makes them short-lived,
/// much more makes too many.
constexpr double candidateMargin = 0.5;

template <int dim>
double finerSpacing(const ContactOutline<dim>& first, const ContactOutline<dim>& second)
{
	return std::min(first.pointSpacing, second.pointSpacing);
}

/// Gaps up to this make candidates, m.
template <int dim>
double candidateReach(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		      double reach)
{
	return reach + candidateMargin * finerSpacing(first, second);
}

/// A gap within reach changes by no more than so many times the ways of nodes. 2D: the sum of the
/// sizes of the weights of OutlineCurve. 3D: 1 for the flat facet, a third for the bulge over it
/// (the normals at its corners turn), the rest since normals are those of the arc, which turn more
/// the farther a node is off: 1.4 for balls, 2.0 for creased ones, half a dr off
/// (doc/decisions/0028-search.md).
inline double wayOfPlaces(const ContactOutline<2>&, const ContactOutline<2>&, double)
{
	return 1.25;
}
inline double wayOfPlaces(const ContactOutline<3>& first, const ContactOutline<3>& second,
			  double reach)
{
	return 2 + reach / finerSpacing(first, second);
}

/// The same of the way of all nodes together.
template <int dim> constexpr double wayOfBodies = dim == 2 ? 1 : 1.05;

/// By how much, in dr, a gap may jump where the nearest place goes over to another facet. (In 2D it
/// is the distance to a smooth curve; in 3D normals are those of the arc, the nearest place is that
/// on the flat facets.)
template <int dim> constexpr double jumpOfGaps = dim == 2 ? 0 : 0.1;

template <int dim>
double jumpBetween(const ContactOutline<dim>& first, const ContactOutline<dim>& second)
{
	return jumpOfGaps<dim> * finerSpacing(first, second);
}

/// Takes in how far nodes and places on the other outline may have come towards each other since
/// the last search.
template <int dim>
void followBodies(const ContactOutline<dim>& first, const ContactOutline<dim>& second, double reach,
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

/// Looks for candidates anew where those that there are do not reach far enough, or are not to be
/// kept: calls `find(body, other, side, within)` for both sides. `below`: by how much gaps may be
/// less than `find` has them, m.
template <int dim, class Find>
void renewCandidates(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		     double reach, bool keep, double below, ContactCandidates<dim>& candidates,
		     Find&& find)
{
	if (keep && reach + candidates.approached <= candidates.covered) return;
	const double within = candidateReach(first, second, reach);
	candidates.clear();
	candidates.covered = within - below + candidates.approached;
	find(first, second, 0, within);
	find(second, first, 1, within);
}

/// Calls `use` for the candidates that may be within reach.
template <int dim, class Use>
void forCandidates(double reach, ContactCandidates<dim>& candidates, Use&& use)
{
	for (auto& node : candidates.nodes)
		if (node.clearance - candidates.approached < reach) use(node);
}

} // namespace softgrain
