// Narrow search: the contacts of two bodies within reach.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"

namespace softgrain {

/// Replaces `list.contacts` by those with a gap below `reach` (m, > 0); impulses of contacts that
/// were there before are kept as the start of the next solve. Both bodies have facets: nodes of
/// each against the outline of the other, in both directions. Neither has: nodes as disks (spheres)
/// against each other. Both are on the common grid: its nodes that get mass from both.
template <int dim>
void findContacts(const ContactOutline<dim>& first, const ContactOutline<dim>& second, double reach,
		  ContactList<dim>& list);

/// The same against `list.rigid` if there is one, else `list.plane`.
template <int dim>
void findContacts(const ContactOutline<dim>& body, double reach, ContactList<dim>& list);

} // namespace softgrain
