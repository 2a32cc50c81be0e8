// What is said where a run stops since a soft grain overlaps another body.
#pragma once

#include "Yade.hpp"

namespace yade {

/// `deepest`: the largest overlap of the pair over dr (infinite: one lies inside the other), more
/// than `maxOverlap`. With hints at what may have caused it.
string messageOfOverlap(const Interaction& I, const Scene& scene, Real deepest, Real maxOverlap);

} // namespace yade
