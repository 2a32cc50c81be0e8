// Which grains of a total-Lagrangian set are computed, and what becomes of those that are not:
// they move as rigid bodies, or sleep (doc/decisions/0014-inactive-grains.md).
#include "grain/TotalLagrangian.hpp"

#include <algorithm>
#include <numbers>

namespace softgrain {

namespace {

/// What comes together of the load of a grain that is borne is less. (In a single step it may be
/// more, as the forces of grains that are squeezed hard tremble:
/// doc/decisions/0014-inactive-grains.md.)
constexpr double drivingShare = 1e-4;

/// Of the load of a sleeping grain, what forces on it may differ by: beside what squeezes a grain a
/// weight may be small.
constexpr double borneLoadShare = 1e-2;

} // namespace

template <int dim>
double TotalLagrangian<dim>::vibrationEnergy(int g, const WholeGrain<dim>& whole) const
{
	const RigidVelocities<dim> rigid = whole.rigidVelocities();
	double sum = 0;
	auto add = [&](double mass, const Vec<dim>& x, const Vec<dim>& v) {
		sum += 0.5 * mass * (v - rigid.at(x)).squaredNorm();
	};
	if (pointVelocities_)
		for (int p = 0; p < batch_.reference->points(); ++p)
			add(batch_.massScale[g] * batch_.reference->pointVolume[p], pointAt(g, p),
			    pointVelocities_->get(g, p));
	else
		for (int I = 0; I < nodes(); ++I)
			add(batch_.nodeMass(g, I), batch_.x.get(g, I), batch_.v.get(g, I));
	return sum;
}

template <int dim> bool TotalLagrangian<dim>::mayMoveRigidly(int g) const
{
	const RigidLimits& limits = limits_[g];
	if (isRigid_[g])
		return rigid_[g].angularVelocity(shape_[g]).squaredNorm() <= limits.squaredSpin;
	if (!(batch_.report[g].elasticEnergy <= limits.energy)) return false; // most often
	const WholeGrain<dim> whole = wholeOfParticles(g);
	return whole.angularVelocity.squaredNorm() <= limits.squaredSpin &&
	       vibrationEnergy(g, whole) <= limits.energy;
}

template <int dim> void TotalLagrangian<dim>::beginRigidMotion(int g)
{
	rigid_[g] = rigidMotionOf<dim>(wholeOfParticles(g));
	isRigid_[g] = 1;
	++this->changesOfActivity_;
	nodesWritten_[g] = 0;
	batch_.report[g] = {};
	holder_.forget(g);
}

template <int dim> void TotalLagrangian<dim>::endRigidMotion(int g)
{
	writeNodes(g);
	isRigid_[g] = 0;
	++this->changesOfActivity_;
	std::fill_n(batch_.force.of(g), nodes(), Vec<dim>::Zero());
	if (damper_) damper_->forget(g);
}

template <int dim> void TotalLagrangian<dim>::arrangeGrains()
{
	std::vector<int> active;
	for (int g = 0; g < grains(); ++g)
		if (!isRigid_[g] && !isAsleep(g)) active.push_back(g);
	computeFirst(std::move(active));
}

/// Lays the grains into the blocks that are computed, in their order.
template <int dim> void TotalLagrangian<dim>::computeFirst(std::vector<int> chosen)
{
	std::vector<int> others;
	auto next = chosen.begin();
	for (int g = 0; g < grains(); ++g)
		if (next != chosen.end() && *next == g)
			++next;
		else
			others.push_back(g);
	batch_.arrange(chosen, others);
	computed_ = std::move(chosen);
}

template <int dim>
auto TotalLagrangian<dim>::momentaOf(int g, const WholeGrain<dim>& whole) const -> Momenta
{
	Momenta momenta;
	momenta << whole.mass * whole.velocity, whole.angularMomentum / rimOf(g);
	return momenta;
}

template <int dim> double TotalLagrangian<dim>::sizeOf(const Momenta& momenta)
{
	return momenta.template head<dim>().norm() +
	       momenta.template tail<Momenta::SizeAtCompileTime - dim>().norm();
}

template <int dim>
double TotalLagrangian<dim>::impulseOf(const BodyLoad<dim>& load, double time, int g,
				       const WholeGrain<dim>& whole) const
{
	const double spin = load.angular.norm() / std::numbers::sqrt2; // skew: each number twice
	return time *
	       (whole.mass * load.acceleration.norm() + whole.inertia.norm() * spin / rimOf(g));
}

template <int dim> double TotalLagrangian<dim>::watchRest(int g, double dt)
{
	RestWatch& rest = rest_[g];
	if (!rest.mayRest()) return 0;
	const double kinetic = softgrain::kineticEnergy(batch_, batch_.v, batch_.v, g);
	const bool isCalm = rest.isCalm(kinetic, batch_.report[g].elasticEnergy);
	const bool begins = isCalm && rest.calmTime() == 0;
	const double periods = rest.count(isCalm, dt);
	if (begins) watchFromNow(g, wholeGrain(batch_, g));
	return periods;
}

template <int dim> bool TotalLagrangian<dim>::isBalanced(int g, double kick) const
{
	double energy = 0;
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> change = batch_.vNext.get(g, I) - batch_.v.get(g, I);
		energy += 0.5 * batch_.nodeMass(g, I) * change.squaredNorm();
	}
	return rest_[g].isBalanced(energy, kick, batch_.report[g].elasticEnergy);
}

template <int dim>
WholeImpulses TotalLagrangian<dim>::wholeImpulses(int g, double kick,
						  const BodyLoad<dim>& load) const
{
	const auto change = wholeOf<dim>(nodes(), [&](int I) {
		return Particle<dim> { batch_.nodeMass(g, I), batch_.x.get(g, I),
				       batch_.vNext.get(g, I) - batch_.v.get(g, I),
				       batch_.reference->nodePosition[I] };
	});
	return { sizeOf(momentaOf(g, change)), impulseOf(load, kick, g, change) };
}

template <int dim>
bool TotalLagrangian<dim>::bears(int g, double force, const BodyLoad<dim>& load) const
{
	const double mass = batch_.mass(g), weight = mass * load.acceleration.norm();
	if (weight > 0 && force > borneLoadShare * weight) return false;
	return rest_[g].bears(force, mass, batch_.report[g].elasticEnergy);
}

template <int dim> void TotalLagrangian<dim>::watchFromNow(int g, const WholeGrain<dim>& whole)
{
	rest_[g].watchFromNow();
	watchedFrom_[g] = momentaOf(g, whole);
}

template <int dim> bool TotalLagrangian<dim>::isDriven(int g, const BodyLoad<dim>& load)
{
	if (load.isZero()) return false;
	const RestWatch& rest = rest_[g];
	if (!rest.isWatchedForLong()) return true;
	const WholeGrain<dim> whole = wholeGrain(batch_, g);
	const double came = sizeOf(momentaOf(g, whole) - watchedFrom_[g]);
	if (came <= drivingShare * impulseOf(load, rest.watchedTime(), g, whole)) return false;
	if (rest.isToBeWatchedAnew()) watchFromNow(g, whole);
	return true;
}

template <int dim> Vec<dim> TotalLagrangian<dim>::fallAsleep(int g)
{
	rest_[g].fallAsleep();
	++this->changesOfActivity_;
	Vec<dim> momentum = Vec<dim>::Zero();
	if (isRigid_[g]) return momentum;
	for (int I = 0; I < nodes(); ++I)
		momentum += batch_.nodeMass(g, I) * batch_.vNext.get(g, I);
	std::fill_n(batch_.vNext.of(g), nodes(), Vec<dim>::Zero());
	return momentum;
}

template <int dim> void TotalLagrangian<dim>::wake(int g)
{
	rest_[g].wake();
	++this->changesOfActivity_;
	if (damper_) damper_->stop(g); // the balance of the step of falling asleep needed them
}

template <int dim> RigidBounds<dim> TotalLagrangian<dim>::rigidBounds(int g) const
{
	const RigidMotion<dim>& motion = rigid_[g];
	const double R = batch_.grain[g].radius;
	RigidBounds<dim> bounds;
	bounds.centre = batch_.grain[g].origin + motion.centre;
	bounds.radius = R * outlineRadius_;
	bounds.bulge = R * outlineBulge_;
	bounds.velocities = { motion.velocity,
			      motion.angularVelocity(shape_[g]).norm() * bounds.radius };
	return bounds;
}

template <int dim> void TotalLagrangian<dim>::writeNodes(int g) const
{
	if (nodesWritten_[g]) return;
	nodesWritten_[g] = 1;
	const RigidMotion<dim>& motion = rigid_[g];
	const double R = batch_.grain[g].radius;
	const RigidVelocities<dim> velocities = motion.whole(shape_[g]).rigidVelocities();
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> x =
			motion.positionOf(R * batch_.reference->nodePosition[I], shape_[g]);
		batch_.x.set(g, I, x);
		batch_.v.set(g, I, velocities.at(x));
	}
	if (!pointVelocities_) return;
	pointVelocities_->takeFromNodes(batch_, g);
	pointVelocities_->mapToNodes(batch_, g);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template bool TotalLagrangian<dim>::mayMoveRigidly(int) const;                             \
	template void TotalLagrangian<dim>::beginRigidMotion(int);                                 \
	template void TotalLagrangian<dim>::endRigidMotion(int);                                   \
	template void TotalLagrangian<dim>::arrangeGrains();                                       \
	template void TotalLagrangian<dim>::computeFirst(std::vector<int>);                        \
	template double TotalLagrangian<dim>::watchRest(int, double);                              \
	template bool TotalLagrangian<dim>::isBalanced(int, double) const;                         \
	template bool TotalLagrangian<dim>::bears(int, double, const BodyLoad<dim>&) const;        \
	template bool TotalLagrangian<dim>::isDriven(int, const BodyLoad<dim>&);                   \
	template WholeImpulses TotalLagrangian<dim>::wholeImpulses(int, double,                    \
								   const BodyLoad<dim>&) const;    \
	template Vec<dim> TotalLagrangian<dim>::fallAsleep(int);                                   \
	template void TotalLagrangian<dim>::wake(int);                                             \
	template RigidBounds<dim> TotalLagrangian<dim>::rigidBounds(int) const;                    \
	template void TotalLagrangian<dim>::writeNodes(int) const;
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
