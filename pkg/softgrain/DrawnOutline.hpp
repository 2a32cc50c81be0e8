// Outlines of soft grains for a renderer. It has a thread of its own and must not read what a step
// is changing: while steps are taken they leave it a copy, if it has asked for one.
#pragma once

#include "Yade.hpp"

#include <memory>
#include <vector>

namespace yade {

class SoftGrain;

struct DrawnOutline {
	std::vector<Vector3r> places; ///< of the contact nodes about State.pos, in its axes, m
	std::vector<int> facets;      ///< as SoftGrain.facets(), one after the other
};

/// As the grain is now; beside a step, or a run, as it was when a step last left it. Null if none
/// has, and in a scene that cannot be assembled.
std::shared_ptr<const DrawnOutline> outlineToDraw(SoftGrain& grain, const State& state);

/// Keeps renderers off the grains while it lives.
class StepBesideRenderers {
public:
	StepBesideRenderers();
	~StepBesideRenderers();
	StepBesideRenderers(const StepBesideRenderers&) = delete;
	/// Leaves them the outlines that one has asked for since this was last called.
	void leaveOutlines(const Scene& scene) const;
};

} // namespace yade
