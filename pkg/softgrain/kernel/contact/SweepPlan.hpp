// In which order the pairs of bodies are swept, and which of them at the same time.
#pragma once

#include "contact/Contact.hpp"

#include <vector>

namespace softgrain {

/// Bodies are gathered in *clusters* of neighbours. The pairs within a cluster are one *task*,
/// those between two clusters another: a task is swept by one thread, pair after pair, while its
/// bodies are at hand in the cache. Tasks of one *colour* have no cluster in common, so threads
/// share them; colours follow one another. The plan depends on the pairs alone, however many
/// threads follow it.
template <int dim> struct SweepPlan {
	std::vector<ContactList<dim>*> pairs; ///< task by task
	std::vector<int> taskEnd;             ///< number of pairs up to the end of each task
	std::vector<int> colourEnd;           ///< number of tasks up to the end of each colour

	int colours() const { return static_cast<int>(colourEnd.size()); }
	int tasks() const { return static_cast<int>(taskEnd.size()); }
};

/// Plan for pairs of so many bodies and the rigid partners after them; partners that no impulse
/// moves are no body.
template <int dim>
SweepPlan<dim> planSweeps(const std::vector<ContactList<dim>*>& lists, int bodies,
			  int partners = 0);

} // namespace softgrain
