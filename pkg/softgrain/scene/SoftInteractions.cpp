#include "scene/SoftInteractions.hpp"
#include "Threads.hpp"
#include "checks/DeepOverlap.hpp"
#include "classes/SoftContact.hpp"
#include "classes/SoftSearch.hpp"
#include "scene/Bodies.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/RigidPartners.hpp"
#include "scene/TouchedBodies.hpp"

#include <algorithm>
#include <cmath>

namespace yade {

using softgrain::Vec3;

namespace {

/// Whether an interaction of a soft grain is real, and of our functors; refuses what soft grains
/// cannot touch.
bool hasSoftContacts(Interaction& I, Kinds& kinds, const BodyContainer& bodies)
{
	const Kind kind1 = kinds[I.getId1()], kind2 = kinds[I.getId2()];
	if (kind1 == Kind::none || kind2 == Kind::none) return false;
	if (I.isReal() && !dynamic_cast<SoftGeom*>(I.geom.get())) return false;
	const auto &b1 = bodies[I.getId1()], &b2 = bodies[I.getId2()];
	const bool hasNoFunctor = !I.isReal() && !I.functorCache.geomExists;
	if (hasNoFunctor) I.functorCache.geomExists = true; // new engines may have one: look again
	if (kind1 == Kind::refused || (hasNoFunctor && kind1 != Kind::grain)) refusePair(*b2, *b1);
	if (kind2 == Kind::refused || hasNoFunctor) refusePair(*b1, *b2);
	return I.isReal();
}

/// How many turns of a pass before an interaction is looked at it is asked for.
constexpr std::size_t interactionsAhead = 24;

void fetch(const Interaction& I) { softgrain::fetchBytes(&I, &I + 1); }

/// In the k-th turn of a pass: asks for the interaction that will be looked at some turns later.
void fetchInteraction(const std::vector<Interaction*>& interactions, std::size_t k)
{
	if (k + interactionsAhead < interactions.size())
		fetch(*interactions[k + interactionsAhead]);
}

/// In the k-th turn of a pass: of interactions some turns away, what will be read of them. (Memory
/// takes some 100 ns to come, a turn of the shortest pass a tenth of that.)
void fetchAhead(const std::vector<Interaction*>& interactions, std::size_t k)
{
	constexpr std::size_t partsAhead = 16, pairAhead = 8;
	const std::size_t count = interactions.size();
	fetchInteraction(interactions, k);
	if (k + partsAhead < count) {
		const Interaction& I = *interactions[k + partsAhead];
		const auto* geom = static_cast<const SoftGeom*>(I.geom.get());
		const auto* phys = static_cast<const SoftPhys*>(I.phys.get());
		softgrain::fetchBytes(geom, geom + 1);
		softgrain::fetchBytes(phys, phys + 1);
	}
	if (k + pairAhead < count) {
		const auto* pair =
			static_cast<SoftGeom&>(*interactions[k + pairAhead]->geom).pair.get();
		const auto* begin = reinterpret_cast<const char*>(pair);
		softgrain::fetchBytes(begin, begin + softgrain::PairContacts::size2D);
	}
}

/// Of interactions of soft grains, those for which that holds.
std::vector<Interaction*> withSoftContacts(const std::vector<Interaction*>& ofGrains, Kinds& kinds,
					   const BodyContainer& bodies)
{
	constexpr std::size_t geometryAhead = 12;
	std::vector<Interaction*> found;
	for (std::size_t k = 0; k < ofGrains.size(); ++k) {
		if (k + geometryAhead < ofGrains.size())
			__builtin_prefetch(ofGrains[k + geometryAhead]->geom.get());
		if (hasSoftContacts(*ofGrains[k], kinds, bodies)) found.push_back(ofGrains[k]);
	}
	return found;
}

softgrain::PairContacts& pairOf(const Interaction& I)
{
	return *static_cast<SoftGeom&>(*I.geom).pair;
}

/// Change of the force on a wall over the way that it moves within a step, for engines that choose
/// that way (doc/decisions/0023-laboratory-loading.md): a wave gets no further than c dt by then,
/// so it is rho c A/dt, tens of times what a grain as a whole resists with.
Real stiffnessWithinStep(const SoftGrain& grain, const Scene& scene)
{
	const SoftMat& material = materialOf(scene, grain.assembly->idOf(grain.index));
	const Real diameter = 2 * grain.radius;
	return material.waveImpedance(grain.dim) *
	       (grain.dim == 2 ? diameter : diameter * diameter) / scene.dt;
}

/// What functions of YADE that know pairs of spheres go by. `normal` from #1 to #2.
void describePair(const Scene& scene, const Interaction& I, const Vec3& normal, SoftGeom& geom)
{
	const Body &b1 = *(*scene.bodies)[I.getId1()], &b2 = *(*scene.bodies)[I.getId2()];
	const bool ofGrains = geom.pair->isOfTwoGrains(); // shapes lie far from here in memory
	const bool soft1 = ofGrains || isSoftGrain(b1), soft2 = ofGrains || isSoftGrain(b2);
	const Vec3 second = b2.state->pos + imageShift(scene, I);
	geom.normal = normal;
	if (soft1) geom.refR1 = std::max(0., normal.dot(geom.contactPoint - b1.state->pos));
	if (soft2) geom.refR2 = std::max(0., normal.dot(second - geom.contactPoint));
	if (soft1 && !soft2 && !YADE_PTR_DYN_CAST<Sphere>(b2.shape)) geom.refR2 = geom.refR1;
	if (soft2 && !soft1 && !YADE_PTR_DYN_CAST<Sphere>(b1.shape)) geom.refR1 = geom.refR2;
}

Real frictionAngleOf(const Material& material)
{
	const auto* rigid = dynamic_cast<const FrictMat*>(&material);
	return rigid ? rigid->frictionAngle : static_cast<const SoftMat&>(material).frictionAngle;
}

/// What is wrong with the frictionAngle of a material, of which the functors, which must not throw,
/// made a coefficient of a pair that is no number; empty if nothing is.
string badAngleOf(const Scene& scene, const Interaction& I)
{
	if (!std::isnan(static_cast<const SoftPhys&>(*I.phys).tangensOfFrictionAngle)) return "";
	try {
		for (const Body::id_t id : { I.getId1(), I.getId2() }) {
			const Material& material = *(*scene.bodies)[id]->material;
			requireFrictionAngle("frictionAngle of " + material.getClassName() + " '" +
						     material.label + "'",
					     frictionAngleOf(material));
		}
	} catch (const std::invalid_argument& e) {
		return e.what();
	}
	return "";
}

} // namespace

template <class Belongs>
const std::vector<Interaction*>& InteractionOrder::of(InteractionContainer& all,
						      const Belongs& belongs)
{
	present_.clear();
	for (std::size_t k = 0; k < all.size(); ++k) {
		if (k + interactionsAhead < all.size()) fetch(*all[k + interactionsAhead]);
		if (belongs(*all[k])) present_.push_back(all[k].get());
	}
	if (present_ != sortedFrom_ || !isSorted()) {
		sortedFrom_ = sorted_ = present_;
		std::sort(sorted_.begin(), sorted_.end(), isBefore);
	}
	return sorted_;
}

bool InteractionOrder::isBefore(const Interaction* a, const Interaction* b)
{
	return std::minmax(a->getId1(), a->getId2()) < std::minmax(b->getId1(), b->getId2());
}

bool InteractionOrder::isSorted() const
{
	for (std::size_t k = 1; k < sorted_.size(); ++k) {
		fetchInteraction(sorted_, k);
		if (!isBefore(sorted_[k - 1], sorted_[k])) return false;
	}
	return true;
}

SoftInteractions::SoftInteractions(Scene& scene,
				   const std::shared_ptr<softgrain::GrainAssembly>& assembly,
				   InteractionOrder& order, const std::set<int>& moved)
	: scene_(scene)
	, assembly_(assembly)
{
	if (assembly->grains() == 0) return;
	assembly->host.searches.beginRun(scene.interactions->size());
	assembly->host.neighbours.forget();
	Kinds kinds(*scene.bodies, *assembly);
	const auto hasGrain = [&](const Interaction& I) {
		return kinds.isGrain(I.getId1()) || kinds.isGrain(I.getId2());
	};
	// the container's order depends on threads and history; sums of forces must not
	const auto& ofGrains = order.of(*scene.interactions, hasGrain);
	interactions_ = withSoftContacts(ofGrains, kinds, *scene.bodies);
	for (std::size_t k = 0; k < interactions_.size(); ++k) {
		fetchAhead(interactions_, k);
		renew(*interactions_[k], moved);
		pairs_.push_back(&pairOf(*interactions_[k]));
	}
}

/// Grains added, erased or changed since the InteractionLoop have other indices now, and contacts
/// found there name the old ones; those of grains that a script moved are at another place, and may
/// close faster than the search could know.
void SoftInteractions::renew(Interaction& I, const std::set<int>& moved) const
{
	const bool present = static_cast<SoftGeom&>(*I.geom).assembly == assembly_;
	if (present && !moved.count(I.getId1()) && !moved.count(I.getId2())) return;
	if (!I.functorCache.geom || !I.functorCache.constLaw)
		throw std::runtime_error(
			namesOf(I) +
			": their contacts have to be searched anew, which takes an InteractionLoop "
			"that has run since the scene was loaded; save between steps, where "
			"O.subStep = -1");
	const auto &b1 = (*scene_.bodies)[I.getId1()], &b2 = (*scene_.bodies)[I.getId2()];
	const shared_ptr<Interaction>& shared = scene_.interactions->find(I.getId1(), I.getId2());
	I.functorCache.geom->go(b1->shape, b2->shape, *b1->state, *b2->state, imageShift(scene_, I),
				true, shared);
	I.functorCache.constLaw->go(I.geom, I.phys, &I);
}

void SoftInteractions::check(Real maxOverlap) const
{
	checkRigidBodies();
	checkInterfaces();
	stopOnOverlap(maxOverlap);
}

void SoftInteractions::checkWall(const Interaction& I) const
{
	const Body& body = rigidBodyOf(I);
	const auto* wall = dynamic_cast<const Wall*>(body.shape.get());
	if (!wall) return;
	if (wall->axis == 2 && softGrainOf(I).dim == 2)
		throw std::runtime_error(namesOf(I) +
					 ": a Wall of axis = 2 lies in the plane of 2D soft "
					 "grains; admissible: 0, 1");
	for (int a = 0; a < 3; ++a)
		if (a != wall->axis && body.state->angVel[a] != 0)
			throw std::runtime_error(
				namesOf(I) + ": state.angVel[" + std::to_string(a) +
				"] = " + std::to_string(body.state->angVel[a]) +
				" 1/s of a Wall of axis = " + std::to_string(wall->axis) +
				", which turns about its normal only; admissible: 0. Use a Box or "
				"Facets");
}

/// Bodies that soft grains cannot touch as they stand.
void SoftInteractions::checkRigidBodies() const
{
	for (std::size_t k = 0; k < pairs_.size(); ++k) {
		const Interaction& I = *interactions_[k];
		if (pairs_[k]->isOfTwoGrains()) continue;
		checkWall(I);
		if (!pairs_[k]->hasRigidBody()) continue;
		const Body& body = rigidBodyOf(I);
		const auto described =
			describeRigid(*body.shape, *body.state, body.getId(), softGrainOf(I));
		if (described) assembly_->checkRigidBody(*described);
	}
}

void SoftInteractions::checkInterfaces() const
{
	for (std::size_t k = 0; k < pairs_.size(); ++k)
		try {
			pairs_[k]->checkInterface();
		} catch (const std::invalid_argument& e) {
			const Interaction& I = *interactions_[k];
			const string ofMaterial = badAngleOf(scene_, I);
			throw std::runtime_error("interaction of " + namesOf(I) + ": " +
						 (ofMaterial.empty() ? e.what() : ofMaterial));
		}
}

void SoftInteractions::stopOnOverlap(Real maxOverlap) const
{
	for (std::size_t k = 0; k < pairs_.size(); ++k) {
		const Real deepest = pairs_[k]->deepest();
		if (deepest <= maxOverlap) continue;
		throw std::runtime_error(
			messageOfOverlap(*interactions_[k], scene_, deepest, maxOverlap));
	}
}

void SoftInteractions::updateVelocities(const NewtonIntegrator& newton) const
{
	for (std::size_t k = 0; k < pairs_.size(); ++k) {
		const Interaction& I = *interactions_[k];
		softgrain::PairContacts& pair = *pairs_[k];
		if (scene_.isPeriodic) {
			const bool firstIsBody1 = assembly_->idOf(pair.firstGrain()) == I.getId1();
			pair.setImageVelocity(imageOf(scene_, I, firstIsBody1).velocity);
		} else if (!pair.isOfTwoGrains() && !pair.hasRigidBody())
			pair.setPlaneVelocity(motionOf(rigidBodyOf(I), newton));
	}
}

void SoftInteractions::numberPartners(RigidPartners& partners) const
{
	for (std::size_t k = 0; k < pairs_.size(); ++k)
		if (pairs_[k]->hasRigidBody())
			pairs_[k]->setPartner(partners.numberOf(rigidBodyOf(*interactions_[k])));
}

const Body& SoftInteractions::rigidBodyOf(const Interaction& I) const
{
	const auto &b1 = (*scene_.bodies)[I.getId1()], &b2 = (*scene_.bodies)[I.getId2()];
	return isSoftGrain(*b1) ? *b2 : *b1;
}

const SoftGrain& SoftInteractions::softGrainOf(const Interaction& I) const
{
	const Body::id_t rigid = rigidBodyOf(I).getId();
	return grainOf(scene_, I.getId1() == rigid ? I.getId2() : I.getId1());
}

void SoftInteractions::publish(const RigidPartners& partners, int threads) const
{
	const long count = static_cast<long>(interactions_.size());
	std::vector<PairForce> forces(count); // in one piece: what it is taken from lies far apart
#pragma omp parallel for schedule(static) num_threads(softgrain::threadsFor(count, threads))
	for (long k = 0; k < count; ++k) {
		fetchAhead(interactions_, k);
		const Interaction& I = *interactions_[k];
		if (!pairOf(I).isKept()) publishSum(I); // else it holds these forces already
		forces[k] = forceOf(I);
	}
	for (long k = 0; k < count; ++k) {
		const PairForce& force = forces[k];
		if (!force.rigid2) scene_.forces.addForce(force.id2, force.onBody2);
		if (!force.rigid1) scene_.forces.addForce(force.id1, -force.onBody2);
		if (force.rigid1 || force.rigid2) addReactions(*interactions_[k], partners);
	}
}

void SoftInteractions::publishSum(const Interaction& I) const
{
	SoftGeom& geom = static_cast<SoftGeom&>(*I.geom);
	SoftPhys& phys = static_cast<SoftPhys&>(*I.phys);
	const softgrain::SumOfImpulses sum = geom.pair->impulse();
	const bool firstIsBody2 = assembly_->idOf(geom.pair->firstGrain()) == I.getId2();
	const Real sign = firstIsBody2 ? 1 : -1,
		   onBody2 = sign / geom.pair->kick(); // forces act on body #2
	if (sum.contacts > 0) {                        // on the side of body #1
		geom.contactPoint = sum.point;
		if (firstIsBody2) geom.contactPoint += imageShift(scene_, I);
	}
	phys.normalForce = onBody2 * sum.normal;
	phys.shearForce = onBody2 * sum.shear;
	phys.contacts = sum.contacts;
	phys.activeContacts = sum.active;
	if (!sum.direction.isZero(0)) describePair(scene_, I, sign * sum.direction, geom);
	if (!geom.pair->isOfTwoGrains())
		phys.kn = phys.ks = stiffnessWithinStep(softGrainOf(I), scene_);
}

SoftInteractions::PairForce SoftInteractions::forceOf(const Interaction& I) const
{
	const SoftPhys& phys = static_cast<const SoftPhys&>(*I.phys);
	const int rigid = pairOf(I).hasRigidBody() ? rigidBodyOf(I).getId() : Body::ID_NONE;
	return { I.getId1(), I.getId2(), rigid == I.getId1(), rigid == I.getId2(),
		 phys.normalForce + phys.shearForce };
}

/// On a rigid body: a free one is to get the impulse itself, which NewtonIntegrator makes of a
/// force in the step dt; on others, and from sleepers, it is the mean force of the step.
void SoftInteractions::addReactions(const Interaction& I, const RigidPartners& partners) const
{
	const softgrain::SumOfImpulses sum = pairOf(I).impulse();
	const Body& body = rigidBodyOf(I);
	const bool free = partners.isFree(body);
	SoftPhys& phys = static_cast<SoftPhys&>(*I.phys);
	if (free) phys.kn = phys.ks = 0;
	if (sum.active == 0) return;
	const Real time = free && !pairOf(I).isKept() ? scene_.dt : pairOf(I).kick();
	scene_.forces.addForce(body.getId(), -(sum.normal + sum.shear) / time);
	const auto* wall = dynamic_cast<const Wall*>(body.shape.get());
	if (!wall || body.state->angVel[wall->axis] != 0) // else it has no place
		scene_.forces.addTorque(body.getId(), sum.moment / time);
}

} // namespace yade
