// Contact of a grain with itself is not computed: this tells where it would be needed.
#pragma once

#include "contact/ContactOutline.hpp"

namespace softgrain {

/// How deep the outline of a grain in the plane has gone into itself, m: of the contact nodes that
/// lie inside the grain, the farthest from what they have gone through; 0 if none does, and without
/// an outline. Costs as many looks at all facets as there are nodes, but only for outlines that
/// turn back on themselves.
double selfOverlap(const ContactOutline<2>& body);

} // namespace softgrain
