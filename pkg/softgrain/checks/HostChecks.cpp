#include "checks/HostChecks.hpp"
#include "Yade.hpp"
#include "classes/SoftContact.hpp"
#include "classes/SoftSearch.hpp"
#include "scene/TouchedBodies.hpp"

#include <algorithm>
#include <map>
#include <typeinfo>

namespace yade {

namespace {

[[noreturn]] void refuse(const string& what, const string& why)
{
	throw std::invalid_argument(what + ": " + why);
}

/// Engines that take every body for a sphere, or move bodies themselves. Never destroyed: a run in
/// the background may go on while the process ends.
const std::map<string, string>& unfitEngines()
{
	const string spheresOnly =
		"it knows spheres only and would pass over soft grains, or take them for spheres";
	static const auto& reasons = *new std::map<string, string> {
		{ "FlowEngine", spheresOnly },
		{ "PeriodicFlowEngine", spheresOnly },
		{ "TwoPhaseFlowEngine", spheresOnly },
		{ "PartialSatClayEngine", spheresOnly },
		{ "DFNFlowEngine", spheresOnly },
		{ "ThermalEngine", spheresOnly },
		{ "HydroForceEngine", spheresOnly },
		{ "HydrodynamicsLawLBM", spheresOnly },
		{ "FoamCoupling", spheresOnly },
		{ "SPHEngine", spheresOnly },
		{ "DragEngine", spheresOnly },
		{ "LinearDragEngine", spheresOnly },
		{ "Law2_ScGeom_CapillaryPhys_Capillarity", spheresOnly },
		{ "CapillarityEngine", spheresOnly },
		{ "RungeKuttaCashKarp54Integrator",
		  "it integrates rigid bodies by stages, between which contacts of soft grains are "
		  "not solved; use NewtonIntegrator" },
	};
	return reasons;
}

/// The one collider that runs again when an outline leaves its box (Scene::doSort).
void checkCollider(const Engine& engine)
{
	const auto* collider = dynamic_cast<const Collider*>(&engine);
	if (!collider) return;
	if (typeid(engine) != typeid(InsertionSortCollider))
		refuse(engine.getClassName(),
		       "it does not follow outlines that deform; soft grains need an "
		       "InsertionSortCollider");
	for (const auto& functor : collider->boundDispatcher->functors)
		if (auto* ofGrains = dynamic_cast<Bo1_SoftGrain_Aabb*>(functor.get()))
			ofGrains->postLoad(*ofGrains); // YADE keeps a value that was refused
}

/// Whether there is one of this very class.
template <class Wanted, class Functor> bool holds(const vector<shared_ptr<Functor>>& functors)
{
	return std::any_of(functors.begin(), functors.end(),
			   [](const auto& functor) { return typeid(*functor) == typeid(Wanted); });
}

/// YADE ends the process over a pair that has geometry, but no physics or law.
void checkFunctors(const InteractionLoop& loop)
{
	const auto& geometries = loop.geomDispatcher->functors;
	const bool soft = holds<Ig2_SoftGrain_SoftGrain_SoftGeom>(geometries);
	const bool rigid = holds<Ig2_Wall_SoftGrain_SoftGeom>(geometries) ||
			   holds<Ig2_Sphere_SoftGrain_SoftGeom>(geometries) ||
			   holds<Ig2_Facet_SoftGrain_SoftGeom>(geometries) ||
			   holds<Ig2_Box_SoftGrain_SoftGeom>(geometries);
	auto need = [](bool present, const char* name) {
		if (!present)
			refuse("InteractionLoop",
			       string("it finds contacts of soft grains, but has no ") + name +
				       "; add it, or see sg.engines()");
	};
	const auto& physics = loop.physDispatcher->functors;
	if (soft)
		need(holds<Ip2_SoftMat_SoftMat_SoftPhys>(physics), "Ip2_SoftMat_SoftMat_SoftPhys");
	if (rigid)
		need(holds<Ip2_FrictMat_SoftMat_SoftPhys>(physics),
		     "Ip2_FrictMat_SoftMat_SoftPhys");
	if (rigid || soft)
		need(holds<Law2_SoftGeom_SoftPhys_Nonsmooth>(loop.lawDispatcher->functors),
		     "Law2_SoftGeom_SoftPhys_Nonsmooth");
}

void checkTriaxial(const TriaxialStressController& controller)
{
	if (controller.internalCompaction)
		refuse(controller.getClassName() + ".internalCompaction = True",
		       "soft grains do not grow; set internalCompaction = False to move the walls");
}

void checkPeriodic(const PeriTriaxController& controller)
{
	if (controller.mass <= 0) // not given it is nan
		refuse(controller.getClassName() + ".mass = " + std::to_string(controller.mass),
		       "YADE would end the process; admissible: (0, inf), or leave it out");
	if (!controller.doneHook.empty())
		refuse(controller.getClassName() + ".doneHook = '" + controller.doneHook + "'",
		       "it waits for an unbalanced force that YADE takes of rigid bodies alone; "
		       "leave it empty, and look at the stress and at sg.unbalanced_force() in a "
		       "PyRunner");
	if (controller.stressMask != 0 && !controller.dynCell)
		refuse(controller.getClassName() + ".dynCell = False with stressMask = " +
			       std::to_string(controller.stressMask),
		       "it moves the cell by the stiffness of contacts, and those of soft grains "
		       "have none: the stress would be off by a sixth; set dynCell = True and "
		       "mass");
}

void checkEngine(const Engine& engine)
{
	const auto reason = unfitEngines().find(engine.getClassName());
	if (reason != unfitEngines().end()) refuse(reason->first, reason->second);
	checkCollider(engine);
	if (const auto* loop = dynamic_cast<const InteractionLoop*>(&engine)) checkFunctors(*loop);
	if (const auto* controller = dynamic_cast<const TriaxialStressController*>(&engine))
		checkTriaxial(*controller);
	if (const auto* controller = dynamic_cast<const PeriTriaxController*>(&engine))
		checkPeriodic(*controller);
}

[[noreturn]] void refuseSubdomains()
{
	refuse("MPI subdomains",
	       "contacts of soft grains are solved together, in one process; use threads (-jN)");
}

/// Of the collider, for the shape of a body; null if there is none.
shared_ptr<BoundFunctor> boundFunctorOf(const Scene& scene, const Body& body)
{
	for (const auto& engine : scene.engines) {
		const auto* collider = dynamic_cast<const Collider*>(engine.get());
		if (!collider || collider->dead) continue;
		if (auto functor = collider->boundDispatcher->getFunctor(body.shape))
			return functor;
	}
	return nullptr;
}

void checkBound(const Scene& scene, const Body& body)
{
	const string shape = body.shape->getClassName(), own = "Bo1_" + shape + "_Aabb";
	const string named = "body #" + std::to_string(body.getId()) + " of shape " + shape;
	const string passing = ", so that soft grains would pass through it";
	const string never = "Set its bounded = False if nothing is to touch it";
	const auto functor = boundFunctorOf(scene, body);
	if (!functor)
		refuse(named, "no functor of the collider bounds it" + passing +
				      "; they touch Sphere, Wall, Facet and Box. " + never);
	const auto& known = Omega::instance().getDynlibsDescriptor();
	if (functor->get1DFunctorType1() != shape && known.count(own))
		refuse(named, "the collider bounds it as a " + functor->get1DFunctorType1() +
				      passing + "; add " + own + " to its functors. " + never);
}

} // namespace

#ifdef YADE_MPI
void checkSubdomain(const Scene& scene)
{
	if (scene.subdomain != 0) refuseSubdomains();
}
void checkSubdomain(const Body& body)
{
	if (body.subdomain != 0 || body.getIsSubdomain()) refuseSubdomains();
}
#else
void checkSubdomain(const Scene&) {}
void checkSubdomain(const Body&) {}
#endif

bool mayLackBound(const Body& body)
{
	return body.isBounded() && !body.isClump() && (!body.bound || !isTouched(*body.shape));
}

void checkBounds(const Scene& scene, int first)
{
	const int count = static_cast<int>(scene.bodies->size());
	for (int id = first; id < count; ++id) {
		const Body* body = (*scene.bodies)[id].get();
		if (body && body->shape && mayLackBound(*body)) checkBound(scene, *body);
	}
}

void checkHost(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (!engine->dead) checkEngine(*engine);
	checkSubdomain(scene);
}

} // namespace yade
