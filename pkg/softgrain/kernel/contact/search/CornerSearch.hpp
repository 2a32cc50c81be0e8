// The search for outlines with corners or indentations: near these the nearest facet need not be
// the one that a node lies against.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"

namespace softgrain {

/// Appends the contacts with a gap below `reach` (m, > 0) to `list`, in the order of their keys.
/// Nodes that are near are found for several steps, and in each step these are measured anew: what
/// is found does not depend on when that was.
template <int dim>
void findContactsAtCorners(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
			   double reach, ContactList<dim>& list);

} // namespace softgrain
