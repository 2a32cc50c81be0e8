#include "contact/solve/ContactSolver.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace softgrain {

namespace {

/// Sweeps that every step makes, so many backwards and then so many forwards: what the impulses
/// still lack then answers to the velocities as springs would, and feeds no vibration
/// (doc/decisions/0010-grains-at-rest.md).
/// Where impulses move grains alone, whose pairs hardly feel each other, a task makes them in a
/// row: that spares half of the barriers and of the way to memory. Free rigid bodies hand impulses
/// on at once, and in packings of them that are swept so overlaps grow
/// (doc/decisions/0015-parallel-sweeps.md).
constexpr int sweepsEachWay = 2;

/// Sweeps that move rigid bodies out of overlaps. With fewer, what is pushed at one end of a
/// packing overlaps at the other: after 4 a squeezed packing creeps
/// (doc/decisions/0020-rigid-contact-dynamics.md).
constexpr int separatingSweeps = 20;

/// Pairs on their own aim at so much of the tolerance: what they do to each other is little, and
/// changes the scale of the residual.
constexpr double marginAlone = 0.95;

/// The violation that pairs may keep, and the others have to come down to, for all together to have
/// so much.
double commonLevel(const std::vector<ResidualSum>& pairs, double total)
{
	double level = 0;
	for (std::size_t last = pairs.size() + 1;;) {
		double left = total;
		std::size_t above = 0;
		for (const ResidualSum& pair : pairs)
			if (pair.violation() > level)
				++above;
			else
				left -= pair.violation();
		if (above == 0 || above == last) return level;
		level = left / above;
		last = above;
	}
}

} // namespace

template <int dim>
void ContactSolver<dim>::plan(const std::vector<ContactList<dim>*>& lists, int grains,
			      std::vector<RigidPartner<dim>>* partners,
			      std::vector<RigidContact<dim>>* rigidContacts)
{
	forget();
	pairs_.plan(lists, grains, partners, rigidContacts);
}

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, double dt,
				 const SolverSettings& settings, int threads)
{
	settings_ = settings;
	pairs_.prepare(bodies, dt, settings, threads);
	noteIslands();
	adjustImpulses();
}

template <int dim> void ContactSolver<dim>::noteIslands()
{
	islands_.assign(pairs_.islands(), {});
	residuals_.assign(pairs_.count(), {});
	change_.assign(pairs_.count(), {});
	std::vector<HeldMotion<dim>> held(islands_.size());
	for (int k = 0; k < pairs_.count(); ++k) {
		IslandSweeps& island = islands_[pairs_.islandOf(k)];
		island.contacts += pairs_.with(k, [](const auto& pair) { return pair.contacts(); });
		island.solvesPairsAlone |= pairs_.grains(k) != nullptr;
		island.movesRigidBodies |= pairs_.movesRigidBodies(k);
		pairs_.addHeldMotion(k, held[pairs_.islandOf(k)]);
	}
	for (std::size_t i = 0; i < islands_.size(); ++i)
		islands_[i].isDriven = held[i].isFelt();
}

template <int dim> void ContactSolver<dim>::sweep(SweepOrder order, int times)
{
	pairs_.forEach(
		order,
		[&](int k) {
			if (!takesPart(k)) return;
			pairs_.fetchForSweep(k, order);
			change_[k] = pairs_.with(k, [&](auto& pair) { return pair.sweep(order); });
		},
		times);
	for (IslandSweeps& island : islands_)
		if (island.takesPart) island.change = {};
	for (int k = 0; k < pairs_.count(); ++k)
		if (takesPart(k)) islands_[pairs_.islandOf(k)].change += change_[k];
}

template <int dim> void ContactSolver<dim>::extrapolate()
{
	if (!select([this](const IslandSweeps& island) {
		    return island.countsExchange() && isLeft(island);
	    }))
		return;
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		if (!takesPart(k)) return;
		const double share = islands_[pairs_.islandOf(k)].extrapolationShare;
		if (auto* contact = pairs_.rigid(k)) contact->extrapolate(share);
		if (auto* pair = pairs_.grainOnRigid(k)) pair->extrapolate(share);
	});
}

template <int dim> std::vector<double> ContactSolver<dim>::levelsAlone() const
{
	std::vector<std::vector<ResidualSum>> ofIsland(islands_.size());
	for (int k = 0; k < pairs_.count(); ++k)
		if (takesPart(k)) ofIsland[pairs_.islandOf(k)].push_back(residuals_[k]);
	const std::vector<ResidualSum> sums = sumsOfIslands();
	const double tolerance = marginAlone * settings_.tolerance;
	std::vector<double> levels(islands_.size());
	for (std::size_t i = 0; i < islands_.size(); ++i)
		levels[i] = commonLevel(ofIsland[i], tolerance * tolerance * sums[i].scale());
	return levels;
}

template <int dim> std::vector<long> ContactSolver<dim>::solvePairsAlone()
{
	const std::vector<double> levels = levelsAlone();
	visits_.assign(pairs_.count(), 0);
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		PairSolver<dim>* pair = pairs_.grains(k);
		if (!pair || !takesPart(k)) return;
		const double level = levels[pairs_.islandOf(k)];
		if (residuals_[k].violation() <= level || !pair->canBeSolvedAlone()) return;
		visits_[k] = static_cast<long>(pair->contacts()) *
			     pair->solveAlone(level, settings_.maxSweeps);
	});
	std::vector<long> visits(islands_.size(), 0);
	for (int k = 0; k < pairs_.count(); ++k)
		visits[pairs_.islandOf(k)] += visits_[k];
	return visits;
}

template <int dim> bool ContactSolver<dim>::bearsNothing()
{
	if (lastActive_ > 0) return false;
	select([](const IslandSweeps&) { return true; });
	measurePairs();
	return std::all_of(residuals_.begin(), residuals_.end(), [](const ResidualSum& sum) {
		return sum.violation() == 0 && sum.scale() == 0; // nan is something
	});
}

template <int dim> std::vector<ResidualSum> ContactSolver<dim>::sumsOfIslands() const
{
	std::vector<ResidualSum> sums(islands_.size());
	for (int k = 0; k < pairs_.count(); ++k)
		sums[pairs_.islandOf(k)] += residuals_[k];
	for (std::size_t i = 0; i < islands_.size(); ++i)
		if (islands_[i].countsExchange())
			sums[i].countExchanged(islands_[i].exchangedAtFirst);
	return sums;
}

template <int dim> void ContactSolver<dim>::measurePairs()
{
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		if (!takesPart(k)) return;
		pairs_.fetchForSweep(k, SweepOrder::forwards);
		residuals_[k] = pairs_.with(k, [](const auto& pair) { return pair.residual(); });
	});
}

template <int dim> void ContactSolver<dim>::measureIslands()
{
	if (std::none_of(islands_.begin(), islands_.end(),
			 [](const IslandSweeps& island) { return island.takesPart; }))
		return;
	measurePairs();
	const std::vector<ResidualSum> sums = sumsOfIslands();
	for (std::size_t i = 0; i < islands_.size(); ++i)
		if (islands_[i].takesPart) islands_[i].measure(sums[i]);
}

template <int dim> void ContactSolver<dim>::sweepBothWays()
{
	const int count = std::min(2 * sweepsEachWay, settings_.maxSweeps);
	for (const bool moveRigidBodies : { false, true }) {
		if (!select([&](const IslandSweeps& island) {
			    return island.movesRigidBodies == moveRigidBodies;
		    }))
			continue;
		const int inARow = moveRigidBodies ? 1 : sweepsEachWay;
		for (int k = 0; k < count; k += inARow)
			sweep(k < sweepsEachWay ? SweepOrder::backwards : SweepOrder::forwards,
			      std::min(inARow, count - k));
	}
	for (IslandSweeps& island : islands_)
		island.count(count);
}

/// Pairs are solved alone before the first sweep of a turn.
template <int dim> void ContactSolver<dim>::beginTurns()
{
	for (IslandSweeps& island : islands_)
		island.residualBefore = island.residual;
	if (select([this](const IslandSweeps& island) {
		    return isLeft(island) && island.sweepsThisTurn == 0 && island.solvesPairsAlone;
	    })) {
		const std::vector<long> alone = solvePairsAlone();
		for (std::size_t i = 0; i < islands_.size(); ++i) {
			islands_[i].visits += alone[i];
			islands_[i].takesPart = alone[i] > 0;
		}
		measureIslands();
	}
	for (IslandSweeps& island : islands_)
		if (isLeft(island) && island.sweepsThisTurn == 0) island.beginTurn();
}

template <int dim> void ContactSolver<dim>::sweepToTolerance()
{
	auto isPromising = [this](const IslandSweeps& island) {
		return island.isPromising(settings_.tolerance, settings_.maxSweeps);
	};
	auto selectLeft = [this] {
		return select([this](const IslandSweeps& island) { return isLeft(island); });
	};
	for (IslandSweeps& island : islands_)
		island.beginSweeps();
	sweepBothWays();
	select([&](const IslandSweeps& island) {
		return island.solvesPairsAlone || isPromising(island);
	});
	measureIslands();
	while (selectLeft()) {
		beginTurns();
		extrapolate();
		if (!selectLeft()) return;
		sweep(SweepOrder::forwards, 1);
		for (IslandSweeps& island : islands_)
			if (island.takesPart) island.noteSweep();
		select([&](const IslandSweeps& island) {
			return island.takesPart &&
			       (isPromising(island) ||
				(island.solvesPairsAlone && island.isTurnOver()));
		});
		measureIslands();
		for (IslandSweeps& island : islands_)
			if (island.isTurnOver()) island.sweepsThisTurn = 0;
	}
}

template <int dim> void ContactSolver<dim>::reportSweeps(SolverReport& report) const
{
	for (const IslandSweeps& island : islands_)
		report.visits += island.visits;
	report.residual = largestResidual();
	report.converged = report.residual <= settings_.tolerance;
	report.sweeps = static_cast<double>(report.visits) / report.contacts;
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	for (const IslandSweeps& island : islands_)
		report.contacts += island.contacts;
	solved_ = report.contacts == 0;
	if (solved_) return report;
	if (!bearsNothing()) {
		sweepToTolerance();
		reportSweeps(report);
	}
	if (!std::isfinite(report.residual)) return report;
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		pairs_.fetchForFinish(k);
		pairs_.with(k, [](auto& pair) { pair.finish(); });
	});
	for (int k = 0; k < pairs_.count(); ++k)
		report.active += pairs_.with(k, [](const auto& pair) { return pair.active(); });
	lastActive_ = report.active;
	solved_ = true;
	return report;
}

template <int dim> void ContactSolver<dim>::separateRigidBodies(double dt)
{
	bool overlaps = false;
	for (int k = 0; k < pairs_.count(); ++k)
		if (auto* contact = pairs_.rigid(k))
			overlaps |= contact->findSeparation(dt, settings_);
	if (!overlaps) return;
	for (int sweep = 0; sweep < separatingSweeps; ++sweep)
		pairs_.forEach(sweep < sweepsEachWay ? SweepOrder::backwards : SweepOrder::forwards,
			       [&](int k) {
				       if (auto* contact = pairs_.rigid(k)) contact->separate();
			       });
}

template <int dim> double ContactSolver<dim>::residual()
{
	select([](const IslandSweeps&) { return true; });
	measureIslands();
	return largestResidual();
}

template <int dim> double ContactSolver<dim>::largestResidual() const
{
	double largest = 0;
	for (const IslandSweeps& island : islands_) {
		if (std::isnan(island.residual)) return island.residual;
		largest = std::max(largest, island.residual);
	}
	return largest;
}

template <int dim> ContactWork ContactSolver<dim>::work() const
{
	std::vector<ContactWork> works(pairs_.count());
	const int threads = pairs_.threads();
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1)
	for (int k = 0; k < pairs_.count(); ++k)
		pairs_.withGrainPair(k, [&](const auto& pair) { works[k] = pair.work(); });
	ContactWork work;
	for (const ContactWork& ofPair : works)
		work += ofPair;
	return work;
}

template <int dim> ContactWork ContactSolver<dim>::rigidWork() const
{
	ContactWork work;
	for (int k = 0; k < pairs_.count(); ++k)
		if (const auto* contact = pairs_.rigid(k)) work += contact->work();
	return work;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
