// Contacts of rigid bodies with each other in a step: from YADE's interactions to the kernel, and
// the forces back.
#include "NonsmoothLaw.hpp"
#include "SceneAssembly.hpp"
#include "SoftGrainIntegrator.hpp"

#include <limits>
#include <sstream>
#include <tuple>

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

const Sphere* asSphere(const Body& body) { return dynamic_cast<const Sphere*>(body.shape.get()); }

/// The first is that with the lower id if both are spheres, whose places in the interaction may
/// depend on threads; else #1, as the functors have it.
struct Bodies {
	Body::id_t first, second;
};

Bodies bodiesOf(const Interaction& I, const Scene& scene)
{
	const bool twoSpheres = asSphere(*(*scene.bodies)[I.getId1()]);
	if (twoSpheres && I.getId2() < I.getId1()) return { I.getId2(), I.getId1() };
	return { I.getId1(), I.getId2() };
}

/// Place and gap; sphere against sphere anew, in the order of their ids to the last bit.
void describePlace(const Body& first, const Body& second, const ScGeom& geom,
		   RigidContactDescription& d)
{
	const Sphere &ball = *asSphere(second), *other = asSphere(first);
	Real radius = ball.radius;
	if (other) {
		const Vec3 branch = second.state->pos - first.state->pos;
		const Real distance = branch.norm();
		d.normal = branch / distance;
		d.gap = distance - other->radius - ball.radius;
		d.point = first.state->pos + (other->radius + 0.5 * d.gap) * d.normal;
		radius = std::min(radius, other->radius);
	} else {
		d.normal = geom.normal;
		d.gap = -geom.penetrationDepth;
		d.point = geom.contactPoint;
	}
	d.size = sizeOverRadius * radius;
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
	rigidInteractions_.clear();
	const LawFunctor* law = nonsmoothLaw(*scene);
	if (!law) return false;
	if (scene->isPeriodic)
		throw std::invalid_argument(
			"O.periodic = True: contacts of rigid bodies under "
			"Law2_ScGeom_FrictPhys_Nonsmooth across the borders of a periodic cell "
			"are not supported; use YADE's own law for rigid pairs");
	for (const auto& I : *scene->interactions)
		if (I->isReal() && I->functorCache.constLaw.get() == law)
			rigidInteractions_.push_back({ std::min(I->getId1(), I->getId2()),
						       std::max(I->getId1(), I->getId2()),
						       I.get() });
	std::sort(rigidInteractions_.begin(), rigidInteractions_.end(),
		  [](const RigidInteraction& a, const RigidInteraction& b) {
			  return std::tie(a.lower, a.higher) < std::tie(b.lower, b.higher);
		  });
	return true;
}

/// Numbers the bodies and describes the contacts. O.forces hold all that else acts on the bodies.
void SoftGrainIntegrator::describeRigidContacts()
{
	rigidContacts_.clear();
	for (const RigidInteraction& entry : rigidInteractions_) {
		const Interaction* I = entry.interaction;
		const Bodies ids = bodiesOf(*I, *scene);
		const Body &first = *(*scene->bodies)[ids.first],
			   &second = *(*scene->bodies)[ids.second];
		const FrictPhys& phys = static_cast<const FrictPhys&>(*I->phys);
		if (!asSphere(second))
			throw std::runtime_error(
				namesOf(*I) + " (" + first.shape->getClassName() + " and " +
				second.shape->getClassName() +
				") meet under Law2_ScGeom_FrictPhys_Nonsmooth, which is for a "
				"Sphere against a Sphere, Facet, Box or Wall");
		if (!(phys.tangensOfFrictionAngle >= 0))
			throw std::runtime_error(namesOf(*I) + ": tangensOfFrictionAngle = " +
						 std::to_string(phys.tangensOfFrictionAngle) +
						 " is outside the admissible range [0, inf)");
		RigidContactDescription d;
		describePlace(first, second, static_cast<const ScGeom&>(*I->geom), d);
		d.first = numberOf(first);
		d.second = numberOf(second);
		d.friction = phys.tangensOfFrictionAngle;
		const Real sign = ids.second == I->getId2() ? 1 : -1;
		d.impulse = sign * scene->dt * (phys.normalForce + phys.shearForce);
		rigidContacts_.push_back(d);
	}
	stopOnRigidOverlap();
	leaveSeamsOut();
}

void SoftGrainIntegrator::stopOnRigidOverlap() const
{
	for (std::size_t k = 0; k < rigidContacts_.size(); ++k) {
		const RigidContactDescription& d = rigidContacts_[k];
		if (-d.gap <= maxOverlap * d.size) continue;
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
		const Interaction& I = *rigidInteractions_[k].interaction;
		const Body& first = *(*scene->bodies)[I.getId1()];
		if (asSphere(first) || dynamic_cast<const Wall*>(first.shape.get())) continue;
		onPlates_.push_back({ I.getId2(), static_cast<int>(k) });
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
			const Vec3 place = d.point - 0.5 * d.gap * d.normal, // on the surface
				lies = o.point - 0.5 * o.gap * o.normal;
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

/// Forces to FrictPhys, and on both bodies, in the order of the sweeps.
void SoftGrainIntegrator::publishRigidContacts()
{
	for (std::size_t k = 0; k < rigidContacts_.size(); ++k) {
		const RigidContactDescription& d = rigidContacts_[k];
		const Interaction& I = *rigidInteractions_[k].interaction;
		const Bodies ids = bodiesOf(I, *scene);
		const Vector3r force = d.impulse / scene->dt;
		FrictPhys& phys = static_cast<FrictPhys&>(*I.phys);
		const Real sign = ids.second == I.getId2() ? 1 : -1;
		phys.normalForce = sign * force.dot(d.normal) * d.normal;
		phys.shearForce = sign * force - phys.normalForce;
		if (force.isZero(0)) continue;
		for (const auto& [id, onBody] : { std::make_pair(ids.first, Vector3r(-force)),
						  std::make_pair(ids.second, force) }) {
			const Vector3r arm = d.point - (*scene->bodies)[id]->state->pos;
			scene->forces.addForce(id, onBody);
			scene->forces.addTorque(id, arm.cross(onBody));
		}
	}
}

/// Out of overlaps, besides what NewtonIntegrator will do; it takes members of clumps along.
void SoftGrainIntegrator::moveApart() const
{
	for (std::size_t k = 0; k < partners_.size(); ++k) {
		State& state = *(*scene->bodies)[movers_[k]]->state;
		state.pos += partners_[k].shift;
		const Real angle = partners_[k].turn.norm();
		if (angle == 0) continue;
		state.ori = Quaternionr(AngleAxisr(angle, partners_[k].turn / angle)) * state.ori;
		state.ori.normalize();
	}
}

} // namespace yade
