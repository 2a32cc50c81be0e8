#include "DrawnOutline.hpp"
#include "SceneAssembly.hpp"
#include "SoftGrain.hpp"

#include <atomic>
#include <exception>

namespace yade {

namespace {

std::atomic<bool> isStepping { false }, isAskedFor { false };

} // namespace

std::shared_ptr<const DrawnOutline> outlineToDraw(SoftGrain& grain, const State& state)
{
	if (Omega::instance().isRunning() || isStepping) {
		isAskedFor = true;
		return std::atomic_load(&grain.drawn);
	}
	try {
		return grain.outlineAbout(state);
	} catch (const std::exception&) { // of a scene that is not in order; its next step tells
		return nullptr;
	}
}

StepBesideRenderers::StepBesideRenderers() { isStepping = true; }

StepBesideRenderers::~StepBesideRenderers() { isStepping = false; }

void StepBesideRenderers::leaveOutlines(const Scene& scene) const
{
	if (!isAskedFor.exchange(false)) return;
	for (const auto& body : *scene.bodies) {
		if (!body || !isSoftGrain(*body)) continue;
		auto& grain = static_cast<SoftGrain&>(*body->shape);
		std::atomic_store(&grain.drawn, grain.outlineAbout(*body->state));
	}
}

} // namespace yade
