// The contacts of a soft grain with a rigid body, as the sweeps see them: the rigid counterpart of
// PairSolver. Its contacts are solved in two steps (TwoStepContact.hpp).
#pragma once

#include "contact/ContactList.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/solve/Bias.hpp"
#include "contact/solve/BodySide.hpp"
#include "contact/solve/ContactWork.hpp"
#include "contact/solve/Residual.hpp"
#include "contact/solve/SolverSettings.hpp"
#include "contact/solve/Sweep.hpp"
#include "contact/solve/TwoStepContact.hpp"

#include <array>
#include <vector>

namespace softgrain {

template <int dim> class RigidPairSolver {
public:
	/// As PairSolver::prepare; the motion of the rigid body is in `partners`.
	void prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list,
		     std::vector<RigidPartner<dim>>& partners, double dt,
		     const SolverSettings& settings);
	SweepChange sweep(SweepOrder order);
	/// Of a rigid body that impulses move: TwoStepContact::extrapolate for all contacts.
	void extrapolate(double share);
	ResidualSum residual() const;
	void finish();
	int active() const { return list_->impulse.active; }
	ContactWork work() const;

	int contacts() const { return static_cast<int>(constraints_.size()); }
	struct Constraint : TwoStepContact<dim> { // its impulse acts on the grain
		double grainMobility;             ///< the grain's share of W, 1/kg
		Vec<dim>
			arm; ///< of the place, from the centre of mass of the rigid body's image, m
		/// By how much the velocity of the place half a step later, when it has turned with
		/// the body, differs from that at `arm`, m/s.
		Vec<dim> halfTurn;
		/// Of the grain: the impulse acts in shares on nodes that bear a place over a
		/// facet, or else (`ofNode`) on one contact node, the only "partner".
		bool ofNode;
		int facet, partners;
		std::array<int, mostPartners<dim>> partner;
		std::array<double, mostPartners<dim>> weight;
	};
	const std::vector<Constraint>& constraints() const { return constraints_; }
	double friction(const Constraint& c) const
	{
		return frictions_.empty() ? friction_ : frictions_[numberOf(c)];
	}
	const std::vector<Vec<dim>>& start() const { return start_; }
	/// u with the present impulses.
	Vec<dim> velocity(const Constraint& c) const;
	/// As PairSolver::forEachShare; the rigid body has none.
	template <class Visit> void forEachShare(const Constraint& c, Visit&& visit) const
	{
		for (int i = 0; i < c.partners; ++i)
			visit(static_cast<const ContactBody<dim>*>(grain_), c.partner[i],
			      c.weight[i]);
	}
	/// Whether impulses move the rigid body.
	bool movesPartner() const { return moves_; }
	void addHeldMotion(HeldMotion<dim>& motion) const;

private:
	std::size_t numberOf(const Constraint& c) const { return &c - constraints_.data(); }
	Vec<dim> halfTurnOf(const Constraint& c) const; ///< Constraint::halfTurn
	/// Of the place of a contact on the rigid body, m/s.
	Vec<dim> rigidVelocity(const Constraint& c) const
	{
		return partner_->velocityAt(c.arm) + c.halfTurn;
	}
	Vec<dim> rigidVelocityBefore(const Constraint& c) const
	{
		return partner_->velocityBeforeAt(c.arm) - c.halfTurn;
	}
	Vec<dim> grainVelocity(const Constraint& c,
			       const std::vector<Vec<dim>> ContactBody<dim>::* field) const;
	void describe(const Contact<dim>& contact, const Bias& bias, Constraint& c) const;
	double restingOverlapOf(const Constraint& c) const; ///< in dr
	void applyImpulse(const Constraint& c, const Vec<dim>& J);
	void addExchange(ResidualSum& sum, const Constraint& c) const;
	double spinOfPartner(const Vec<dim>& normal) const; ///< ContactOutcome::spin
	ContactOutcome<dim> outcomeOf(std::size_t k) const;
	/// Keeps what became of contact k, for the interface; returns its whole impulse.
	Vec<dim> remember(std::size_t k);

	Vec<dim> imageCentre() const { return partner_->centre + list_->image.shift; }

	ContactBody<dim>* grain_ = nullptr;
	BodySide<dim> side_; ///< the grain's
	RigidPartner<dim>* partner_ = nullptr;
	ContactList<dim>* list_ = nullptr;        ///< valid for the step
	PairInterface<dim>* interface_ = nullptr; ///< of the list; null if there is none
	double dt_ = 0;                           ///< of the step, s
	bool moves_ = false;                      ///< the rigid body
	Vec<dim> drift_; ///< of the image of the rigid body beyond its own velocity, m/s
	double friction_ = 0;
	std::vector<double> frictions_; ///< contact by contact, where there is an interface
	std::vector<Constraint> constraints_;
	std::vector<Vec<dim>> start_;
};

} // namespace softgrain
