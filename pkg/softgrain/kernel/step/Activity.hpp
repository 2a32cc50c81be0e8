// Which grains of a system are computed, which move as rigid bodies, and which sleep.
//
// A grain at rest among grains at rest falls asleep. Beside one that is awake a sleeper is held
// where it is, and remembers what the pair did to it when it fell asleep: once that changes by more
// than it bears, it wakes (doc/decisions/0014-inactive-grains.md).
//
// Falling asleep is an impulse on every node, at t_n after the contacts were solved, that brings it
// to rest: positions, internal forces and contact impulses stay those of t_n, and the work of that
// impulse is what is booked as dropped.
#pragma once

#include "Islands.hpp"
#include "step/Grains.hpp"
#include "step/StepSettings.hpp"
#include "step/Surfaces.hpp"

#include <vector>

namespace softgrain {

/// What grains lost by falling asleep in a step, and what sleepers took up beside others.
struct DroppedMotion {
	double momentum = 0; ///< sum over the grains, N s
	double energy = 0;   ///< kinetic, J
};

template <int dim> class Activity {
public:
	/// Of these grains and their surfaces, which must outlive it.
	Activity(Grains<dim>& grains, Surfaces<dim>& surfaces)
		: grains_(grains)
		, surfaces_(surfaces)
	{
	}
	/// After a set was added.
	void followNewGrains();

	/// Wakes sleeping grains whose load is another. So many threads share the calls of
	/// `loadOf(g)`, which must throw nothing.
	template <class LoadOf> void setLoads(LoadOf&& loadOf, int threads);
	/// A grain about which something was changed by hand.
	void wake(int g);
	/// A grain whose velocities are changed by hand, by `speed` (m/s) at most: wakes it, and in
	/// the step to come the sleepers beside it that do not bear the force which does the same
	/// in the time `kick` (s). Held they would take up what goes on to them.
	void jolt(int g, double speed, double kick);
	/// What a sleeping grain is saved with besides its state: the load under which it sleeps
	/// and the number of its pairs in contact. Empty if it is awake.
	std::vector<double> sleepNumbers(int g) const;
	void restoreSleep(int g, const std::vector<double>& numbers);

	/// Whether a pair of sleepers is to be searched: once, and when it does not lie still any
	/// more, which is noted.
	bool isSearchDue(ContactList<dim>& list) const;

	/// At the beginning of a step in which forces act for `kick`: wakes grains about which
	/// something changed.
	void wakeChanged(const std::vector<ContactList<dim>*>& lists, double kick, bool sleep);
	/// Then: grains that are touched, or spin too fast, are computed; undeformed ones without
	/// contact move rigidly, and sleep if they do not move and nothing drives them.
	void chooseRigidGrains(const std::vector<char>& touched, const StepSettings& settings);
	/// Then, with the lists of those who are awake: which grains sleep beside them.
	void noteSleepersBesideAwake(const std::vector<ContactList<dim>*>& lists);
	const std::vector<int>& besideAwake() const { return besideAwake_; }
	/// Then, in step number `step`: which grains rest, and will fall asleep at the end of it if
	/// forces balance then and all that they touch do so, too.
	void findRested(const std::vector<ContactList<dim>*>& lists,
			const std::vector<char>& touched, const StepSettings& settings, long step);
	const std::vector<int>& rested() const { return rested_; }
	/// With the new velocities, before the grains move.
	DroppedMotion fallAsleep(const std::vector<ContactList<dim>*>& lists, double kick);
	/// At the end of the step: wakes sleepers beside others that are pushed otherwise than when
	/// they fell asleep by more than they bear; `sleeping` are the lists of sleepers alone.
	/// Returns how much others push them otherwise, summed over them, N s.
	double wakeStrained(const std::vector<ContactList<dim>*>& lists,
			    const std::vector<ContactList<dim>*>& sleeping, double kick);

private:
	struct Changes {
		std::vector<int> grains; ///< to be woken
		bool ofPairs = false;    ///< a pair kept for sleepers may be one no more
	};

	bool sleepBoth(const ContactList<dim>& list) const;
	bool liesStill(const ContactList<dim>& list) const;
	bool isHeldBesideAwake(const ContactList<dim>& list, int side) const;
	bool feelsJolt(const ContactList<dim>& list, int side) const;
	bool bears(int g, double force, const BodyLoad<dim>& beside) const;
	void joltBy(int g, double force);
	const GrainParameters<dim>& parametersOf(int g) const
	{
		return grains_.setOf(g).parameters(grains_.indexInSet(g));
	}
	double massOf(int g) const;
	Changes changesOf(const std::vector<ContactList<dim>*>& lists, bool sleep) const;
	Islands islandsInContact(const std::vector<ContactList<dim>*>& lists) const;
	void endRestOf(const std::vector<ContactList<dim>*>& lists, double kick);
	void keepAmongRested(const std::vector<ContactList<dim>*>& lists);
	void keepBalanced(const std::vector<ContactList<dim>*>& lists, double kick);
	bool mayComeToRest(const StepSettings& settings, std::vector<double>& periods);
	void noteRest(ContactList<dim>& list, double kick, const std::vector<char>& fellAsleep);

	Grains<dim>& grains_;
	Surfaces<dim>& surfaces_;
	std::vector<int> rested_;      ///< falling asleep in the step at hand
	std::vector<int> besideAwake_; ///< asleep, in contact with one that is awake
	std::vector<int> resting_;     ///< by sleeping grain: its pairs in contact; -1: woken
	std::vector<double> jolt_;     ///< forces by which grains are pushed otherwise by hand, N
	bool anyJolt_ = false;
	std::vector<char> hadLoad_; ///< by grain: in a step before
	bool damped_ = false;       ///< a grain has damping
};

template <int dim>
template <class LoadOf>
void Activity<dim>::setLoads(LoadOf&& loadOf, int threads)
{
	const int count = grains_.count();
	std::vector<BodyLoad<dim>>& loads = grains_.loads();
	constexpr double none = -1;
	std::vector<double> change(count); // where some sleep, m/s^2
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int g = 0; g < count; ++g) {
		const BodyLoad<dim> load = loadOf(g);
		const bool isKnown = hadLoad_[g] || grains_.isAsleep(g); // saved with its load
		const bool same = load == loads[g] || !isKnown || grains_.asleep().empty();
		change[g] = same ? none
				 : load.difference(loads[g], surfaces_.bodies()[g].outerRadius());
		loads[g] = load;
		hadLoad_[g] = 1;
	}
	for (int g = 0; g < count; ++g)
		if (change[g] != none) {
			wake(g);
			joltBy(g, massOf(g) * change[g]);
		}
}

} // namespace softgrain
