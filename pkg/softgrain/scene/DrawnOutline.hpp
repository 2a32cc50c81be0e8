// Outlines of soft grains for a renderer. It has a thread of its own and must not read what a step
// is changing: beside steps it gets copies, which they leave when it has asked. Nor must it change
// anything: grains that no step has seen yet are made once more, for it alone.
#pragma once

#include "Yade.hpp"

#include <memory>
#include <mutex>
#include <vector>

namespace yade {

class SoftGrain;

struct DrawnOutline {
	std::vector<Vector3r> places; ///< of the contact nodes about State.pos, in its axes, m
	std::vector<int> facets;      ///< as SoftGrain.facets(), one after the other
};

/// As the grain is now; beside a step as a step left it or a renderer last saw it, whichever is
/// later. Null if none has, and of a grain that cannot be made.
std::shared_ptr<const DrawnOutline> outlineToDraw(SoftGrain& grain, const State& state);

/// Keeps renderers off the grains while it lives.
class StepBesideRenderers {
public:
	StepBesideRenderers();
	/// Leaves them the outlines that one has asked for since this was last called.
	void leaveOutlines(const Scene& scene) const;

private:
	std::lock_guard<std::mutex> lock_;
};

} // namespace yade
