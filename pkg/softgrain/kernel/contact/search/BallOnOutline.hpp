// The end of a rigid body against the outline of a grain.
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactOutline.hpp"

#include <optional>

namespace softgrain {

/// The contact of a rigid ball (of radius 0: a point) with the outline of `body` (surface), at the
/// place nearest to its centre, but for its key; none with a gap of `reach` (m, > 0) or more. The
/// ball is the node, the outline bears it.
template <int dim>
std::optional<Contact<dim>> ballOnOutline(const Vec<dim>& centre, double radius,
					  const ContactOutline<dim>& body, double reach);

} // namespace softgrain
