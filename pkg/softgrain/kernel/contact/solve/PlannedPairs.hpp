// The solvers of all pairs of bodies in contact, in the order of the sweeps: what they are kept in,
// and how passes go through them, on several threads and with what comes next asked for ahead.
//
// A pass goes through the pairs as SweepPlan.hpp says: threads share the tasks of a colour, none of
// which have a body in common, and the result is that of one thread.
#pragma once

#include "contact/solve/PairSolver.hpp"
#include "contact/solve/RigidContact.hpp"
#include "contact/solve/RigidPairSolver.hpp"
#include "contact/solve/SweepPlan.hpp"

#include <cstddef>
#include <omp.h>
#include <vector>

namespace softgrain {

/// A copy has to be prepared before it is asked anything: its pairs still look at the original.
template <int dim> class PlannedPairs {
public:
	/// ContactSolver::plan
	void plan(const std::vector<ContactList<dim>*>& lists, int grains,
		  std::vector<RigidPartner<dim>>* partners,
		  std::vector<RigidContact<dim>>* rigidContacts);
	/// ContactSolver::prepare
	void prepare(std::vector<ContactBody<dim>>& bodies, double dt,
		     const SolverSettings& settings, int threads);

	int count() const { return count_; }
	int threads() const { return threads_; } ///< that share a pass
	int islands() const { return plan_.islands; }
	int islandOf(int k) const { return plan_.island[k]; } ///< SweepPlan::island of pair k
	/// The solver of pair k; null unless it is one of two grains (or of a grain and a plane),
	/// of a grain on a rigid body, of two rigid bodies.
	PairSolver<dim>* grains(int k) { return of(pairs_, k, Kind::grains); }
	const PairSolver<dim>* grains(int k) const { return of(pairs_, k, Kind::grains); }
	RigidPairSolver<dim>* grainOnRigid(int k) { return of(rigidPairs_, k, Kind::grainOnRigid); }
	const RigidPairSolver<dim>* grainOnRigid(int k) const
	{
		return of(rigidPairs_, k, Kind::grainOnRigid);
	}
	RigidContactSolver<dim>* rigid(int k) { return of(rigidContacts_, k, Kind::rigid); }
	const RigidContactSolver<dim>* rigid(int k) const
	{
		return of(rigidContacts_, k, Kind::rigid);
	}
	/// Calls with the solver of pair k, of whichever kind.
	template <class Visit> decltype(auto) with(int k, Visit&& visit)
	{
		return visitPair(*this, k, visit);
	}
	template <class Visit> decltype(auto) with(int k, Visit&& visit) const
	{
		return visitPair(*this, k, visit);
	}
	/// The same unless pair k is one of two rigid bodies.
	template <class Visit> void withGrainPair(int k, Visit&& visit) const
	{
		if (const auto* pair = grainOnRigid(k)) visit(*pair);
		if (const auto* pair = grains(k)) visit(*pair);
	}
	/// Calls with the numbers of all pairs, colour by colour, those of a task so many times in
	/// a row; `visit` may not throw.
	template <class Visit> void forEach(SweepOrder order, Visit&& visit, int times = 1) const;

	/// Ask for the memory that a pass over velocities and constraints, and one that finishes,
	/// will need after pair k.
	void fetchForSweep(int k, SweepOrder order) const;
	void fetchForFinish(int k) const;

	bool movesRigidBodies(int k) const; ///< whether impulses of pair k do
	/// Adds what is prescribed of the rigid bodies in it.
	void addHeldMotion(int k, HeldMotion<dim>& motion) const;

private:
	enum class Kind : char { grains, grainOnRigid, rigid };
	/// A pair as it comes, before the plan.
	struct Listed {
		Kind kind;
		std::size_t contacts;
	};
	/// Where a pair is kept.
	struct Slot {
		Kind kind;
		int index;
		int task; ///< of the plan
	};

	/// A solver for each pair, and constraints for its contacts.
	void makeRoom();
	/// ContactBody::noteContactAt; before any impulse is applied, since what it moves other
	/// pairs ask for.
	void noteNodesInContact(std::vector<ContactBody<dim>>& bodies) const;
	template <class Visit> void forEachOf(int task, SweepOrder order, Visit&& visit) const;
	/// Whether what sweeps work on is still there from the sweep before.
	bool stayInCache() const;
	/// Of pair k, if there is one.
	void fetch(int k, void (PairSolver<dim>::*what)() const) const;
	/// What `prepare` will need after pair k. What is not yet known of a pair goes by what the
	/// pair of this number was in the last step: mostly it is the same one.
	void fetchForPrepare(int k) const;
	template <class Solvers> auto* of(Solvers& solvers, int k, Kind kind) const
	{
		return slot_[k].kind == kind ? &solvers[slot_[k].index] : nullptr;
	}
	template <class Self, class Visit>
	static decltype(auto) visitPair(Self& self, int k, Visit& visit)
	{
		const Slot& slot = self.slot_[k];
		if (slot.kind == Kind::rigid) return visit(self.rigidContacts_[slot.index]);
		if (slot.kind == Kind::grainOnRigid) return visit(self.rigidPairs_[slot.index]);
		return visit(self.pairs_[slot.index]);
	}

	SweepPlan plan_;
	std::vector<ContactList<dim>*> lists_; ///< lists with contacts
	std::vector<BodiesOfPair> bodiesOf_;   ///< of these, then of the rigid contacts
	std::vector<Listed> listed_;           ///< the same
	std::vector<RigidPartner<dim>>* partners_ = nullptr;
	std::vector<RigidContact<dim>>* contactsOfRigid_ = nullptr;
	std::vector<BodiesOfPair> planned_; ///< those that `plan_` is for
	int plannedBodies_ = 0;
	std::vector<Slot> slot_;                       ///< task by task
	std::vector<PairSolver<dim>> pairs_;           ///< in this order; further ones are spare
	std::vector<RigidPairSolver<dim>> rigidPairs_; ///< the same with rigid bodies
	std::vector<RigidContactSolver<dim>> rigidContacts_; ///< the same of rigid bodies alone
	/// Of the pairs of grains, pair after pair in the order of the sweeps, so that memory is
	/// gone through as it lies; and where those of each pair of `slot_` begin, at last their
	/// end.
	std::vector<typename PairSolver<dim>::Constraint> constraints_;
	std::vector<std::size_t> constraintsBegin_;
	int count_ = 0;
	int threads_ = 1;
};

// --- inline, since sweeps consist of it ----------------------------------------------------------

template <int dim>
template <class Visit>
void PlannedPairs<dim>::forEach(SweepOrder order, Visit&& visit, int times) const
{
	const int colours = plan_.colours();
#pragma omp parallel num_threads(threads_) if (threads_ > 1)
	for (int i = 0; i < colours; ++i) {
		const int colour = order == SweepOrder::forwards ? i : colours - 1 - i;
		const auto [begin, end] =
			plan_.shareOf(colour, omp_get_thread_num(), omp_get_num_threads());
		for (int task = begin; task < end; ++task)
			for (int turn = 0; turn < times; ++turn)
				forEachOf(task, order, visit);
#pragma omp barrier
	}
}

template <int dim>
template <class Visit>
void PlannedPairs<dim>::forEachOf(int task, SweepOrder order, Visit&& visit) const
{
	const int begin = task > 0 ? plan_.taskEnd[task - 1] : 0, end = plan_.taskEnd[task];
	if (order == SweepOrder::forwards)
		for (int k = begin; k < end; ++k)
			visit(k);
	else
		for (int k = end - 1; k >= begin; --k)
			visit(k);
}

} // namespace softgrain
