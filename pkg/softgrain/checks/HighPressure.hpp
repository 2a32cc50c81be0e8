// Grains under more pressure than their background grid was found to bear (doc/decisions/0008).
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <string>

namespace yade {

/// Looks at the grain that holds most elastic energy for its young and volume. Returns what to
/// tell of it if its mean pressure (in 2D in the plane) is more than such grains were found to bear
/// within some per cent of force; empty otherwise.
std::string highPressure(const Scene& scene, const softgrain::GrainAssembly& assembly);

} // namespace yade
