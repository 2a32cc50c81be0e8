// Walls that WallStressController has freed to push them. A tag of the scene has them, so that they
// are known in a saved scene and to new engines.
#pragma once

#include "Yade.hpp"

namespace yade {

/// blockedDOFs of a wall that is pushed along an axis.
int freeAlong(int axis);

/// From now on the wall, at rest, is free along an axis.
void freeWall(Body& wall, int axis);
/// From now on it is held, and moves on with its velocity.
void holdWall(Scene& scene, Body& wall);

/// The wall is pushed in this step; `mass`: what it was given for that, kg (0: it has another one).
/// To be called before NewtonIntegrator moves it.
void notePush(Scene& scene, const Body& wall, int axis, Real mass);
/// Whether its mass is the one that it was given when it was pushed last.
bool hasMassOfPush(Scene& scene, const Body& wall);

/// Holds walls that were freed and are pushed in this step no more, and tells which. Those move on
/// only if they have been given a velocity since. To be called once in a step, after whatever
/// pushes.
std::vector<Body::id_t> holdUnpushedWalls(Scene& scene);

} // namespace yade
