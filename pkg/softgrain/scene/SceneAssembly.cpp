#include "scene/SceneAssembly.hpp"
#include "Fetch.hpp"
#include "Threads.hpp"
#include "checks/BodyChecks.hpp"
#include "checks/Engines.hpp"
#include "checks/HostChecks.hpp"
#include "classes/SoftContact.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "classes/SoftMat.hpp"
#include "scene/Bodies.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/StateChange.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>

namespace yade {

namespace {

std::mutex assemblyMutex;

/// What a thread does with so many, 20 to 25 ns each, takes about as long as waking it.
constexpr int bodiesPerThread = 1000;

const SoftMat& softMaterial(const Body& body)
{
	return static_cast<const SoftMat&>(*body.material);
}

/// Whether materials are still what their grains were assembled with. Many grains share one, which
/// is looked at once for those that follow each other.
class MaterialCheck {
public:
	bool passes(const SoftMat& material, const AssembledMaterial& assembled)
	{
		if (&material == material_ && &assembled == assembled_) return passed_;
		material_ = &material;
		assembled_ = &assembled;
		return passed_ = material.isAs(assembled);
	}

private:
	const SoftMat* material_ = nullptr;
	const AssembledMaterial* assembled_ = nullptr;
	bool passed_ = false;
};

/// Whether a grain is in an assembly, and as it was when it went there.
bool isInAssembly(const Body& body, MaterialCheck& materials)
{
	const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
	return grain.assembly && grain.assembly->idOf(grain.index) == body.getId() &&
	       materials.passes(softMaterial(body), *grain.assembledMaterial);
}

/// For parallel loops, which nothing may leave.
bool passes(const Body& body, const Scene& scene) noexcept
{
	try {
		checkBody(body, scene);
		return true;
	} catch (const std::invalid_argument&) {
		return false;
	}
}

/// In a pass over all bodies, most of which have nothing to do: it would wait for memory at every
/// one unless it asks for it ahead. What the pass reads of a SoftGrain is all up to `radius`;
/// of another shape as much is asked for, and none of it looked at.
void fetchBodiesAfter(const BodyContainer& bodies, int id)
{
	constexpr int bodyAhead = 12, partsAhead = 6;
	const int count = static_cast<int>(bodies.size());
	if (id + bodyAhead < count) {
		const Body* body = bodies[id + bodyAhead].get();
		softgrain::fetchBytes(body, body + 1);
	}
	const Body* body = id + partsAhead < count ? bodies[id + partsAhead].get() : nullptr;
	if (!body || !body->shape) return;
	const auto* grain = static_cast<const SoftGrain*>(body->shape.get());
	softgrain::fetchBytes(grain, &grain->radius + 1);
	const State* state = body->state.get();
	softgrain::fetchBytes(&state->se3, &state->angVel + 1);
	softgrain::fetchBytes(&state->blockedDOFs, &state->blockedDOFs + 1);
}

/// The soft grains of a scene.
struct SoftScene {
	int grains = 0;
	int unbounded = -1; ///< HostNotes::unbounded
	bool hasPlates = false;
	/// Of them all, as they are; null if there is none.
	std::shared_ptr<softgrain::GrainAssembly> assembly;
};

/// Who asks for the assembly. What is noted of bodies is for the next search, and would be gone
/// before it if each who asks between two steps noted it anew.
enum class Asked { byStep, between };

/// Throws std::invalid_argument for the first body that cannot be in the scene, and tells the
/// assembly which grains were moved. In one pass: all bodies are visited in every step, and most of
/// it is waiting for memory.
SoftScene softScene(const Scene& scene, int threads, Asked asked)
{
	const BodyContainer& bodies = *scene.bodies;
	const int count = static_cast<int>(bodies.size());
	int faulty = count, first = count, unbounded = count, grains = 0, inAssembly = 0;
	std::uintptr_t lowest = UINTPTR_MAX, highest = 0; // of the assemblies: are they one?
	bool hasPlates = false;
	MaterialCheck materials;
#pragma omp parallel for schedule(static) reduction(min : faulty, first, unbounded, lowest)        \
	reduction(max : highest) reduction(+ : grains, inAssembly) reduction(|| : hasPlates)       \
	firstprivate(materials)                                                                    \
	num_threads(softgrain::threadsFor(count, threads, bodiesPerThread))
	for (int id = 0; id < count; ++id) {
		if (faulty < id) continue; // one is enough
		fetchBodiesAfter(bodies, id);
		const Body* body = bodies[id].get();
		if (!body || !body->shape) continue;
		if (!passes(*body, scene)) {
			faulty = id;
			continue;
		}
		if (mayLackBound(*body)) unbounded = std::min(unbounded, id);
		if (!isSoftGrain(*body)) {
			hasPlates = hasPlates || isPlate(*body->shape);
			continue;
		}
		const SoftGrain& grain = static_cast<const SoftGrain&>(*body->shape);
		const auto assembly = reinterpret_cast<std::uintptr_t>(grain.assembly.get());
		first = std::min(first, id);
		lowest = std::min(lowest, assembly);
		highest = std::max(highest, assembly);
		++grains;
		if (!isInAssembly(*body, materials)) continue;
		++inAssembly;
		if (asked == Asked::byStep)
			grain.assembly->host.moved[grain.index] = !isAsWritten(*body);
	}
	if (faulty < count) checkBody(*bodies[faulty], scene);
	SoftScene soft { grains, unbounded < count ? unbounded : -1, hasPlates, nullptr };
	if (grains == 0 || lowest != highest || inAssembly != grains) return soft;
	const auto& assembly = static_cast<SoftGrain&>(*bodies[first]->shape).assembly;
	if (assembly->grains() == grains) soft.assembly = assembly;
	return soft;
}

/// (A cell that is changed by hand may bring sleepers to each other's images; while it flows none
/// sleeps, and there is nothing to look at.)
void noteBodies(const SoftScene& soft, const Scene& scene, softgrain::HostNotes& host)
{
	host.unbounded = soft.unbounded;
	host.hasPlates = soft.hasPlates;
	if (!scene.isPeriodic || scene.cell->hSize == host.cell) return;
	host.cell = scene.cell->hSize;
	if (comingVelGrad(scene).isZero(0)) std::fill(host.moved.begin(), host.moved.end(), true);
}

std::vector<Body*> softBodies(const Scene& scene)
{
	std::vector<Body*> soft;
	for (const shared_ptr<Body>& body : *scene.bodies)
		if (isSoftGrain(*body)) soft.push_back(body.get());
	return soft;
}

/// What a grain goes on from; it is awake if its material changed since it was assembled.
softgrain::GrainDescription describePresent(const Body& body)
{
	SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
	const bool changed = grain.assembly && !softMaterial(body).isAs(*grain.assembledMaterial);
	grain.fetchState();
	if (changed) grain.savedForces.clear();
	softgrain::GrainDescription description = grain.describe(body);
	if (description.state.x.empty()) requireFirstMotion(body);
	if (changed) {
		description.state.rest.clear();
		description.state.stiffening.clear();
	}
	return description;
}

/// Tells the grains of a scene their places in the assembly, and with what they went there.
void join(const Scene& scene, const std::shared_ptr<softgrain::GrainAssembly>& assembly)
{
	std::map<const SoftMat*, std::shared_ptr<const AssembledMaterial>> assembled;
	for (int g = 0; g < assembly->grains(); ++g) {
		const int id = assembly->idOf(g);
		SoftGrain& grain = grainOf(scene, id);
		const SoftMat& material = materialOf(scene, id);
		auto& shared = assembled[&material];
		if (!shared)
			shared = std::make_shared<const AssembledMaterial>(material.assembled());
		grain.assembly = assembly;
		grain.index = g;
		grain.assembledMaterial = shared;
		grain.written = assembly->motion(g);
	}
}

/// Pairs that come near without a contact keep their geometry, and with it their assembly.
void forgetLastAssembly(Scene& scene)
{
	for (const auto& I : *scene.interactions)
		if (I && !I->isReal() && isA<SoftGeom>(I->geom)) I->geom.reset();
}

/// A SoftGrain holds the state of one grain; rigid shapes may stand for many.
void requireShapesOfTheirOwn(const std::vector<Body*>& bodies)
{
	std::map<const Shape*, const Body*> owner;
	for (const Body* body : bodies) {
		const auto [known, isNew] = owner.emplace(body->shape.get(), body);
		if (!isNew)
			throw std::invalid_argument(nameOf(*known->second) + " and " +
						    nameOf(*body) +
						    " share one SoftGrain as their shape; give "
						    "each a SoftGrain of its own");
	}
}

/// Whether `isFit` has found in this step, and nobody asked since, that the engines are as they
/// should be.
bool isCheckedHost(const SoftScene& soft, const Scene& scene)
{
	if (!soft.assembly) return false;
	softgrain::HostNotes& host = soft.assembly->host;
	return host.checkedIn.exchange(-1) == scene.iter && !host.isUnfit;
}

std::shared_ptr<softgrain::GrainAssembly> assembleLocked(Scene& scene, int threads, Asked asked)
{
	const SoftScene soft = softScene(scene, threads, asked);
	if (soft.grains == 0) return nullptr;
	if (!isCheckedHost(soft, scene)) checkHost(scene);
	if (soft.assembly) {
		if (asked == Asked::byStep) noteBodies(soft, scene, soft.assembly->host);
		soft.assembly->host.setFit(true);
		return soft.assembly;
	}

	std::vector<softgrain::GrainDescription> grains;
	std::shared_ptr<softgrain::GrainAssembly> last;
	const std::vector<Body*> bodies = softBodies(scene);
	requireShapesOfTheirOwn(bodies);
	for (const Body* body : bodies) {
		const auto& before = static_cast<SoftGrain&>(*body->shape).assembly;
		if (before) last = before;
		grains.push_back(describePresent(*body));
	}
	const auto assembly = softgrain::GrainAssembly::create(grains, last.get());
	assembly->continueFrom(last ? last->continuation() : softgrain::Continuation());
	if (const auto* integrator = softGrainIntegratorOf(scene))
		assembly->setInterfaceRange(integrator->interfaceRange);
	join(scene, assembly);
	if (last) forgetLastAssembly(scene);
	if (asked == Asked::byStep) noteBodies(soft, scene, assembly->host);
	return assembly;
}

} // namespace

std::shared_ptr<softgrain::GrainAssembly> assembleScene(Scene& scene)
{
	const std::lock_guard<std::mutex> lock(assemblyMutex);
	return assembleLocked(scene, 1, Asked::between);
}

std::shared_ptr<softgrain::GrainAssembly> assembleForStep(Scene& scene, int threads)
{
	const std::lock_guard<std::mutex> lock(assemblyMutex);
	return assembleLocked(scene, threads, Asked::byStep);
}

bool isFit(softgrain::GrainAssembly& assembly, const Scene& scene) noexcept
{
	softgrain::HostNotes& host = assembly.host;
	if (host.checkedIn.load(std::memory_order_acquire) != scene.iter) {
		const std::lock_guard<std::mutex> lock(assemblyMutex);
		if (host.checkedIn.load(std::memory_order_relaxed) != scene.iter) {
			try {
				checkHost(scene);
				host.setFit(true);
			} catch (...) { // the step tells why
				host.setFit(false);
			}
			host.checkedIn.store(scene.iter, std::memory_order_release);
		}
	}
	return !host.isUnfit;
}

AssembledGrain assembledGrain(const SoftGrain& shape)
{
	const std::lock_guard<std::mutex> lock(assemblyMutex);
	return { shape.assembly, shape.index };
}

AssembledGrain assembledGrain(const SoftGrain& shape, Scene& scene) noexcept
{
	const std::lock_guard<std::mutex> lock(assemblyMutex);
	try {
		if (!shape.assembly) assembleLocked(scene, 1, Asked::between);
	} catch (...) { // assembleForStep throws the same again where it can be reported
	}
	return { shape.assembly, shape.index };
}

} // namespace yade
