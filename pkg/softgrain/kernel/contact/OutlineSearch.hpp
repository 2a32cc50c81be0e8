// Nodes of each of two bodies against the outline of the other: the search behind
// ContactGeometry::surface.
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactOutline.hpp"

#include <optional>

namespace softgrain {

/// How deep a node may lie in the other grain and still be a contact, m: from deeper it would be
/// pushed to whichever side is nearest.
template <int dim> double contactDepth(const ContactOutline<dim>& a, const ContactOutline<dim>& b);

/// Appends the contacts with a gap below `reach` (m, > 0) to `list`, in the order of their keys.
template <int dim>
void findOutlineContacts(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
			 double reach, ContactList<dim>& list);

/// The contact of a rigid ball (of radius 0: a point) with the outline of `body` (surface), at the
/// place nearest to its centre, but for its key; none with a gap of `reach` (m, > 0) or more. The
/// ball is the node, the outline bears it.
template <int dim>
std::optional<Contact<dim>> ballOnOutline(const Vec<dim>& centre, double radius,
					  const ContactOutline<dim>& body, double reach);

} // namespace softgrain
