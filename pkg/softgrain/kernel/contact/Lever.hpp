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

#include <array>

namespace softgrain {

/// a_i of the nodes of a contact's place; no unit.
template <int dim> using Levers = std::array<Vec<dim>, mostPartners<dim>>;

/// From the positions of these nodes, m. Zero where the facet is steeper than 60 degrees to the
/// contact, as about a corner: it does not tell how the normal turns.
Levers<2> leversOf(const std::array<Vec<2>, mostPartners<2>>& x, const Vec<2>& n, double gap);
Levers<3> leversOf(const std::array<Vec<3>, mostPartners<3>>& x, const Vec<3>& n, double gap);

} // namespace softgrain
