// All soft grains of a scene as one system of the kernel, shared by their shapes.
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <memory>
#include <string>

namespace yade {
class SoftGrain;
class SoftMat;

/// The assembly of the scene's soft grains, made anew if grains, materials or shapes changed since;
/// null if there is none.
/// Throws std::invalid_argument (std::runtime_error for its State) saying which body is wrong and
/// why. Thread-safe.
std::shared_ptr<softgrain::GrainAssembly> assembleScene(Scene& scene);
/// The same for a step, by so many threads; tells the assembly besides what is to be known of
/// bodies in it (HostNotes: grains that were moved, the cell, boxes to be looked at).
std::shared_ptr<softgrain::GrainAssembly> assembleForStep(Scene& scene, int threads);

/// Whether the engines of the scene can carry a contact through the step at hand; it is looked at
/// them once a step. Before there is one: YADE may end the process where the integrator, which
/// comes later, would say what is wrong.
bool isFit(softgrain::GrainAssembly& assembly, const Scene& scene) noexcept;

/// Where a grain is to be found.
struct AssembledGrain {
	std::shared_ptr<softgrain::GrainAssembly> assembly; ///< null: in none
	int index;
};
/// Assembly and index as they belong together, while others may be assembling.
AssembledGrain assembledGrain(const SoftGrain& shape);
/// The scene is assembled if need be; in none if that fails. For functors, which run in parallel
/// regions where nothing may be thrown: SoftGrainIntegrator reports why.
AssembledGrain assembledGrain(const SoftGrain& shape, Scene& scene) noexcept;

bool isSoftGrain(const Body& body);
bool isPlate(const Shape& shape); ///< a Box or a Facet
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
