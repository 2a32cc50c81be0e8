// A pass over all bodies of a scene, most of which have nothing to do: it waits for memory at every
// body unless it asks for it ahead.
#pragma once

#include "Fetch.hpp"
#include "SoftGrain.hpp"

#include <core/BodyContainer.hpp>

namespace yade {

/// How many bodies ahead a body is asked for, and what it points to.
constexpr int bodyAhead = 12, partsAhead = 6;

/// What passes over all grains read lies at the beginning of a SoftGrain, bytes.
constexpr int grainHead = 384;

/// In the i-th of `count` turns of a pass over the bodies idOf(0), idOf(1), ...
template <class Id> void fetchBodies(const BodyContainer& bodies, int i, int count, const Id& idOf)
{
	if (i + bodyAhead < count) {
		const Body* body = bodies[idOf(i + bodyAhead)].get();
		softgrain::fetchBytes(body, body + 1);
	}
	const Body* body = i + partsAhead < count ? bodies[idOf(i + partsAhead)].get() : nullptr;
	if (!body) return;
	const char* shape = reinterpret_cast<const char*>(body->shape.get());
	softgrain::fetchBytes(shape, shape + grainHead);
	softgrain::fetchBytes(body->state.get(), body->state.get() + 1);
}

} // namespace yade
