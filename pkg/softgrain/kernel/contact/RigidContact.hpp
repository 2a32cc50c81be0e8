// Two rigid bodies at the place where they touch, or may in the coming step, and that one contact
// as the sweeps see it: all in one piece, without memory of its own.
#pragma once

#include "contact/PairSolver.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/TwoStepContact.hpp"

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
};

/// The rigid counterpart of PairSolver for one contact of two rigid bodies.
template <int dim> class RigidContactSolver {
public:
	void prepare(RigidContact<dim>& contact, std::vector<RigidPartner<dim>>& partners,
		     double dt, const SolverSettings& settings);
	SweepChange sweep(SweepOrder order);
	ResidualSum residual() const;
	void finish();
	int contacts() const { return 1; }
	int active() const { return c_.impulse.isZero(0) ? 0 : 1; }

private:
	Vec<dim> velocity() const
	{
		return second_->velocityAt(secondArm_) - first_->velocityAt(firstArm_);
	}
	void push(const Vec<dim>& J); ///< an impulse on both bodies

	TwoStepContact<dim> c_;
	Vec<dim> firstArm_, secondArm_; ///< of the place from the centres of mass, m
	RigidPartner<dim>*first_, *second_;
	bool firstMoves_, secondMoves_, solvable_;
	double friction_;
	RigidContact<dim>* contact_; ///< valid for the step
};

} // namespace softgrain
