#include "classes/SoftenWhenLoaded.hpp"
#include "Require.hpp"
#include "checks/Engines.hpp"
#include "classes/SoftContact.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "scene/Bodies.hpp"

#include <lib/pyutil/gil.hpp>

#include <algorithm>
#include <set>

namespace yade {

YADE_PLUGIN((SoftenWhenLoaded));

void SoftenWhenLoaded::postLoad(SoftenWhenLoaded&)
{
	softgrain::require(load >= 0 && math::isfinite(load), "load", load, "[0, inf)");
}

void SoftenWhenLoaded::action()
{
	forgetOtherScene();
	postLoad(*this); // a refused value stays
	if (!shape || !material)
		throw std::runtime_error("SoftenWhenLoaded: shape or material is None; see "
					 "sg.soften(when='loaded')");
	vector<int> waiting, loaded;
	std::set<int> seen;
	for (const int id : ids) {
		const bool isFirst = seen.insert(id).second;
		if (!isFirst || !scene->bodies->exists(id)) continue; // named twice; erased
		const auto& body = (*scene->bodies)[id];
		if (!YADE_PTR_DYN_CAST<Sphere>(body->shape)) continue; // changed
		const auto known = bodies_.find(id);
		if (known != bodies_.end() && known->second.lock() != body) continue; // another
		bodies_[id] = body;
		(isLoaded(*body) ? loaded : waiting).push_back(id);
	}
	ids = lastIds_ = waiting;
	if (!loaded.empty() && !hasSoftGrains()) leaveTimeStepToIntegrator();
	auto* integrator = softGrainIntegratorOf(*scene);
	if (integrator && (softened > 0 || !loaded.empty()))
		integrator->dtOfSpheres = std::max(integrator->dtOfSpheres, dt);
	if (loaded.empty()) return;
	// not one by one: the contact that loads two is gone with the first
	int lostBonds = 0;
	for (const int id : loaded)
		lostBonds += soften(*(*scene->bodies)[id]);
	if (integrator) {
		integrator->lostBonds += lostBonds;
		integrator->noteSoftened(scene->iter);
	}
	softened += loaded.size();
	scene->doSort = true;
}

/// Ids of a scene that is gone are those of other bodies in the present one, unless the script has
/// set them anew.
void SoftenWhenLoaded::forgetOtherScene()
{
	const bool isOther = ownScene_.isGone();
	ownScene_.enter();
	if (!isOther) return;
	if (ids == lastIds_) ids.clear();
	bodies_.clear();
	softened = 0;
	dt = 0;
}

bool SoftenWhenLoaded::hasSoftGrains() const
{
	return std::any_of(scene->bodies->begin(), scene->bodies->end(),
			   [](const auto& body) { return isSoftGrain(*body); });
}

bool SoftenWhenLoaded::isLoaded(const Body& body) const
{
	const Real diameter = 2 * static_cast<const Sphere&>(*body.shape).radius;
	const Real limit = load * material->young * std::pow(diameter, shape->dim - 1);
	return std::any_of(body.intrs.begin(), body.intrs.end(), [limit](const auto& entry) {
		const auto* phys = dynamic_cast<const NormShearPhys*>(entry.second->phys.get());
		return phys && (phys->normalForce + phys->shearForce).norm() > limit;
	});
}

/// As sg.soften() does. Python holds the sphere that goes if a script made it.
int SoftenWhenLoaded::soften(Body& body) const
{
	const gilLock lock;
	const auto grain = shape->undeformed();
	grain->radius = static_cast<const Sphere&>(*body.shape).radius;
	grain->color = body.shape->color;
	body.shape = grain;
	body.material = material;
	State& state = *body.state;
	state.blockedDOFs = State::DOF_ALL; // NewtonIntegrator carries it along
	if (grain->dim == 2) {
		state.vel[2] = 0;
		state.angVel[0] = state.angVel[1] = 0;
	}
	int lostBonds = 0;
	for (const auto& [other, interaction] : body.intrs) {
		const auto* geom = dynamic_cast<const SoftGeom*>(interaction->geom.get());
		if (geom) lostBonds += geom->wholeBonds();
		interaction->reset();
	}
	return lostBonds;
}

/// The first soft grains come into a scene whose O.dt was chosen for spheres.
void SoftenWhenLoaded::leaveTimeStepToIntegrator()
{
	dt = scene->dt;
	if (auto* integrator = softGrainIntegratorOf(*scene)) integrator->dtSet = dt;
}

} // namespace yade
