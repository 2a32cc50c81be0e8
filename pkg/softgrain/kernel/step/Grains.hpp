// The grains of a system, by one index over all sets.
#pragma once

#include "Threads.hpp"
#include "grain/GrainSet.hpp"

#include <memory>
#include <vector>

namespace softgrain {

/// Grains by their index in the system, what acts on them besides contact, and lists of those that
/// are computed, move rigidly or sleep, which the phases of a step run over.
template <int dim> class Grains {
public:
	/// Adds a set; its grains get the next indices.
	void add(std::unique_ptr<GrainSet<dim>> set);

	int count() const { return static_cast<int>(place_.size()); }
	const std::vector<std::unique_ptr<GrainSet<dim>>>& sets() const { return sets_; }
	GrainSet<dim>& setOf(int g) { return *sets_[place_[g].set]; }
	const GrainSet<dim>& setOf(int g) const { return *sets_[place_[g].set]; }
	int indexInSet(int g) const { return place_[g].index; }
	bool isRigid(int g) const { return setOf(g).isRigid(indexInSet(g)); }
	bool isAsleep(int g) const { return setOf(g).isAsleep(indexInSet(g)); }
	std::vector<BodyLoad<dim>>& loads() { return loads_; }
	const std::vector<BodyLoad<dim>>& loads() const { return loads_; }

	/// Makes the lists below, where the sets say anything else than when they were made.
	void renewLists();
	const std::vector<int>& active() const { return active_; } ///< computed
	const std::vector<int>& asleep() const { return asleep_; }
	const std::vector<int>& awake() const { return awake_; } ///< active, or moving rigidly
	bool isListedAsleep(int g) const { return listed_[g] == Listed::asleep; }
	/// Another number after every change of the lists.
	long listsMade() const { return listsMade_; }

	/// phase(grain, its set, its index there), in any order.
	template <class Phase>
	void forEachOf(const std::vector<int>& grains, int threads, Phase&& phase);

private:
	struct Place {
		int set, index;
	};
	enum class Listed : char { active, rigid, asleep };

	Listed listOf(int g) const;
	void appendToLists(int g); ///< the next one

	std::vector<std::unique_ptr<GrainSet<dim>>> sets_;
	std::vector<Place> place_;
	std::vector<BodyLoad<dim>> loads_;
	std::vector<Listed> listed_; ///< by grain: the list it is in
	long listedChanges_ = 0;     ///< of activity, of all sets, when the lists were made
	long listsMade_ = 0;
	std::vector<int> active_, asleep_, awake_;
};

template <int dim>
template <class Phase>
void Grains<dim>::forEachOf(const std::vector<int>& chosen, int threads, Phase&& phase)
{
	const int count = static_cast<int>(chosen.size());
#pragma omp parallel for schedule(static) num_threads(threadsFor(count, threads))
	for (int k = 0; k < count; ++k) {
		const int g = chosen[k];
		phase(g, *sets_[place_[g].set], place_[g].index);
	}
}

} // namespace softgrain
