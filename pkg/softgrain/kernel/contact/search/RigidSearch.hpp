// Contacts of a soft grain with the surface of a rigid body.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"

namespace softgrain {

/// Appends the contacts with a gap below `reach` (m, > 0) to `list`, in the order of their keys:
/// nodes of the grain against the rigid surface (side 0), and what the rigid surface ends in, a
/// ball or the corners, against the outline of the grain between its nodes (side 1; the node is the
/// number of the corner).
template <int dim>
void findRigidContacts(const ContactOutline<dim>& body, double reach, ContactList<dim>& list);

} // namespace softgrain
