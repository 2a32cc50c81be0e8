// All soft grains of a scene as one system of the kernel, shared by their shapes.
#pragma once

#include "assembly/GrainAssembly.hpp"

#include <memory>
#include <optional>
#include <string>

namespace yade {
class Body;
class Interaction;
class NewtonIntegrator;
class Scene;
class SoftGrain;
class SoftMat;

/// The assembly of the scene's soft grains, made anew if grains, materials or shapes changed since;
/// null if there is none. What the step has to know of the bodies is noted in HostNotes (which were
/// moved, the cell, the first without a box).
/// Throws std::invalid_argument (std::runtime_error for its State) saying which body is wrong and
/// why. Thread-safe.
std::shared_ptr<softgrain::GrainAssembly> assembleScene(Scene& scene, int threads = 1);

/// Box about the present outline of a grain, in coordinates that `map` makes of those of space, the
/// scene being assembled if need be; none if that fails. For functors, which run in parallel
/// regions where nothing may be thrown: SoftGrainIntegrator reports why.
std::optional<softgrain::Box<3>> outlineBox(const SoftGrain& shape, Scene& scene,
					    const softgrain::Mat3& map) noexcept;

bool isSoftGrain(const Body& body);
/// Whether a rigid body has a material that contact with soft grains goes by.
bool hasFriction(const Body& body);

/// Shape of a body that is a soft grain.
SoftGrain& grainOf(const Scene& scene, int id);

/// Material of the same.
const SoftMat& materialOf(const Scene& scene, int id);

/// "bodies #1 and #2", for messages.
std::string namesOf(const Interaction& I);

/// Whether it moves a body (NewtonIntegrator.mask).
bool isMoved(const Body& body, const NewtonIntegrator& newton);
/// Velocity with which it does, m/s; of others, whose State may have one, zero.
Vector3r motionOf(const Body& body, const NewtonIntegrator& newton);

/// O.dt of a scene in which nobody has set it, s.
double defaultTimeStep();

} // namespace yade
