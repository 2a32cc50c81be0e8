// In which order the pairs of bodies are swept, and which of them at the same time.
#pragma once

#include <utility>
#include <vector>

namespace softgrain {

/// Numbers of the two bodies of a pair, as far as other pairs feel what it does to them; the second
/// is -1 where they do not: a wall, a rigid body that no impulse moves.
struct BodiesOfPair {
	int first, second;
	int work = 1; ///< how long a visit of the pair takes, in any unit

	bool operator==(const BodiesOfPair& other) const
	{
		return first == other.first && second == other.second && work == other.work;
	}
};

/// Bodies are gathered in *clusters* of neighbours. The pairs within a cluster are one *task*,
/// those between two clusters another: a task is swept by one thread, pair after pair, while its
/// bodies are at hand in the cache. Tasks of one *colour* have no cluster in common, so threads
/// share them; colours follow one another. Within a colour tasks of neighbouring clusters are near
/// each other, so that a thread meets the same bodies again. The plan depends on the pairs alone,
/// however many threads follow it.
struct SweepPlan {
	std::vector<int> pairs;     ///< numbers of the pairs, task by task
	std::vector<int> taskEnd;   ///< number of pairs up to the end of each task
	std::vector<int> colourEnd; ///< number of tasks up to the end of each colour
	std::vector<long> workEnd;  ///< work of the pairs up to the end of each task
	/// Of each pair, in this order. Impulses of pairs on different *islands* never reach each
	/// other: no chain of pairs with bodies in common leads from one to the other.
	std::vector<int> island;
	int islands = 0;

	int colours() const { return static_cast<int>(colourEnd.size()); }
	int tasks() const { return static_cast<int>(taskEnd.size()); }
	/// Of the tasks of a colour the part-th of so many shares (from 0), as the first task and
	/// the one behind the last: about as much work in each, and mostly the same bodies in all
	/// colours.
	std::pair<int, int> shareOf(int colour, int part, int parts) const;
};

/// Plan for pairs of so many bodies.
SweepPlan planSweeps(const std::vector<BodiesOfPair>& pairs, int bodies);

} // namespace softgrain
