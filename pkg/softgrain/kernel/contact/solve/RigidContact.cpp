#include "contact/solve/RigidContact.hpp"
#include "contact/solve/Bias.hpp"

#include <algorithm>

namespace softgrain {

template <int dim>
void RigidContactSolver<dim>::prepare(RigidContact<dim>& contact,
				      std::vector<RigidPartner<dim>>& partners, double dt)
{
	contact_ = &contact;
	first_ = &partners[contact.first];
	second_ = &partners[contact.second];
	firstMoves_ = first_->moves();
	secondMoves_ = second_->moves();
	firstArm_ = contact.point - first_->centre;
	secondArm_ = contact.point - second_->centre - contact.imageShift;
	drift_ = contact.imageVelocity;
	friction_ = contact.friction;
	c_.normal = contact.normal;
	c_.bias = biasFor(dt);
	solvable_ = c_.setMobility(first_->mobilityAt(firstArm_) + second_->mobilityAt(secondArm_));
	c_.begin(solvable_ ? onCone<dim>(contact.impulse, c_.normal, friction_)
			   : Vec<dim>(Vec<dim>::Zero()));
	push(c_.impulse);
}

template <int dim> double RigidContactSolver<dim>::biasFor(double dt) const
{
	const double e = contact_->restitution, gap = contact_->gap;
	const double before = e > 0 ? velocityBefore().dot(c_.normal) : 0;
	if (before < 0 && gap + dt * before <= 0) return e * before;
	return std::max(gap, 0.) / dt;
}

template <int dim> void RigidContactSolver<dim>::push(const Vec<dim>& J)
{
	if (firstMoves_) first_->push(firstArm_, -J);
	if (secondMoves_) second_->push(secondArm_, J);
}

template <int dim> void RigidContactSolver<dim>::addHeldMotion(HeldMotion<dim>& motion) const
{
	motion.addDrift(drift_);
	motion.add(*first_);
	motion.add(*second_);
}

template <int dim> Exchange RigidContactSolver<dim>::exchange() const
{
	const Vec<dim>& r = c_.impulse;
	if (r.isZero(0)) return {}; // b may be infinite
	const Vec<dim> free = freeVelocity();
	return { c_.energy(r), r.dot(velocity() - free), -r.dot(free + c_.bias * c_.normal) };
}

template <int dim> void RigidContactSolver<dim>::beginWith(double share)
{
	if (!solvable_) return;
	const Vec<dim> r = share * onCone<dim>(contact_->impulse, c_.normal, friction_);
	push(r - c_.impulse);
	c_.begin(r);
}

template <int dim> SweepChange RigidContactSolver<dim>::sweep(SweepOrder)
{
	if (!solvable_) return {};
	return c_.visit(velocity(), friction_, [this](const Vec<dim>& J) { push(J); });
}

template <int dim> void RigidContactSolver<dim>::extrapolate(double share)
{
	const Vec<dim> J = c_.extrapolate(share);
	if (!J.isZero(0)) push(J);
}

template <int dim> ResidualSum RigidContactSolver<dim>::residual() const
{
	ResidualSum sum;
	if (!solvable_) return sum;
	const Vec<dim> u = velocity();
	c_.addResidual(sum, u, friction_);
	sum.addExchange(c_.energy(c_.impulse), c_.impulse.dot(u - freeVelocity()));
	return sum;
}

template <int dim>
bool RigidContactSolver<dim>::findSeparation(double dt, const SolverSettings& settings)
{
	pushed_ = 0;
	const double gap = contact_->gap + dt * velocity().dot(c_.normal);
	const double resting = restingOverlap * contact_->size;
	separation_ = -std::max(gap, 0.);
	if (!solvable_ || gap >= -resting) return false;
	separation_ = settings.overlapRelaxation * (-gap - resting);
	return separation_ > 0;
}

template <int dim> void RigidContactSolver<dim>::separate()
{
	if (!solvable_) return;
	// most contacts, where little overlaps
	if (separation_ <= 0 && pushed_ == 0 && !first_->isDisplaced() && !second_->isDisplaced())
		return;
	const Vec<dim> apart = second_->shiftAt(secondArm_) - first_->shiftAt(firstArm_);
	const double before = pushed_;
	pushed_ = std::max(0., before + (separation_ - apart.dot(c_.normal)) / c_.Wn);
	const Vec<dim> push = (pushed_ - before) * c_.normal;
	if (push.isZero(0)) return;
	if (firstMoves_) first_->displace(firstArm_, -push);
	if (secondMoves_) second_->displace(secondArm_, push);
}

template <int dim> ContactWork RigidContactSolver<dim>::work() const
{
	ContactWork work;
	if (c_.impulse.isZero(0)) return work;
	auto book = [&](const Vec<dim>& relative, const Vec<dim>& held,
			double ContactWork::Halves::* half) {
		work.addReaction<dim>(half, c_.impulse, c_.normal, relative);
		work.walls.*half += 0.5 * c_.impulse.dot(held);
		work.cell.*half -= 0.5 * c_.impulse.dot(drift_);
	};
	const RigidPartner<dim>&a = *first_, &b = *second_;
	book(velocityBefore(),
	     a.heldAt(firstArm_, a.velocityBefore, a.spinBefore) -
		     b.heldAt(secondArm_, b.velocityBefore, b.spinBefore),
	     &ContactWork::Halves::before);
	book(velocity(),
	     a.heldAt(firstArm_, a.velocity, a.spin) - b.heldAt(secondArm_, b.velocity, b.spin),
	     &ContactWork::Halves::after);
	return work;
}

template <int dim> void RigidContactSolver<dim>::finish() { contact_->impulse = c_.impulse; }

template class RigidContactSolver<2>;
template class RigidContactSolver<3>;

} // namespace softgrain
