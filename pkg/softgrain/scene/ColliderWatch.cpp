#include "scene/ColliderWatch.hpp"
#include "Threads.hpp"
#include "checks/Engines.hpp"
#include "scene/Bodies.hpp"

#include <algorithm>

namespace yade {

namespace {

InsertionSortCollider* colliderOf(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (auto* collider = dynamic_cast<InsertionSortCollider*>(engine.get());
		    collider && !collider->dead)
			return collider;
	return nullptr;
}

shared_ptr<NewtonIntegrator> sharedNewtonOf(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (engine.get() == newtonIntegratorOf(scene))
			return boost::static_pointer_cast<NewtonIntegrator>(engine);
	return nullptr;
}

bool isOutsideItsBox(const Body& body)
{
	if (!body.bound || !body.shape->boundFunctor) return false;
	thread_local shared_ptr<Bound> present(new Aabb);
	body.shape->boundFunctor->go(body.shape, present, body.state->se3, &body);
	const Vector3r &low = body.bound->min, &high = body.bound->max;
	return (present->min.array() < low.array()).any() ||
	       (present->max.array() > high.array()).any();
}

} // namespace

void ColliderWatch::followEngines(Scene& scene)
{
	InsertionSortCollider* collider = colliderOf(scene);
	if (!collider) return;
	if (collider->newton && collider->newton.get() != newtonIntegratorOf(scene)) {
		collider->newton = sharedNewtonOf(scene);
		scene.doSort = true;
	}
	if (collider->boundDispatcher->functors != functors_)
		followFunctors(scene, collider->boundDispatcher->functors);
}

void ColliderWatch::followFunctors(Scene& scene, const vector<shared_ptr<BoundFunctor>>& functors)
{
	functors_ = functors;
	for (const auto& body : *scene.bodies) {
		if (!body || !body->shape || !body->shape->boundFunctor) continue;
		auto& own = body->shape->boundFunctor;
		if (std::find(functors.begin(), functors.end(), own) != functors.end()) continue;
		own.reset(); // the collider looks for one in its next run
		scene.doSort = true;
	}
}

bool isPlateOutsideItsBox(const Scene& scene, int threads)
{
	const BodyContainer& bodies = *scene.bodies;
	const int count = static_cast<int>(bodies.size());
	bool outside = false;
#pragma omp parallel for schedule(static) reduction(|| : outside)                                  \
	num_threads(softgrain::threadsFor(count, threads))
	for (int id = 0; id < count; ++id) {
		if (outside) continue;
		const Body* body = bodies[id].get();
		outside = body && body->shape && isPlate(*body->shape) && isOutsideItsBox(*body);
	}
	return outside;
}

} // namespace yade
