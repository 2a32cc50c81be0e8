// What the sweeps of rigid bodies begin with: ContactSolver::adjustImpulses.
#include "contact/solve/ContactSolver.hpp"

#include <algorithm>

namespace softgrain {

namespace {

/// Impulses of the last step that exchange less than such a share of what they have hold each
/// other, as under pressure: they may do so in this step.
constexpr double leastExchange = 1e-6;

/// They are made no longer than so many times what they were.
constexpr double mostStretch = 2;

/// Where they would be shorter than this, an impact of few bodies may be the reason, in which the
/// others, at rest, have no part.
constexpr double leastHarmless = 0.5;

} // namespace

template <int dim> void ContactSolver<dim>::beginWithShares()
{
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		if (auto* contact = pairs_.rigid(k); contact && takesPart(k))
			contact->beginWith(islands_[pairs_.islandOf(k)].firstShare);
	});
}

template <int dim> void ContactSolver<dim>::findFirstShares()
{
	std::vector<Exchange> sums(islands_.size());
	for (int k = 0; k < pairs_.count(); ++k) {
		const int island = pairs_.islandOf(k);
		if (const auto* contact = pairs_.rigid(k)) sums[island] += contact->exchange();
		const auto* pair = pairs_.grainOnRigid(k);
		if (pair && pair->movesPartner()) islands_[island].takesPart = false;
	}
	for (std::size_t i = 0; i < islands_.size(); ++i) {
		IslandSweeps& island = islands_[i];
		const Exchange& sum = sums[i];
		if (!island.takesPart || !(sum.exchanged > leastExchange * sum.present)) continue;
		island.exchangedAtFirst = sum.exchanged;
		island.firstShare = std::clamp(sum.wanted / sum.exchanged, 0., mostStretch);
	}
}

template <int dim> void ContactSolver<dim>::adjustImpulses()
{
	if (!select([](const IslandSweeps& island) { return island.countsExchange(); })) return;
	findFirstShares();
	auto mayHarm = [](const IslandSweeps& island) { return island.firstShare < leastHarmless; };
	if (select(mayHarm)) measureIslands();
	const std::vector<IslandSweeps> before = islands_;
	if (!select([](const IslandSweeps& island) { return island.firstShare != 1; })) return;
	beginWithShares();
	if (!select(mayHarm)) return;
	measureIslands();
	for (std::size_t i = 0; i < islands_.size(); ++i) {
		IslandSweeps& island = islands_[i];
		island.takesPart = island.takesPart && !(island.violation < before[i].violation);
		if (island.takesPart) island.firstShare = 1;
	}
	beginWithShares();
}

template void ContactSolver<2>::adjustImpulses();
template void ContactSolver<3>::adjustImpulses();

} // namespace softgrain
