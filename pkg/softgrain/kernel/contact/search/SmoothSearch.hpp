// The search that serves for several steps: nodes that may come into contact soon are found once
// (ContactCandidates), and in each step only these are measured, from the facet that they had. For
// outlines without corners or indentations.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/ContactOutline.hpp"

namespace softgrain {

/// Appends the contacts with a gap below `reach` (m, > 0) to `list`, in the order of their keys;
/// renews the candidates of the list when the bodies have moved too far.
template <int dim>
void findContactsOfSmoothOutlines(const ContactOutline<dim>& first,
				  const ContactOutline<dim>& second, double reach,
				  ContactList<dim>& list);

} // namespace softgrain
