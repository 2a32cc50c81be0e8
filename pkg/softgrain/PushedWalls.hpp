// Walls that WallStressController has freed to push them. A tag of the scene has them, so that they
// are known in a saved scene and to new engines.
#pragma once

#include "Yade.hpp"

namespace yade {

/// From now on the wall is free along an axis, or held; it stands still at first.
void freeToPush(Scene& scene, Body& wall, int axis);
void holdWall(Scene& scene, Body& wall);

/// The wall is pushed in this step. To be called before NewtonIntegrator moves it.
void notePush(Scene& scene, const Body& wall, int axis);

/// Holds walls that were freed and are pushed in this step no more, and tells which. Those move on
/// only if they have been given a velocity since. To be called once in a step, after whatever
/// pushes.
std::vector<Body::id_t> holdUnpushedWalls(Scene& scene);

} // namespace yade
