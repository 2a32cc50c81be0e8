// O.dt as YADE has it: its default, and what the linear law between rigid spheres asks of it.
#pragma once

#include "Yade.hpp"

namespace yade {

/// O.dt of a scene in which nobody has set it, s.
Real defaultTimeStep();

/// Of the stiffest rigid sphere that can move, as utils.PWaveTimeStep() has it [s]; infinity where
/// rigid bodies do not meet by Law2_ScGeom_FrictPhys_CundallStrack.
Real rigidTimeStep(const Scene& scene);

} // namespace yade
