// All soft grains of a scene as one system of the kernel, shared by their shapes.
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <memory>

namespace yade {
class SoftGrain;

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

} // namespace yade
