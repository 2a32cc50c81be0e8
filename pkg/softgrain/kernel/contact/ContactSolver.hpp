// Contact dynamics: Signorini's and Coulomb's conditions at velocity level for all contacts of a
// step, by nonlinear Gauss-Seidel on the contact nodes (method: section 3).
//
// For each contact, with u the relative velocity of the node at the end of the step and r its
// impulse:
//     0 <= u_n + b  _|_  r_n >= 0,     |r_t| <= mu r_n, sliding opposite to u_t at the bound,
// where b = g/dt for a gap and, for an overlap, the capped speed at which it is worked off. Nodal
// masses are isotropic, so the Delassus block of a contact is W times the identity and the
// one-contact problem has a closed solution (CoulombCone.hpp). How well all conditions hold
// together is measured apart from the sweeps (Residual.hpp). Rigid bodies are further bodies of the
// same problem, with blocks of their own (RigidPairSolver.hpp).
//
// A sweep goes through the pairs of bodies as SweepPlan.hpp says: threads share the tasks of a
// colour, none of which have a body in common, and the result is that of one thread.
#pragma once

#include "contact/ContactProblem.hpp"
#include "contact/PairSolver.hpp"
#include "contact/RigidPairSolver.hpp"

#include <vector>

namespace softgrain {

struct SolverReport {
	int contacts = 0; ///< within reach
	int active = 0;   ///< with an impulse
	int sweeps = 0;
	double residual = 0;   ///< of the impulses found
	bool converged = true; ///< residual <= tolerance within maxSweeps
};

template <int dim> class ContactSolver {
public:
	/// Takes all contacts of `lists`, whose bodies are in `bodies`, and applies the impulses
	/// left by the last step, made admissible for the present normals. The order of the lists
	/// decides on the plan of the sweeps. Lists with a rigid body
	/// name their entry of `partners`, whose velocities the impulses change too.
	void prepare(std::vector<ContactBody<dim>>& bodies,
		     const std::vector<ContactList<dim>*>& lists, double dt,
		     const SolverSettings& settings, int threads = 1,
		     std::vector<RigidPartner<dim>>* partners = nullptr);
	/// Gauss-Seidel sweeps: two backwards and two forwards (in one direction alone, few sweeps
	/// a step shake grains at rest: doc/decisions/0010-grains-at-rest.md), then always forwards
	/// (doc/decisions/0004-sweep-order.md), until the residual is within the tolerance or the
	/// cap is hit; then the lists have their impulses, and the contact nodes the sums
	/// (ContactBody::impulse).
	SolverReport solve();
	/// Of the present impulses: see ResidualSum.
	double residual() const;
	ContactWork work() const;
	/// The problem and its solution, of the last `solve`, in the order of the sweeps. Lists are
	/// not needed any more; velocities and mobility tables of the bodies are, as they were
	/// then. Throws std::logic_error where a rigid body that impulses move is in contact: its
	/// blocks are no multiples of the identity.
	ContactProblem<dim> problem() const;

private:
	/// Calls with the numbers of all pairs, colour by colour; `visit` may not throw.
	template <class Visit> void forEachPair(SweepOrder order, Visit&& visit);
	template <class Visit> void forEachPairOf(int task, SweepOrder order, Visit&& visit);
	/// Of pair k, if there is one, as far as it is worth it.
	void fetch(int k, void (PairSolver<dim>::*what)() const) const;
	double sweep(SweepOrder order); ///< relative change of the impulses, in the residual's norm
	/// Calls with each pair's solver and constraint, in the order of the sweeps.
	template <class Visit> void forEachConstraint(Visit&& visit) const;
	SparseRows<double> delassus() const;

	/// Calls with the solver of pair k, of either kind.
	template <class Visit> decltype(auto) withPair(int k, Visit&& visit)
	{
		const Slot& slot = slot_[k];
		return slot.rigid ? visit(rigidPairs_[slot.index]) : visit(pairs_[slot.index]);
	}
	template <class Visit> decltype(auto) withPair(int k, Visit&& visit) const
	{
		const Slot& slot = slot_[k];
		return slot.rigid ? visit(rigidPairs_[slot.index]) : visit(pairs_[slot.index]);
	}

	/// Where a pair is kept.
	struct Slot {
		bool rigid;
		int index;
	};
	std::vector<Slot> slot_;                       ///< colour by colour
	std::vector<PairSolver<dim>> pairs_;           ///< in this order; further ones are spare
	std::vector<RigidPairSolver<dim>> rigidPairs_; ///< the same with rigid bodies
	std::vector<int> taskEnd_, colourEnd_;         ///< as in SweepPlan
	int count_ = 0;
	std::vector<SweepChange> change_; ///< of each pair, in the sweep at hand
	SolverSettings settings_;
	int threads_ = 1;
};

} // namespace softgrain
