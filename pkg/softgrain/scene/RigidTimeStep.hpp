// What YADE's linear law between rigid spheres asks of O.dt.
#pragma once

#include "Yade.hpp"

namespace yade {

/// Of the stiffest rigid sphere that can move, as utils.PWaveTimeStep() has it [s]; infinity where
/// rigid bodies do not meet by Law2_ScGeom_FrictPhys_CundallStrack.
Real rigidTimeStep(const Scene& scene);

} // namespace yade
