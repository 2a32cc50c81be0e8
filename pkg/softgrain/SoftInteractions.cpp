#include "SoftInteractions.hpp"
#include "PeriodicCell.hpp"
#include "RigidPartners.hpp"
#include "SceneAssembly.hpp"
#include "SoftContact.hpp"
#include "SoftSearch.hpp"
#include "Threads.hpp"

#include <algorithm>
#include <sstream>
#include <typeinfo>

namespace yade {

using softgrain::Vec3;

namespace {

/// Functors for a shape are called for those derived from it too, as a Cylinder is from Sphere.
bool isTouched(const Shape& shape)
{
	const auto& type = typeid(shape);
	return type == typeid(SoftGrain) || type == typeid(Wall) || type == typeid(Sphere) ||
	       type == typeid(Facet) || type == typeid(Box);
}

[[noreturn]] void refusePair(const Body& grain, const Body& other)
{
	const string shape = other.shape->getClassName();
	throw std::runtime_error(
		"soft grain #" + std::to_string(grain.getId()) + " comes near body #" +
		std::to_string(other.getId()) + " of shape " + shape +
		(isTouched(*other.shape)
			 ? ", for which the InteractionLoop has no Ig2 functor: add "
			   "Ig2_SoftGrain_SoftGrain_SoftGeom, Ig2_Wall_SoftGrain_SoftGeom, "
			   "Ig2_Sphere_SoftGrain_SoftGeom ..., or see sg.engines()"
			 : ". Soft grains touch SoftGrain, Wall, Sphere, Facet and Box only"));
}

/// Whether an interaction is a real one of soft grains; refuses what soft grains cannot touch.
bool isOfSoftGrains(const Interaction& I, const Body& b1, const Body& b2)
{
	if (I.isReal()) {
		if (!dynamic_cast<SoftGeom*>(I.geom.get())) return false;
		if (!isTouched(*b1.shape)) refusePair(b2, b1);
		if (!isTouched(*b2.shape)) refusePair(b1, b2);
		return true;
	}
	const bool soft1 = isSoftGrain(b1), soft2 = isSoftGrain(b2);
	if (!soft1 && !soft2) return false;
	const Body &grain = soft1 ? b1 : b2, &other = soft1 ? b2 : b1;
	if (!I.functorCache.geomExists || !isTouched(*other.shape)) refusePair(grain, other);
	return false;
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
	const bool soft1 = isSoftGrain(b1), soft2 = isSoftGrain(b2);
	const Vec3 second = b2.state->pos + imageShift(scene, I);
	geom.normal = normal;
	if (soft1) geom.refR1 = std::max(0., normal.dot(geom.contactPoint - b1.state->pos));
	if (soft2) geom.refR2 = std::max(0., normal.dot(second - geom.contactPoint));
	if (soft1 && !soft2 && !YADE_PTR_DYN_CAST<Sphere>(b2.shape)) geom.refR2 = geom.refR1;
	if (soft2 && !soft1 && !YADE_PTR_DYN_CAST<Sphere>(b1.shape)) geom.refR1 = geom.refR2;
}

} // namespace

SoftInteractions::SoftInteractions(Scene& scene,
				   const std::shared_ptr<softgrain::GrainAssembly>& assembly)
	: scene_(scene)
	, assembly_(assembly)
{
	if (assembly->grains() == 0) return;
	for (const auto& I : *scene.interactions) {
		const auto &b1 = (*scene.bodies)[I->getId1()], &b2 = (*scene.bodies)[I->getId2()];
		if (b1 && b2 && isOfSoftGrains(*I, *b1, *b2)) interactions_.push_back(I.get());
	}
	// the container's order depends on threads and history; sums of forces must not
	std::sort(interactions_.begin(), interactions_.end(),
		  [](const Interaction* a, const Interaction* b) {
			  return std::minmax(a->getId1(), a->getId2()) <
				 std::minmax(b->getId1(), b->getId2());
		  });
}

void SoftInteractions::renew(const std::set<int>& wrapped) const
{
	for (Interaction* I : interactions_) {
		const bool present = static_cast<SoftGeom&>(*I->geom).assembly == assembly_;
		if (present && !wrapped.count(I->getId1()) && !wrapped.count(I->getId2())) continue;
		const auto& b1 = (*scene_.bodies)[I->getId1()];
		const auto& b2 = (*scene_.bodies)[I->getId2()];
		const shared_ptr<Interaction>& shared =
			scene_.interactions->find(I->getId1(), I->getId2());
		I->functorCache.geom->go(b1->shape, b2->shape, *b1->state, *b2->state,
					 imageShift(scene_, *I), true, shared);
		I->functorCache.constLaw->go(I->geom, I->phys, I);
	}
}

void SoftInteractions::check(Real maxOverlap) const
{
	checkRigidBodies();
	checkInterfaces();
	stopOnOverlap(maxOverlap);
}

/// Bodies that soft grains cannot touch as they stand.
void SoftInteractions::checkRigidBodies() const
{
	for (const Interaction* I : interactions_) {
		if (!pairOf(*I).hasRigidBody()) continue;
		const Body& body = rigidBodyOf(*I);
		const auto described =
			describeRigid(*body.shape, *body.state, body.getId(), softGrainOf(*I));
		if (described) assembly_->checkRigidBody(*described);
	}
}

void SoftInteractions::checkInterfaces() const
{
	for (const Interaction* I : interactions_)
		try {
			pairOf(*I).checkInterface();
		} catch (const std::invalid_argument& e) {
			throw std::runtime_error("interaction of " + namesOf(*I) + ": " + e.what());
		}
}

void SoftInteractions::stopOnOverlap(Real maxOverlap) const
{
	for (const Interaction* I : interactions_) {
		const Real deepest = pairOf(*I).deepest();
		if (deepest <= maxOverlap) continue;
		std::ostringstream message;
		message << namesOf(*I) << " overlap by " << deepest
			<< " point spacings, more than maxOverlap = " << maxOverlap
			<< ". Hint: start from less overlap (sg.soften(overlap='shrink')), load "
			   "more slowly, or reduce tolerance";
		throw std::runtime_error(message.str());
	}
}

void SoftInteractions::moveImages() const
{
	if (!scene_.isPeriodic) return;
	for (const Interaction* I : interactions_) {
		softgrain::PairContacts& pair = pairOf(*I);
		const bool firstIsBody1 = assembly_->idOf(pair.firstGrain()) == I->getId1();
		pair.setImageVelocity(imageOf(scene_, *I, firstIsBody1).velocity);
	}
}

void SoftInteractions::numberPartners(RigidPartners& partners) const
{
	for (const Interaction* I : interactions_) {
		softgrain::PairContacts& pair = pairOf(*I);
		if (pair.hasRigidBody()) pair.setPartner(partners.numberOf(rigidBodyOf(*I)));
	}
}

std::vector<softgrain::PairContacts*> SoftInteractions::pairs() const
{
	std::vector<softgrain::PairContacts*> pairs;
	for (const Interaction* I : interactions_)
		pairs.push_back(&pairOf(*I));
	return pairs;
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
		   onBody2 = sign / geom.pair->kick();       // forces act on body #2
	if (sum.contacts > 0) geom.contactPoint = sum.point; // on the side of body #1
	if (firstIsBody2) geom.contactPoint += imageShift(scene_, I);
	phys.normalForce = onBody2 * sum.normal;
	phys.shearForce = onBody2 * sum.shear;
	phys.contacts = sum.contacts;
	phys.activeContacts = sum.active;
	if (!sum.direction.isZero(0)) describePair(scene_, I, sign * sum.direction, geom);
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
	phys.kn = phys.ks = free ? 0 : stiffnessWithinStep(softGrainOf(I), scene_);
	if (sum.active == 0) return;
	const Real time = free && !pairOf(I).isKept() ? scene_.dt : pairOf(I).kick();
	scene_.forces.addForce(body.getId(), -(sum.normal + sum.shear) / time);
	if (!YADE_PTR_DYN_CAST<Wall>(body.shape)) // which has no place, and cannot turn
		scene_.forces.addTorque(body.getId(), sum.moment / time);
}

} // namespace yade
