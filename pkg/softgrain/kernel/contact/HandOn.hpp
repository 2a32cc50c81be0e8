// What contacts with a floor of several rigid surfaces remember, from surface to surface.
#pragma once

#include "contact/ContactBody.hpp"
#include "contact/ContactList.hpp"
#include "contact/RigidPartner.hpp"

#include <vector>

namespace softgrain {

/// On a seam of facets or boxes a contact node is one surface's, then the next one's
/// (RigidSeams.hpp): a contact that vanished hands its history to the one that appeared in its
/// place, if that is on the same side, obeys the same law and the surfaces move alike. `lists` are
/// sorted by first body, partners numbered. Returns how many of the contacts that went on are
/// bonded.
template <int dim>
long handOnHistories(const std::vector<ContactList<dim>*>& lists,
		     const std::vector<ContactBody<dim>>& bodies,
		     const std::vector<RigidPartner<dim>>& partners);

} // namespace softgrain
