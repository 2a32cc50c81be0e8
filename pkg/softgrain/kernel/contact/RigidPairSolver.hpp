// The contacts of a soft grain with a rigid body, as the sweeps see them: the rigid counterpart of
// PairSolver.
//
// A contact node and a rigid body at the place where they touch have the mobility
//     W = w I + 1/m I + [a]^T I^-1 [a],
// with w of the grain's nodes, [a] x = x cross a for the arm a of the place about the centre of
// mass. It is no multiple of the identity. The contact is solved in two steps, its normal impulse
// first, then its tangential one at the velocity after that,
//     r_n <- max(0, r_n - (u_n + b)/W_nn),     r_t <- cut(r_t - u_t/W_t, mu r_n),
// with W_t the largest eigenvalue of the tangential block. Fixed points are exactly the solutions.
// For a ball (a passes through its centre), and where the body does not turn, one pass solves the
// contact; otherwise the sweeps do.
#pragma once

#include "contact/PairSolver.hpp"
#include "contact/RigidPartner.hpp"

#include <vector>

namespace softgrain {

template <int dim> class RigidPairSolver {
public:
	/// As PairSolver::prepare; the motion of the rigid body is in `partners`.
	void prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list,
		     std::vector<RigidPartner<dim>>& partners, double dt,
		     const SolverSettings& settings);
	SweepChange sweep(SweepOrder order);
	ResidualSum residual() const;
	void finish();
	int active() const { return list_->impulse.active; }
	ContactWork work() const;

	int contacts() const { return static_cast<int>(constraints_.size()); }
	struct Constraint {
		Vec<dim> normal;  ///< from the rigid body to the grain
		Vec<dim> impulse; ///< on the grain
		double bias;      ///< b, m/s
		Vec<dim>
			arm; ///< of the place, from the centre of mass of the rigid body's image, m
		Mat<dim> W;  ///< 1/kg
		double Wn, Wt; ///< W_nn and W_t, 1/kg
		int nodes;     ///< of the grain, on which the impulse acts in shares
		std::array<int, mostPartners<dim>> node;
		std::array<double, mostPartners<dim>> weight;
		int firstMoved, endMoved; ///< what an impulse moves of the grain: in `moved_`
	};
	const std::vector<Constraint>& constraints() const { return constraints_; }
	double friction() const { return friction_; }
	const std::vector<Vec<dim>>& start() const { return start_; }
	/// u with the present impulses.
	Vec<dim> velocity(const Constraint& c) const;
	/// As PairSolver::forEachShare; the rigid body has none.
	template <class Visit> void forEachShare(const Constraint& c, Visit&& visit) const
	{
		for (int i = 0; i < c.nodes; ++i)
			visit(static_cast<const ContactBody<dim>*>(grain_), c.node[i], c.weight[i]);
	}
	/// Whether impulses move the rigid body.
	bool movesPartner() const { return partner_->moves(); }

private:
	struct Moved {
		int node;
		double W; ///< times the scale of the grain, 1/kg
	};
	void findMobility(Constraint& c);
	Vec<dim> grainVelocity(const Constraint& c,
			       const std::vector<Vec<dim>> ContactBody<dim>::* field) const;
	Vec<dim> solvedImpulse(const Constraint& c) const;
	double energy(const Constraint& c, const Vec<dim>& r) const;
	void applyImpulse(const Constraint& c, const Vec<dim>& J);

	Vec<dim> imageCentre() const { return partner_->centre + list_->image.shift; }

	ContactBody<dim>* grain_ = nullptr;
	RigidPartner<dim>* partner_ = nullptr;
	ContactList<dim>* list_ = nullptr; ///< valid for the step
	double friction_ = 0;
	std::vector<Constraint> constraints_;
	std::vector<Vec<dim>> start_;
	std::vector<Moved> moved_;
};

} // namespace softgrain
