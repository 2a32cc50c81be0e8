// What YADE's collider does not notice by itself.
#pragma once

#include "Yade.hpp"

namespace yade {

/// After O.engines has changed the collider goes on with the NewtonIntegrator that it met first,
/// and shapes with the functor that bounded them first.
class ColliderWatch {
public:
	/// Makes both those of the present O.engines; the collider runs again where they were not.
	void followEngines(Scene& scene);

private:
	void followFunctors(Scene& scene, const vector<shared_ptr<BoundFunctor>>& functors);

	vector<shared_ptr<BoundFunctor>> functors_; ///< of the collider in the last step
};

/// Whether a Box or a Facet has turned out of its bounding box: the collider watches State.pos
/// only.
bool isPlateOutsideItsBox(const Scene& scene, int threads);

} // namespace yade
