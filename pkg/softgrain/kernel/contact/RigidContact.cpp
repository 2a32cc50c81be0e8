#include "contact/RigidContact.hpp"
#include "contact/Bias.hpp"

namespace softgrain {

template <int dim>
void RigidContactSolver<dim>::prepare(RigidContact<dim>& contact,
				      std::vector<RigidPartner<dim>>& partners, double dt,
				      const SolverSettings& settings)
{
	contact_ = &contact;
	first_ = &partners[contact.first];
	second_ = &partners[contact.second];
	firstMoves_ = first_->moves();
	secondMoves_ = second_->moves();
	firstArm_ = contact.point - first_->centre;
	secondArm_ = contact.point - second_->centre;
	friction_ = contact.friction;
	c_.normal = contact.normal;
	// no wave speed of its own caps the speed: the overlap left alone may go in a step
	SolverSettings slow = settings;
	slow.overlapSpeed = std::min(settings.overlapSpeed, restingOverlap * contact.size / dt);
	c_.bias = biasOf(contact.gap, contact.size, dt, slow);
	solvable_ = c_.setMobility(first_->mobilityAt(firstArm_) +
				   second_->mobilityAt(secondArm_));
	c_.impulse = onCone<dim>(contact.impulse, c_.normal, friction_);
	if (!solvable_) c_.impulse.setZero();
	push(c_.impulse);
}

template <int dim> void RigidContactSolver<dim>::push(const Vec<dim>& J)
{
	if (firstMoves_) first_->push(firstArm_, -J);
	if (secondMoves_) second_->push(secondArm_, J);
}

template <int dim> SweepChange RigidContactSolver<dim>::sweep(SweepOrder)
{
	if (!solvable_) return {};
	const Vec<dim> r = c_.solvedAt(velocity(), friction_);
	const Vec<dim> J = r - c_.impulse;
	SweepChange change { 0, c_.energy(r) };
	if (J.isZero(0)) return change;
	change.changed = c_.energy(J);
	push(J);
	c_.impulse = r;
	return change;
}

template <int dim> ResidualSum RigidContactSolver<dim>::residual() const
{
	ResidualSum sum;
	if (solvable_) c_.addResidual(sum, velocity(), friction_);
	return sum;
}

template <int dim> void RigidContactSolver<dim>::finish() { contact_->impulse = c_.impulse; }

template class RigidContactSolver<2>;
template class RigidContactSolver<3>;

} // namespace softgrain
