// O.engines as soft grains need them: which are there, in which order.
#pragma once

namespace yade {
class Engine;
class NewtonIntegrator;
class Scene;
class SoftGrainIntegrator;

/// The first one of O.engines, which solves contacts and moves soft grains; null if there is none.
SoftGrainIntegrator* softGrainIntegratorOf(const Scene& scene);

/// The first one of O.engines that is not dead, which carries State along; null if there is none.
const NewtonIntegrator* newtonIntegratorOf(const Scene& scene);

/// Whether one that is active sets O.dt for the rigid bodies.
bool hasTimeStepper(const Scene& scene);

/// Whether O.forces holds what the last step, or the one that goes on, has put on bodies: not from
/// ForceResetter to SoftGrainIntegrator, nor in a scene that was loaded or has made no step.
bool hasForcesOfLastStep(const Scene& scene);

/// Throws std::runtime_error saying which engine is missing, doubled or stands on the wrong side of
/// the integrator, and where it belongs.
void checkEngineOrder(const Scene& scene, const SoftGrainIntegrator& integrator);

} // namespace yade
