// Two rigid bodies at the place where they touch, or may in the coming step, and that one contact
// as the sweeps see it: all in one piece, without memory of its own.
//
// An overlap asks for no velocity here, which would shake a packing under pressure for ever: bodies
// are moved apart after the solve (`separate`), without gaining speed
// (doc/decisions/0020-rigid-contact-dynamics.md).
#pragma once

#include "contact/RigidPartner.hpp"
#include "contact/solve/ContactWork.hpp"
#include "contact/solve/Residual.hpp"
#include "contact/solve/SolverSettings.hpp"
#include "contact/solve/Sweep.hpp"
#include "contact/solve/TwoStepContact.hpp"

#include <vector>

namespace softgrain {

template <int dim> struct RigidContact {
	int first, second; ///< bodies: numbers of their RigidPartner
	Vec<dim> point;    ///< m
	Vec<dim> normal;   ///< unit, from the first to the second
	double gap;        ///< m, negative for an overlap
	double size;       ///< what the spacing of material points is to soft grains, m
	double friction;   ///< mu
	/// On the second body, N s: what the solve starts from, afterwards its result.
	Vec<dim> impulse;
	/// In a periodic cell: from the second body to its image that the first one sees, m, and
	/// the velocity of that, m/s.
	Vec<dim> imageShift = Vec<dim>::Zero(), imageVelocity = Vec<dim>::Zero();
	double restitution = 0; ///< e
};

/// What impulses exchange with rigid bodies, J.
struct Exchange {
	double present = 0;   ///< sum W |r|^2
	double exchanged = 0; ///< r . W r = r . (u - u_free)
	double wanted = 0; ///< the same of impulses that solve the contacts: - r . (u_free + b n)

	Exchange& operator+=(const Exchange& other)
	{
		present += other.present;
		exchanged += other.exchanged;
		wanted += other.wanted;
		return *this;
	}
};

/// The rigid counterpart of PairSolver for one contact of two rigid bodies.
template <int dim> class RigidContactSolver {
public:
	void prepare(RigidContact<dim>& contact, std::vector<RigidPartner<dim>>& partners,
		     double dt);
	void addHeldMotion(HeldMotion<dim>& motion) const;
	Exchange exchange() const; ///< of the present impulse
	/// Begins with such a share of the impulse of the last step, in place of all of it.
	void beginWith(double share);
	SweepChange sweep(SweepOrder order);
	/// TwoStepContact::extrapolate, and hands the change on.
	void extrapolate(double share);
	ResidualSum residual() const;
	void finish();
	/// After the velocities are solved: how far the bodies are to be moved apart. False where
	/// the overlap at the end of the step may stay.
	bool findSeparation(double dt, const SolverSettings& settings);
	/// Moves the bodies so far apart by RigidPartner::shift and turn, others held, or back by
	/// what this contact has moved them before; lets gaps close, but not overlap.
	void separate();
	/// What the impulse does to all that it moves; `walls` is the work of prescribed motion.
	ContactWork work() const;
	int contacts() const { return 1; }
	int active() const { return c_.impulse.isZero(0) ? 0 : 1; }
	/// Whether impulses move one of the bodies at least.
	bool movesBodies() const { return firstMoves_ || secondMoves_; }

private:
	/// b: the speed at which the gap may close; a contact that closes in this step leaves with
	/// e times the speed that it came with.
	double biasFor(double dt) const;
	Vec<dim> velocityBefore() const
	{
		return second_->velocityBeforeAt(secondArm_) + drift_ -
		       first_->velocityBeforeAt(firstArm_);
	}
	Vec<dim> velocity() const
	{
		return second_->velocityAt(secondArm_) + drift_ - first_->velocityAt(firstArm_);
	}
	Vec<dim> freeVelocity() const
	{
		return second_->freeVelocityAt(secondArm_) + drift_ -
		       first_->freeVelocityAt(firstArm_);
	}
	void push(const Vec<dim>& J); ///< an impulse on both bodies

	TwoStepContact<dim> c_;
	Vec<dim> firstArm_, secondArm_; ///< of the place from the centres of mass, m
	Vec<dim> drift_;                ///< velocity of the image of the second body, m/s
	RigidPartner<dim>*first_, *second_;
	bool firstMoves_, secondMoves_, solvable_;
	double friction_;
	double separation_; ///< wanted at the end of the step, m; negative: so far it may close
	double pushed_;     ///< what `separate` did so far, kg m
	RigidContact<dim>* contact_; ///< valid for the step
};

} // namespace softgrain
