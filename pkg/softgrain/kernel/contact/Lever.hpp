// Across an open gap: how the surface that bears a contact turns, and what a force along it asks of
// that surface.
//
// A node at the gap g before the place y that bears its contact is y + g n. If both bodies turn as
// one, that moves with
//     sum_i w_i v_i - sum_i a_i (n . v_i),    a_i = g grad w_i,
// since dn/dt = - sum_i grad w_i (n . v_i): the second sum is no slip. And p on the node is borne
// by -w_i p + (p . a_i) n on the nodes i: then it does no work as they turn, and leaves no moment.
#pragma once

#include "Vector.hpp"
#include "reference/Outline.hpp"

#include <Eigen/Geometry>
#include <array>

namespace softgrain {

/// a_i of the nodes of a contact's place.
template <int dim> using Levers = std::array<Vec<dim>, mostPartners<dim>>;

/// From the positions of these nodes. Zero where the facet stands so steep to the contact, as about
/// a corner, that it does not tell how the normal turns.
inline Levers<2> leversOf(const std::array<Vec<2>, mostPartners<2>>& x, const Vec<2>& n, double gap)
{
	constexpr double leastShare = 0.25; // of its length, across the normal, squared
	Levers<2> a;
	a.fill(Vec<2>::Zero());
	const Vec<2> edge = x[2] - x[1]; // the facet, between the nodes beside it
	const Vec<2> along = edge - edge.dot(n) * n;
	if (along.squaredNorm() < leastShare * edge.squaredNorm()) return a;
	a[2] = gap / along.squaredNorm() * along;
	a[1] = -a[2];
	return a;
}

inline Levers<3> leversOf(const std::array<Vec<3>, mostPartners<3>>& x, const Vec<3>& n, double gap)
{
	constexpr double leastShare = 0.5; // of its area, across the normal
	Levers<3> a;
	a.fill(Vec<3>::Zero());
	const Vec<3> u = x[1] - x[0], v = x[2] - x[0], area = u.cross(v);
	const double across = area.dot(n);
	if (std::abs(across) < leastShare * area.norm()) return a;
	a[1] = gap / across * v.cross(n);
	a[2] = gap / across * n.cross(u);
	a[0] = -a[1] - a[2];
	return a;
}

} // namespace softgrain
