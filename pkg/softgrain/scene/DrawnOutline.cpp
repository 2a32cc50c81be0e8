#include "scene/DrawnOutline.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/Bodies.hpp"
#include "scene/SceneAssembly.hpp"

#include <atomic>
#include <exception>

namespace yade {

namespace {

std::mutex stepMutex; // held by a step, or by a renderer that reads what steps change
std::atomic<bool> isAskedFor { false };

/// About where the assembly has it, which is where State will be after the step; a change of State
/// by hand moves the picture along.
std::shared_ptr<const DrawnOutline> outlineIn(const softgrain::GrainAssembly& assembly, int g)
{
	const softgrain::GrainMotion motion = assembly.motion(g);
	const softgrain::Rotation back = motion.orientation.conjugate();
	DrawnOutline outline;
	outline.facets = assembly.facets(g);
	for (const softgrain::Vec3& x : assembly.outline(g))
		outline.places.push_back(back * (x - motion.position));
	return std::make_shared<const DrawnOutline>(std::move(outline));
}

/// An assembly of this grain alone. Templates stay for the next one.
std::shared_ptr<softgrain::GrainAssembly> assembledAlone(const SoftGrain& grain, const State& state)
{
	static std::shared_ptr<softgrain::GrainAssembly> last;
	Body body; // the outline is that of any material
	body.state = boost::make_shared<State>();
	body.state->se3 = state.se3;
	body.material = boost::make_shared<SoftMat>();
	return last = softgrain::GrainAssembly::create({ grain.describe(body) }, last.get());
}

} // namespace

std::shared_ptr<const DrawnOutline> outlineToDraw(SoftGrain& grain, const State& state)
{
	const std::unique_lock<std::mutex> lock(stepMutex, std::try_to_lock);
	if (!lock) {
		isAskedFor = true;
		return std::atomic_load(&grain.drawn);
	}
	try {
		if (const auto [assembly, index] = assembledGrain(grain); assembly)
			std::atomic_store(&grain.drawn, outlineIn(*assembly, index));
		else if (!grain.drawn)
			std::atomic_store(&grain.drawn,
					  outlineIn(*assembledAlone(grain, state), 0));
	} catch (const std::exception&) { // the next step tells what is wrong
	}
	return grain.drawn;
}

StepBesideRenderers::StepBesideRenderers()
	: lock_(stepMutex)
{
}

void StepBesideRenderers::leaveOutlines(const Scene& scene) const
{
	if (!isAskedFor.exchange(false)) return;
	for (const auto& body : *scene.bodies) {
		if (!isSoftGrain(*body)) continue;
		auto& grain = static_cast<SoftGrain&>(*body->shape);
		std::atomic_store(&grain.drawn, outlineIn(*grain.assembly, grain.index));
	}
}

} // namespace yade
