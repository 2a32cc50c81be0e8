// Groups of pairs that can be solved at the same time.
#pragma once

#include "contact/Contact.hpp"

#include <vector>

namespace softgrain {

/// Puts each pair, in the given order, into the first group none of whose pairs shares a body with
/// it. Groups follow one another, pairs keep their order in a group: an order of all pairs that
/// depends on nothing but the pairs, however many threads work on a group. Rigid partners that no
/// impulse moves are no common body.
template <int dim>
std::vector<std::vector<ContactList<dim>*>> pairColours(const std::vector<ContactList<dim>*>& lists,
							int bodies, int partners = 0);

} // namespace softgrain
