#include "scene/HostTimeStep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yade {

namespace {

bool hasLinearLaw(const InteractionLoop& loop)
{
	const auto& laws = loop.lawDispatcher->functors;
	return std::any_of(laws.begin(), laws.end(), [](const auto& law) {
		return bool(YADE_PTR_DYN_CAST<Law2_ScGeom_FrictPhys_CundallStrack>(law));
	});
}

bool hasLinearLaw(const Scene& scene)
{
	return std::any_of(scene.engines.begin(), scene.engines.end(), [](const auto& engine) {
		const auto loop = YADE_PTR_DYN_CAST<InteractionLoop>(engine);
		return loop && hasLinearLaw(*loop);
	});
}

/// Infinity where none is needed.
Real waveTime(const Body& body, const FrictMat& material)
{
	const auto sphere = YADE_PTR_DYN_CAST<Sphere>(body.shape);
	if (!sphere || !(body.isDynamic() || body.isClumpMember()))
		return std::numeric_limits<Real>::infinity();
	return sphere->radius * std::sqrt(material.density / material.young);
}

} // namespace

Real defaultTimeStep()
{
	static const Real step =
		Scene().dt; // a Scene is costly to make, and this is asked per pair
	return step;
}

Real rigidTimeStep(const Scene& scene)
{
	constexpr Real none = std::numeric_limits<Real>::infinity();
	if (!hasLinearLaw(scene)) return none;
	Real least = none;
	int bodies = 0;
	for (const auto& body : *scene.bodies) {
		const auto material = YADE_PTR_DYN_CAST<FrictMat>(body->material);
		if (!material) continue;
		++bodies;
		least = std::min(least, waveTime(*body, *material));
	}
	return bodies > 1 ? least : none;
}

} // namespace yade
