// Walls that WallStressController has freed to push them. A tag of the scene has their ids, so that
// they are known in a saved scene and to new engines.
#pragma once

#include "Yade.hpp"

#include <map>

namespace yade {

class PushedWalls {
public:
	/// From now on the wall is free along an axis, or held; it stands still at first.
	static void free(Scene& scene, Body& wall, int axis);
	static void hold(Scene& scene, Body& wall);

	/// Holds walls that no engine pushes any more, and tells which. Those move on only if they
	/// have been given a velocity since the last call. To be called once in a step.
	std::vector<Body::id_t> holdTheRest(Scene& scene);

private:
	bool isAsMoved(const State& state, Body::id_t id, Real time) const;

	/// At the last call.
	std::map<Body::id_t, Vector3r> place_;
	Real time_ = 0;
};

} // namespace yade
