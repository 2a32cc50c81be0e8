#include "scene/RigidContacts.hpp"
#include "Require.hpp"
#include "assembly/RigidInKernel.hpp"
#include "classes/NonsmoothLaw.hpp"
#include "classes/SoftContact.hpp"
#include "classes/SoftSearch.hpp"
#include "scene/Bodies.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/RigidPartners.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <typeinfo>

namespace yade {

using softgrain::RigidContactDescription;
using softgrain::Vec3;

namespace {

/// Over `size`: places that near a plane lie in it, up to what overlaps and roundings leave.
constexpr Real seamTolerance = 1e-4;
/// Squared angle beyond the rounding of normals.
constexpr Real leaningNormal = 1e-12;

/// Stands for the spacing of material points where overlaps are measured, over the radius.
constexpr Real sizeOverRadius = 0.1;

/// (Functors for a shape are called for those derived from it too, as a GridConnection is from
/// Sphere, which are other bodies.)
template <class Form> const Form* as(const Body& body)
{
	const Shape* shape = body.shape.get();
	return shape && typeid(*shape) == typeid(Form) ? static_cast<const Form*>(shape) : nullptr;
}

const Sphere* asSphere(const Body& body) { return as<Sphere>(body); }

/// It bears nothing then.
void leaveOut(RigidContactDescription& d)
{
	d.friction = 0;
	d.impulse.setZero();
	d.gap = std::numeric_limits<Real>::infinity();
}

/// Place and gap; sphere against sphere anew, in the order of their ids to the last bit.
void describePlace(const Body& first, const Body& second, bool twoSpheres, const ScGeom& geom,
		   RigidContactDescription& d)
{
	const Real ball = asSphere(second)->radius;
	Real radius = ball;
	if (twoSpheres) {
		const Real other = asSphere(first)->radius;
		const Vec3 branch = second.state->pos + d.image.shift - first.state->pos;
		const Real distance = branch.norm();
		// two in one place have any normal
		d.normal = distance > 0 ? Vec3(branch / distance) : Vec3(Vec3::UnitX());
		d.gap = distance - other - ball;
		d.point = first.state->pos + (other + 0.5 * d.gap) * d.normal;
		radius = std::min(radius, other);
	} else {
		d.normal = geom.normal;
		d.gap = -geom.penetrationDepth;
		d.point = geom.contactPoint;
	}
	d.size = sizeOverRadius * radius;
}

/// A sphere that stays in a plane, as `mover` does (it or its clump), meets a facet that stands
/// upright in it where the plane cuts the facet: the nearest place of an edge that leans lies out
/// of the plane.
void keepInPlane(const Body& first, const Body& second, const Body& mover,
		 RigidContactDescription& d)
{
	const auto* facet = as<Facet>(first);
	constexpr double rounding = 1e-9; // of a unit normal that YADE computed
	if (!facet || !(mover.state->blockedDOFs & State::DOF_Z) ||
	    std::abs(d.normal.z()) < rounding)
		return;
	softgrain::RigidBodyDescription plate;
	plate.form = softgrain::RigidBodyDescription::Form::plate;
	plate.corner = cornersOf(*facet, *first.state);
	const Vec3 across =
		(plate.corner[1] - plate.corner[0]).cross(plate.corner[2] - plate.corner[0]);
	if (std::abs(across.z()) > rounding * across.norm()) return;
	const Vec3 centre = second.state->pos + d.image.shift;
	const auto place = softgrain::placeInPlane(plate, centre);
	const Real distance = place ? (centre - *place).norm() : 0;
	if (!(distance > 0)) {
		leaveOut(d);
		return;
	}
	d.normal = (centre - *place) / distance;
	d.gap = distance - asSphere(second)->radius;
	d.point = *place + 0.5 * d.gap * d.normal;
}

/// Members of a clump have no interaction with each other, nor with images of each other.
void checkClump(const Scene& scene, const Body& clump)
{
	const Real infinity = std::numeric_limits<Real>::infinity();
	Vector3r low = Vector3r::Constant(infinity), high = -low;
	for (const auto& [id, place] : static_cast<const Clump&>(*clump.shape).members) {
		const auto& bound = (*scene.bodies)[id]->bound;
		if (!bound) continue;
		low = low.cwiseMin(bound->min);
		high = high.cwiseMax(bound->max);
	}
	const Vector3r size = scene.cell->getSize();
	for (int axis = 0; axis < 3; ++axis) {
		if (!(high[axis] - low[axis] > size[axis])) continue;
		std::ostringstream message;
		message << "clump #" << clump.getId() << " spans " << high[axis] - low[axis]
			<< " m along base vector " << axis
			<< " of the periodic cell (with the margins of the collider), more than "
			<< "its length " << size[axis]
			<< " m: it might meet its own image, unnoticed. Use a larger cell";
		throw std::runtime_error(message.str());
	}
}

void checkSpans(const Scene& scene)
{
	if (!scene.isPeriodic) return;
	Vector3r longest = Vector3r::Zero();
	for (const auto& body : *scene.bodies) {
		if (body->isClump()) checkClump(scene, *body);
		if (!asSphere(*body)) continue;
		checkSpan(scene, *body, 3);
		if (body->bound) longest = longest.cwiseMax(spanInCell(scene, *body->bound));
	}
	for (const auto& body : *scene.bodies)
		if (body->bound && body->shape && !asSphere(*body) &&
		    dynamic_cast<const SoftGrain*>(body->shape.get()) == nullptr)
			checkRigidSpan(scene, *body, longest, 3, "sphere");
}

/// Where a contact lies on the surface of the first body, as the second sees it.
Vec3 placeOnSurface(const RigidContactDescription& d)
{
	return d.point - 0.5 * d.gap * d.normal - d.image.shift;
}

void requireOf(const Interaction& I, bool holds, const char* name, Real value, const char* range)
{
	// names are made only where they are needed: this is asked of each contact in each step
	if (!holds) softgrain::refuse(namesOf(I) + ": " + name, value, range);
}

/// By the materials of the pair; 0 where the law has none for them.
Real restitutionOf(const Law2_ScGeom_FrictPhys_Nonsmooth& law, const Interaction& I,
		   const Body& first, const Body& second)
{
	if (!law.restitution) return 0;
	const Real e = (*law.restitution)(first.material->id, second.material->id, 0, 0);
	requireOf(I, e >= 0 && e <= 1, "restitution", e, "[0, 1]");
	return e;
}

/// The law of O.engines has become another object. Interactions keep the functors that they began
/// with: those under a former such law go on under this one. Others that belong to it, and those
/// that are not real, which may have functors that do not look ahead, are made anew by the
/// InteractionLoop in the next step.
void adoptInteractions(const Scene& scene, const NonsmoothLaw& inUse)
{
	for (const auto& I : *scene.interactions) {
		if (dynamic_cast<SoftGeom*>(I->geom.get())) continue;
		auto& own = I->functorCache.constLaw;
		bool swap = false;
		if (!I->isReal())
			I->reset();
		else if (dynamic_cast<Law2_ScGeom_FrictPhys_Nonsmooth*>(own.get()))
			own = inUse.law;
		else if (inUse.dispatcher->getFunctor2D(I->geom, I->phys, swap) == inUse.law)
			I->reset();
	}
}

} // namespace

void RigidContacts::list(const Scene& scene)
{
	found_.clear();
	const NonsmoothLaw inUse = nonsmoothLawOf(scene);
	const auto& law = inUse.law;
	if (law && law != law_.lock()) adoptInteractions(scene, inUse);
	law_ = law;
	if (law)
		for (const auto& I : *scene.interactions) {
			if (!I->isReal() || I->functorCache.constLaw != law) continue;
			const auto [lower, higher] = std::minmax(I->getId1(), I->getId2());
			found_.push_back(
				{ std::uint64_t(lower) << 32 | std::uint64_t(higher), I.get() });
		}
	if (found_ != kept_) {
		interactions_ = found_;
		std::sort(interactions_.begin(), interactions_.end(),
			  [](const Listed& a, const Listed& b) { return a.ids < b.ids; });
		kept_.swap(found_);
	}
	if (law) checkSpans(scene);
}

RigidContacts::Pair RigidContacts::pairOf(const Interaction& I, const Scene& scene)
{
	const Body *body1 = (*scene.bodies)[I.getId1()].get(),
		   *body2 = (*scene.bodies)[I.getId2()].get();
	const bool twoSpheres = asSphere(*body1) && asSphere(*body2);
	if (twoSpheres && I.getId2() < I.getId1()) return { body2, body1, true, true };
	return { body1, body2, twoSpheres, false };
}

void RigidContacts::requireTreatable(const Interaction& I, const Pair& pair)
{
	const Body& first = *pair.first;
	for (const Body* body : { pair.first, pair.second })
		if (!body->shape || !body->material)
			throw std::runtime_error(namesOf(I) + " meet, but body #" +
						 std::to_string(body->getId()) +
						 " has no shape or no material any more");
	const bool treatable =
		asSphere(first) || as<Facet>(first) || as<Box>(first) || as<Wall>(first);
	if (!treatable || !asSphere(*pair.second))
		throw std::runtime_error(
			namesOf(I) + " (" + pair.first->shape->getClassName() + " and " +
			pair.second->shape->getClassName() +
			") meet under Law2_ScGeom_FrictPhys_Nonsmooth, which is for a "
			"Sphere against a Sphere, Facet, Box or Wall");
	const Real friction = static_cast<const FrictPhys&>(*I.phys).tangensOfFrictionAngle;
	requireOf(I, friction >= 0 && std::isfinite(friction), "tangensOfFrictionAngle", friction,
		  "[0, inf)");
}

void RigidContacts::describe(const Scene& scene, RigidPartners& partners, Real maxOverlap)
{
	const auto law = law_.lock();
	pairs_.clear();
	contacts_.resize(interactions_.size());
	for (std::size_t k = 0; k < interactions_.size(); ++k) {
		const Interaction& I = *interactions_[k].interaction;
		const Pair& pair = pairs_.emplace_back(pairOf(I, scene));
		requireTreatable(I, pair);
		const FrictPhys& phys = static_cast<const FrictPhys&>(*I.phys);
		RigidContactDescription& d = contacts_[k];
		d.image = imageOf(scene, I, !pair.swapped);
		describePlace(*pair.first, *pair.second, pair.twoSpheres,
			      static_cast<const ScGeom&>(*I.geom), d);
		d.first = partners.numberOf(*pair.first);
		d.second = partners.numberOf(*pair.second);
		d.friction = phys.tangensOfFrictionAngle;
		d.restitution = restitutionOf(*law, I, *pair.first, *pair.second);
		d.impulse = (pair.swapped ? -scene.dt : scene.dt) *
			    (phys.normalForce + phys.shearForce);
		keepInPlane(*pair.first, *pair.second, partners.moverOf(*pair.second), d);
		if (d.first == d.second) leaveOut(d); // they became members of one clump
	}
	stopOnOverlap(partners, maxOverlap);
	leaveSeamsOut();
}

void RigidContacts::stopOnOverlap(const RigidPartners& partners, Real maxOverlap) const
{
	for (std::size_t k = 0; k < contacts_.size(); ++k) {
		const RigidContactDescription& d = contacts_[k];
		if (-d.gap <= maxOverlap * d.size) continue;
		if (partners.isHeld(d.first) && partners.isHeld(d.second)) continue;
		std::ostringstream message;
		message << "rigid " << namesOf(*interactions_[k].interaction) << " overlap by "
			<< -d.gap / d.size * sizeOverRadius << " radii of the smaller, more than "
			<< sizeOverRadius << " maxOverlap = " << sizeOverRadius * maxOverlap
			<< ". Hint: start from less overlap, reduce O.dt or tolerance, or "
			   "load more slowly";
		throw std::runtime_error(message.str());
	}
}

Real RigidContacts::deepestOverlap() const
{
	Real deepest = 0;
	for (const RigidContactDescription& d : contacts_)
		deepest = std::max(deepest, -d.gap / d.size);
	return sizeOverRadius * deepest;
}

void RigidContacts::listContactsOnPlates()
{
	onPlates_.clear();
	for (std::size_t k = 0; k < contacts_.size(); ++k) {
		const Pair& pair = pairs_[k];
		if (pair.twoSpheres || as<Wall>(*pair.first)) continue;
		onPlates_.push_back({ pair.second->getId(), static_cast<int>(k) });
	}
	std::sort(onPlates_.begin(), onPlates_.end());
}

/// Whether a contact of a sphere lies in the plane of another one of its contacts, which is no
/// farther off, but leans against it.
bool RigidContacts::isSeam(const RigidContactDescription& d, int sphere) const
{
	const Vec3 place = placeOnSurface(d);
	const auto [begin, end] =
		std::equal_range(onPlates_.begin(), onPlates_.end(), std::make_pair(sphere, 0),
				 [](const auto& a, const auto& b) { return a.first < b.first; });
	return std::any_of(begin, end, [&](const auto& other) {
		const RigidContactDescription& o = contacts_[other.second];
		const bool leans = (d.normal - o.normal).squaredNorm() > leaningNormal;
		return leans && d.gap >= o.gap &&
		       std::abs((place - placeOnSurface(o)).dot(o.normal)) < seamTolerance * d.size;
	});
}

/// A sphere that lies on a facet (box) beside another touches the edge of that other one only at a
/// place in the plane that it lies on already: such a contact, whose normal leans, would stop it at
/// the seam. It is taken to bear nothing.
void RigidContacts::leaveSeamsOut()
{
	listContactsOnPlates();
	for (const auto& [sphere, k] : onPlates_) {
		RigidContactDescription& d = contacts_[k];
		if (isSeam(d, sphere)) leaveOut(d);
	}
}

void RigidContacts::addReaction(const Body& body, const Vector3r& arm, const Vector3r& force)
{
	Reaction& sum = reactions_[body.getId()];
	sum.force += force;
	sum.torque += arm.cross(force);
}

void RigidContacts::publish(Scene& scene)
{
	if (contacts_.empty()) return;
	reactions_.assign(scene.bodies->size(), Reaction());
	for (std::size_t k = 0; k < contacts_.size(); ++k) {
		const RigidContactDescription& d = contacts_[k];
		const Pair& pair = pairs_[k];
		const Vector3r force = d.impulse / scene.dt;
		FrictPhys& phys = static_cast<FrictPhys&>(*interactions_[k].interaction->phys);
		const Vector3r onBody2 = pair.swapped ? Vector3r(-force) : force;
		phys.normalForce = onBody2.dot(d.normal) * d.normal;
		phys.shearForce = onBody2 - phys.normalForce;
		if (force.isZero(0)) continue;
		addReaction(*pair.first, d.point - pair.first->state->pos, -force);
		addReaction(*pair.second, d.point - pair.second->state->pos - d.image.shift, force);
	}
	for (std::size_t id = 0; id < reactions_.size(); ++id) {
		const Reaction& sum = reactions_[id];
		if (sum.force.isZero(0) && sum.torque.isZero(0)) continue;
		scene.forces.addForce(static_cast<int>(id), sum.force);
		scene.forces.addTorque(static_cast<int>(id), sum.torque);
	}
}

} // namespace yade
