// Problems that are large enough for several threads, and whether they are.
#pragma once

#include "contact/solve/PlannedPairs.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace softgrain::testing {

/// Bodies in a square lattice, numbered at random as those of a packing are.
inline std::vector<BodiesOfPair> latticeOf(int side)
{
	std::vector<int> number(side * side);
	std::iota(number.begin(), number.end(), 0);
	std::shuffle(number.begin(), number.end(), std::mt19937(1));
	std::vector<BodiesOfPair> pairs;
	auto touch = [&](int a, int b) { pairs.push_back({ number[a], number[b] }); };
	for (int i = 0; i < side; ++i)
		for (int j = 0; j + 1 < side; ++j) {
			touch(i * side + j, i * side + j + 1);
			touch(j * side + i, (j + 1) * side + i);
		}
	return pairs;
}

/// How many of so many threads share the sweeps: one where colours have few pairs. Asked on copies:
/// warm starts and interfaces change what they are prepared with.
template <int dim, class Lists>
int threadsThatShare(const Lists& given, std::vector<ContactBody<dim>> bodies,
		     std::vector<RigidPartner<dim>> partners,
		     std::vector<RigidContact<dim>> rigidContacts, int threads)
{
	std::vector<ContactList<dim>> lists(given.begin(), given.end());
	std::vector<ContactList<dim>*> pointers;
	for (ContactList<dim>& list : lists)
		pointers.push_back(&list);
	PlannedPairs<dim> pairs;
	pairs.plan(pointers, static_cast<int>(bodies.size()), &partners, &rigidContacts);
	pairs.prepare(bodies, 1, {}, threads);
	return pairs.threads();
}

} // namespace softgrain::testing
