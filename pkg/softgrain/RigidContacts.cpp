// Contacts of rigid bodies with each other in a step: from YADE's interactions to the kernel, and
// the forces back.
#include "NonsmoothLaw.hpp"
#include "SceneAssembly.hpp"
#include "SoftGrainIntegrator.hpp"

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

/// The law, if O.engines have it.
const LawFunctor* nonsmoothLaw(const Scene& scene)
{
	for (const auto& engine : scene.engines) {
		const auto* loop = dynamic_cast<const InteractionLoop*>(engine.get());
		if (!loop) continue;
		for (const auto& law : loop->lawDispatcher->functors)
			if (dynamic_cast<const Law2_ScGeom_FrictPhys_Nonsmooth*>(law.get()))
				return law.get();
	}
	return nullptr;
}

/// Most shapes are a Sphere itself, which is told at little cost.
const Sphere* asSphere(const Body& body)
{
	const Shape* shape = body.shape.get();
	return shape && typeid(*shape) == typeid(Sphere) ? static_cast<const Sphere*>(shape)
							 : dynamic_cast<const Sphere*>(shape);
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
		d.normal = branch / distance;
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

bool isHeld(const softgrain::RigidMotionDescription& motion)
{
	return motion.inverseMass.isZero(0) && motion.inverseInertia.isZero(0);
}

std::string namesOf(const Interaction& I)
{
	return "bodies #" + std::to_string(I.getId1()) + " and #" + std::to_string(I.getId2());
}

} // namespace

/// Whether O.engines have the law; its interactions in the order of the sweeps, which must not
/// depend on threads.
bool SoftGrainIntegrator::listRigidContacts()
{
	found_.clear();
	const LawFunctor* law = nonsmoothLaw(*scene);
	if (law)
		for (const auto& I : *scene->interactions) {
			if (!I->isReal() || I->functorCache.constLaw.get() != law) continue;
			const auto [lower, higher] = std::minmax(I->getId1(), I->getId2());
			found_.push_back(
				{ std::uint64_t(lower) << 32 | std::uint64_t(higher), I.get() });
		}
	if (found_ != kept_) {
		rigidInteractions_ = found_;
		std::sort(rigidInteractions_.begin(), rigidInteractions_.end(),
			  [](const RigidInteraction& a, const RigidInteraction& b) {
				  return a.ids < b.ids;
			  });
		kept_.swap(found_);
	}
	if (law && scene->isPeriodic) checkRigidSpans();
	return law;
}

void SoftGrainIntegrator::checkRigidSpans() const
{
	for (const auto& body : *scene->bodies)
		if (body && asSphere(*body)) checkSpan(*scene, *body, 3);
}

SoftGrainIntegrator::RigidPair SoftGrainIntegrator::pairOf(const Interaction& I, const Scene& scene)
{
	const Body *body1 = (*scene.bodies)[I.getId1()].get(),
		   *body2 = (*scene.bodies)[I.getId2()].get();
	const bool twoSpheres = asSphere(*body1);
	if (twoSpheres && I.getId2() < I.getId1()) return { body2, body1, true, true };
	return { body1, body2, twoSpheres, false };
}

/// Numbers the bodies and describes the contacts. O.forces hold all that else acts on the bodies.
void SoftGrainIntegrator::describeRigidContacts()
{
	rigidPairs_.clear();
	rigidContacts_.resize(rigidInteractions_.size());
	for (std::size_t k = 0; k < rigidInteractions_.size(); ++k) {
		const Interaction& I = *rigidInteractions_[k].interaction;
		const RigidPair& pair = rigidPairs_.emplace_back(pairOf(I, *scene));
		const FrictPhys& phys = static_cast<const FrictPhys&>(*I.phys);
		if (!asSphere(*pair.second))
			throw std::runtime_error(
				namesOf(I) + " (" + pair.first->shape->getClassName() + " and " +
				pair.second->shape->getClassName() +
				") meet under Law2_ScGeom_FrictPhys_Nonsmooth, which is for a "
				"Sphere against a Sphere, Facet, Box or Wall");
		if (!(phys.tangensOfFrictionAngle >= 0))
			throw std::runtime_error(namesOf(I) + ": tangensOfFrictionAngle = " +
						 std::to_string(phys.tangensOfFrictionAngle) +
						 " is outside the admissible range [0, inf)");
		RigidContactDescription& d = rigidContacts_[k];
		d.image = imageOf(*scene, I, !pair.swapped);
		describePlace(*pair.first, *pair.second, pair.twoSpheres,
			      static_cast<const ScGeom&>(*I.geom), d);
		d.first = numberOf(*pair.first);
		d.second = numberOf(*pair.second);
		d.friction = phys.tangensOfFrictionAngle;
		d.impulse = (pair.swapped ? -scene->dt : scene->dt) *
			    (phys.normalForce + phys.shearForce);
	}
	stopOnRigidOverlap();
	leaveSeamsOut();
}

void SoftGrainIntegrator::stopOnRigidOverlap() const
{
	for (std::size_t k = 0; k < rigidContacts_.size(); ++k) {
		const RigidContactDescription& d = rigidContacts_[k];
		if (-d.gap <= maxOverlap * d.size) continue;
		if (isHeld(partners_[d.first]) && isHeld(partners_[d.second])) continue;
		std::ostringstream message;
		message << "rigid " << namesOf(*rigidInteractions_[k].interaction) << " overlap by "
			<< -d.gap / d.size * sizeOverRadius << " radii of the smaller, more than "
			<< sizeOverRadius << " maxOverlap = " << sizeOverRadius * maxOverlap
			<< ". Hint: start from less overlap, reduce O.dt, or load more slowly";
		throw std::runtime_error(message.str());
	}
}

/// A sphere that lies on a facet (box) beside another touches the edge of that other one only at a
/// place in the plane that it lies on already: such a contact, whose normal leans, would stop it at
/// the seam. It is taken to bear nothing.
void SoftGrainIntegrator::leaveSeamsOut()
{
	onPlates_.clear();
	for (std::size_t k = 0; k < rigidContacts_.size(); ++k) {
		const RigidPair& pair = rigidPairs_[k];
		if (pair.twoSpheres || dynamic_cast<const Wall*>(pair.first->shape.get())) continue;
		onPlates_.push_back({ pair.second->getId(), static_cast<int>(k) });
	}
	if (onPlates_.empty()) return;
	std::sort(onPlates_.begin(), onPlates_.end());
	for (const auto& [sphere, k] : onPlates_) {
		RigidContactDescription& d = rigidContacts_[k];
		const Real tolerance = seamTolerance * d.size;
		const auto [begin, end] = std::equal_range(
			onPlates_.begin(), onPlates_.end(), std::make_pair(sphere, 0),
			[](const auto& a, const auto& b) { return a.first < b.first; });
		for (auto other = begin; other != end; ++other) {
			const RigidContactDescription& o = rigidContacts_[other->second];
			// on the surface, as the sphere sees it
			const Vec3 place = d.point - 0.5 * d.gap * d.normal - d.image.shift,
				   lies = o.point - 0.5 * o.gap * o.normal - o.image.shift;
			const bool leans = (d.normal - o.normal).squaredNorm() > leaningNormal;
			if (leans && d.gap >= o.gap &&
			    std::abs((place - lies).dot(o.normal)) < tolerance) {
				d.friction = 0;
				d.impulse.setZero();
				d.gap = std::numeric_limits<Real>::infinity();
				break;
			}
		}
	}
}

/// Forces to FrictPhys, and their sums in the order of the sweeps on the bodies.
void SoftGrainIntegrator::publishRigidContacts()
{
	reactions_.assign(scene->bodies->size(), Reaction());
	for (std::size_t k = 0; k < rigidContacts_.size(); ++k) {
		const RigidContactDescription& d = rigidContacts_[k];
		const RigidPair& pair = rigidPairs_[k];
		const Vector3r force = d.impulse / scene->dt;
		FrictPhys& phys = static_cast<FrictPhys&>(*rigidInteractions_[k].interaction->phys);
		const Vector3r onBody2 = pair.swapped ? Vector3r(-force) : force;
		phys.normalForce = onBody2.dot(d.normal) * d.normal;
		phys.shearForce = onBody2 - phys.normalForce;
		if (force.isZero(0)) continue;
		auto push = [&](const Body& body, const Vector3r& arm, const Vector3r& onBody) {
			Reaction& sum = reactions_[body.getId()];
			sum.force += onBody;
			sum.torque += arm.cross(onBody);
		};
		push(*pair.first, d.point - pair.first->state->pos, -force);
		push(*pair.second, d.point - pair.second->state->pos - d.image.shift, force);
	}
	for (std::size_t id = 0; id < reactions_.size(); ++id) {
		const Reaction& sum = reactions_[id];
		if (sum.force.isZero(0) && sum.torque.isZero(0)) continue;
		scene->forces.addForce(static_cast<int>(id), sum.force);
		scene->forces.addTorque(static_cast<int>(id), sum.torque);
	}
}

/// Out of overlaps, besides what NewtonIntegrator will do; it takes members of clumps along.
void SoftGrainIntegrator::moveApart() const
{
	for (std::size_t k = 0; k < partners_.size(); ++k) {
		const Real angle = partners_[k].turn.norm();
		if (angle == 0 && partners_[k].shift.isZero(0)) continue;
		State& state = *(*scene->bodies)[movers_[k]]->state;
		state.pos += partners_[k].shift;
		if (angle == 0) continue;
		state.ori = Quaternionr(AngleAxisr(angle, partners_[k].turn / angle)) * state.ori;
		state.ori.normalize();
	}
}

} // namespace yade
