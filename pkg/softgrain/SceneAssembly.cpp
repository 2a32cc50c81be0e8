#include "SceneAssembly.hpp"
#include "FetchBodies.hpp"
#include "HostChecks.hpp"
#include "PeriodicCell.hpp"
#include "SoftGrain.hpp"
#include "SoftGrainIntegrator.hpp"
#include "SoftMat.hpp"

#include <map>
#include <mutex>
#include <typeinfo>

namespace yade {

namespace {

std::mutex assemblyMutex;

std::string name(const Body& body) { return "body #" + std::to_string(body.getId()); }

/// Nothing derives from the soft classes, and this is asked of every body in every step.
template <class Soft, class Base> bool isA(const shared_ptr<Base>& object)
{
	return object && typeid(*object) == typeid(Soft);
}

void checkBody(const Body& body)
{
	checkSubdomain(body);
	const bool softShape = isA<SoftGrain>(body.shape);
	const bool softMaterial = isA<SoftMat>(body.material);
	if (softShape && !softMaterial)
		throw std::invalid_argument(
			name(body) + " has the soft shape SoftGrain but the material " +
			(body.material ? body.material->getClassName() : string("None")) +
			"; soft grains need a SoftMat");
	if (softMaterial && !softShape)
		throw std::invalid_argument(
			name(body) + " has the material SoftMat but the rigid shape " +
			(body.shape ? body.shape->getClassName() : string("None")) +
			"; use sg.soften() or give it a rigid material such as FrictMat");
	if (softShape && (body.isClumpMember() || body.isClump()))
		throw std::invalid_argument(name(body) +
					    " is a soft grain in a clump, which is not supported");
	if (softShape && body.state->blockedDOFs != State::DOF_ALL)
		throw std::invalid_argument(
			name(body) +
			" is a soft grain with degrees of freedom left to NewtonIntegrator: "
			"state.blockedDOFs = '" +
			string(body.state->blockedDOFs_vec_get()) +
			"'; admissible: 'xyzXYZ', which sg.soften() and sg.soft_disk() set "
			"(SoftGrainIntegrator moves the grain, in 2D within its plane)");
}

void checkPeriodic(const Body& body, const Scene& scene)
{
	if (isA<Wall>(body.shape))
		throw std::invalid_argument(
			name(body) +
			" is a Wall, but O.periodic = True: the collider of YADE never ends with "
			"its infinite box in a periodic cell; leave it out");
	if (isA<Box>(body.shape) && isSheared(scene))
		throw std::invalid_argument(name(body) +
					    " is a Box in a sheared periodic cell, where the "
					    "collider of YADE would end "
					    "the process; use Facets, or keep O.cell.hSize and "
					    "O.cell.velGrad diagonal");
}

/// Whether the material of a grain in an assembly is still what it was assembled with.
bool isAsAssembled(const SoftGrain& grain, const SoftMat& material)
{
	return grain.assembledConstants == material.constants() &&
	       grain.assembledDamping == material.damping() && grain.assembledLaw == material.law &&
	       grain.assembledCondition == material.condition;
}

/// The soft bodies of a scene, and the assembly of them all as they are, if there is one.
struct SoftScene {
	std::vector<Body*> bodies;
	std::shared_ptr<softgrain::GrainAssembly> assembly;
};

bool belongsTo(const softgrain::GrainAssembly* assembly, const Body& body)
{
	const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
	return assembly && grain.assembly.get() == assembly &&
	       assembly->idOf(grain.index) == body.getId() &&
	       isAsAssembled(grain, static_cast<const SoftMat&>(*body.material));
}

/// In one pass: all bodies are visited in every step, and most of it is waiting for memory.
SoftScene softScene(const Scene& scene)
{
	SoftScene soft;
	bool isCurrent = true;
	const BodyContainer& bodies = *scene.bodies;
	const int count = static_cast<int>(bodies.size());
	for (int id = 0; id < count; ++id) {
		fetchBodies(bodies, id, count, [](int i) { return i; });
		const shared_ptr<Body>& body = bodies[id];
		if (!body || !body->shape) continue;
		if (scene.isPeriodic) checkPeriodic(*body, scene);
		checkBody(*body);
		if (!isA<SoftGrain>(body->shape)) continue;
		if (soft.bodies.empty())
			soft.assembly = static_cast<SoftGrain&>(*body->shape).assembly;
		soft.bodies.push_back(body.get());
		isCurrent = isCurrent && belongsTo(soft.assembly.get(), *body);
	}
	const std::size_t assembled = soft.assembly ? soft.assembly->grains() : 0;
	if (!isCurrent || assembled != soft.bodies.size()) soft.assembly = nullptr;
	return soft;
}

/// What a grain goes on from; it is awake if its material changed since it was assembled.
softgrain::GrainDescription describePresent(const Body& body)
{
	SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
	const bool changed = grain.assembly &&
			     !isAsAssembled(grain, static_cast<const SoftMat&>(*body.material));
	grain.fetchState();
	if (grain.assembly) grain.savedForces.clear(); // materials may have changed
	softgrain::GrainDescription description = grain.describe(body);
	if (changed) {
		description.state.rest.clear();
		description.state.stiffening.clear();
	}
	return description;
}

/// Tells a grain its place in the assembly, and with what it went there.
void join(const Body& body, const std::shared_ptr<softgrain::GrainAssembly>& assembly, int index)
{
	SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
	const SoftMat& material = static_cast<const SoftMat&>(*body.material);
	grain.assembly = assembly;
	grain.index = index;
	grain.assembledConstants = material.constants();
	grain.assembledLaw = material.law;
	grain.assembledCondition = material.condition;
	grain.assembledDamping = material.damping();
	grain.written = assembly->motion(index);
	grain.writtenAsleep = false;
}

/// A SoftGrain holds the state of one grain; rigid shapes may stand for many.
void requireShapesOfTheirOwn(const std::vector<Body*>& bodies)
{
	std::map<const Shape*, const Body*> owner;
	for (const Body* body : bodies) {
		const auto [known, isNew] = owner.emplace(body->shape.get(), body);
		if (!isNew)
			throw std::invalid_argument(name(*known->second) + " and " + name(*body) +
						    " share one SoftGrain as their shape; give "
						    "each a SoftGrain of its own");
	}
}

std::shared_ptr<softgrain::GrainAssembly> assembleLocked(Scene& scene)
{
	const auto [bodies, current] = softScene(scene);
	if (bodies.empty()) return nullptr;
	checkHost(scene);
	if (current) return current;

	std::vector<softgrain::GrainDescription> grains;
	std::shared_ptr<softgrain::GrainAssembly> last;
	requireShapesOfTheirOwn(bodies);
	for (const Body* body : bodies) {
		const auto& present = static_cast<SoftGrain&>(*body->shape).assembly;
		if (present) last = present;
		grains.push_back(describePresent(*body));
	}
	const auto assembly = softgrain::GrainAssembly::create(grains, last.get());
	assembly->continueFrom(last ? last->continuation() : softgrain::Continuation());
	if (const auto* integrator = softGrainIntegratorOf(scene))
		assembly->setInterfaceRange(integrator->interfaceRange);
	for (int g = 0; g < assembly->grains(); ++g)
		join(*(*scene.bodies)[assembly->idOf(g)], assembly, g);
	return assembly;
}

} // namespace

std::shared_ptr<softgrain::GrainAssembly> assembleScene(Scene& scene)
{
	const std::lock_guard<std::mutex> lock(assemblyMutex);
	return assembleLocked(scene);
}

bool isSoftGrain(const Body& body) { return isA<SoftGrain>(body.shape); }

SoftGrain& grainOf(const Scene& scene, int id)
{
	return static_cast<SoftGrain&>(*(*scene.bodies)[id]->shape);
}

const SoftMat& materialOf(const Scene& scene, int id)
{
	return static_cast<const SoftMat&>(*(*scene.bodies)[id]->material);
}

std::string namesOf(const Interaction& I)
{
	return "bodies #" + std::to_string(I.getId1()) + " and #" + std::to_string(I.getId2());
}

SoftGrainIntegrator* softGrainIntegratorOf(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (const auto integrator = YADE_PTR_DYN_CAST<SoftGrainIntegrator>(engine))
			return integrator.get();
	return nullptr;
}

const NewtonIntegrator* liveNewtonIntegrator(const Engine& engine)
{
	return engine.dead ? nullptr : dynamic_cast<const NewtonIntegrator*>(&engine);
}

const NewtonIntegrator* newtonIntegratorOf(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (const auto* newton = liveNewtonIntegrator(*engine)) return newton;
	return nullptr;
}

bool isMoved(const Body& body, const NewtonIntegrator& newton)
{
	return newton.mask <= 0 || body.maskCompatible(newton.mask);
}

double defaultTimeStep()
{
	static const double step =
		Scene().dt; // a Scene is costly to make, and this is asked per pair
	return step;
}

std::optional<softgrain::Box<3>> outlineBox(const SoftGrain& shape, Scene& scene,
					    const softgrain::Mat3& map) noexcept
{
	try {
		const std::lock_guard<std::mutex> lock(assemblyMutex);
		if (!shape.assembly) assembleLocked(scene);
		if (!shape.assembly) return std::nullopt;
		return shape.assembly->box(shape.index, map);
	} catch (...) {
		return std::nullopt; // assembleScene throws the same again where it can be reported
	}
}

} // namespace yade
