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
// same problem, with blocks of their own (TwoStepContact.hpp): against grains (RigidPairSolver.hpp)
// and against each other (RigidContact.hpp).
//
// What is swept, in which order and by which thread: PlannedPairs.hpp.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/solve/ContactProblem.hpp"
#include "contact/solve/IslandSweeps.hpp"
#include "contact/solve/PlannedPairs.hpp"

#include <vector>

namespace softgrain {

struct SolverReport {
	int contacts = 0;      ///< within reach
	int active = 0;        ///< with an impulse
	long visits = 0;       ///< of contacts by sweeps
	double sweeps = 0;     ///< the same over the number of contacts
	double residual = 0;   ///< of the impulses found, on the island where it is largest
	bool converged = true; ///< residual <= tolerance within maxSweeps
};

/// A copy has to be prepared before it is asked anything: its pairs still look at the original.
template <int dim> class ContactSolver {
public:
	/// Takes all contacts of `lists` between so many grains. The order of the lists decides on
	/// the plan of the sweeps. Lists with a rigid body name their entry of `partners`, whose
	/// velocities the impulses change too; so do the contacts of rigid bodies with each other,
	/// which come after the lists.
	void plan(const std::vector<ContactList<dim>*>& lists, int grains,
		  std::vector<RigidPartner<dim>>* partners = nullptr,
		  std::vector<RigidContact<dim>>* rigidContacts = nullptr);
	/// With the bodies of the grains: applies the impulses left by the last step, made
	/// admissible for the present normals.
	void prepare(std::vector<ContactBody<dim>>& bodies, double dt,
		     const SolverSettings& settings, int threads = 1);
	/// Gauss-Seidel sweeps: two backwards and two forwards (in one direction alone, few sweeps
	/// a step shake grains at rest: doc/decisions/0010-grains-at-rest.md), then in turn the
	/// pairs in which the residual sits, each on its own
	/// (doc/decisions/0026-pairs-on-their-own.md), and, since pairs feel each other, sweeps
	/// forwards (doc/decisions/0004-sweep-order.md), until the residual is within the tolerance
	/// or the cap is hit: each island of pairs for itself (SweepPlan). At the end the lists
	/// have their impulses, and the contact nodes the sums (ContactBody::impulse), unless the
	/// residual is no number: then they keep those of before.
	SolverReport solve();
	/// After `solve`: moves rigid bodies that overlap each other apart, by RigidPartner::shift
	/// and turn. Velocities stay as they are.
	void separateRigidBodies(double dt);
	/// Of the present impulses, on the island where it is largest: see ResidualSum.
	double residual();
	/// Of the contacts of grains.
	ContactWork work() const;
	/// Of the contacts of rigid bodies with each other (RigidContactSolver::work).
	ContactWork rigidWork() const;
	/// There is no `problem` until the next `solve`.
	void forget() { solved_ = false; }
	/// The problem and its solution, of the last `solve`, in the order of the sweeps; without
	/// contacts from `plan` to the end of a `solve` that found finite impulses. Lists and their
	/// interfaces are not needed any more; velocities and mobility tables of the bodies are, as
	/// they were then, and so are the partners. Throws std::logic_error where a rigid body that
	/// impulses move is in contact: its blocks are no multiples of the identity.
	ContactProblem<dim> problem() const;

private:
	/// A pass goes over the pairs of islands that take part in it.
	bool takesPart(int k) const { return islands_[pairs_.islandOf(k)].takesPart; }
	/// Those of which this is true take part from now on; returns whether there are any.
	template <class Is> bool select(Is&& is);
	void noteIslands();
	/// (ContactSolverStart.cpp) Of islands of rigid bodies alone: scales the impulses of the
	/// last step so that all together exchange what they should, r . (u + b n) = 0, unless that
	/// is far less and would violate more. Those of an impact do nothing any more; those that
	/// hold a heavy body on light ones are soon as large as it takes.
	void adjustImpulses();
	void findFirstShares(); ///< IslandSweeps::firstShare
	void beginWithShares(); ///< in place of all of the impulses
	/// No contact has an impulse, and none needs one: sweeps would change nothing.
	bool bearsNothing();
	bool isLeft(const IslandSweeps& island) const
	{
		return !island.isDone(settings_.tolerance, settings_.maxSweeps);
	}
	/// The sweeps of `solve`, and what they came to.
	void sweepToTolerance();
	void reportSweeps(SolverReport& report) const;
	double largestResidual() const; ///< of those measured; not a number if one is none
	/// The first ones, in either direction.
	void sweepBothWays();
	void beginTurns();
	/// Of the islands that take part. The rest of the vector is that of before.
	void measurePairs();
	void measureIslands();
	/// Of pairs as last measured, of each island.
	std::vector<ResidualSum> sumsOfIslands() const;
	/// Brings the violation of pairs down, each on its own, so far that that of all of an
	/// island is within the tolerance, if pairs do not feel each other; returns the visits of
	/// contacts, island by island.
	std::vector<long> solvePairsAlone();
	/// The violation that pairs of each island may keep then.
	std::vector<double> levelsAlone() const;
	/// Islands note what the last of so many sweeps did, which each task makes in a row while
	/// it is in the caches.
	void sweep(SweepOrder order, int times);
	/// Goes on beyond what the sweeps left (Extrapolation), where impulses move rigid bodies.
	void extrapolate();
	/// Calls with each pair's solver and constraint, in the order of the sweeps.
	template <class Visit> void forEachConstraint(Visit&& visit) const;
	SparseRows<double> delassus() const;

	PlannedPairs<dim> pairs_;
	bool solved_ = false;
	int lastActive_ = 0; ///< contacts with an impulse in the last solve
	std::vector<IslandSweeps> islands_;
	std::vector<SweepChange> change_;    ///< of each pair, in the sweep at hand
	std::vector<ResidualSum> residuals_; ///< of each pair, when last measured
	std::vector<long> visits_;           ///< of contacts, by pairs on their own
	SolverSettings settings_;
};

template <int dim> template <class Is> bool ContactSolver<dim>::select(Is&& is)
{
	bool any = false;
	for (IslandSweeps& island : islands_)
		any |= island.takesPart = is(island);
	return any;
}

} // namespace softgrain
