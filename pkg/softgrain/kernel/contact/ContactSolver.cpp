#include "contact/ContactSolver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
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

/// Worth measuring the residual: it was 0.55 to 1.1 times the change of the sweep before it in
/// problems of a compaction.
constexpr double changePerResidual = 2;

/// Sweeps that move rigid bodies out of overlaps. With fewer, what is pushed at one end of a
/// packing overlaps at the other: after 4 a squeezed packing creeps
/// (doc/decisions/0020-rigid-contact-dynamics.md).
constexpr int separatingSweeps = 20;

/// Impulses of the last step that exchange less than such a share of what they have hold each
/// other, as under pressure: they may do so in this step.
constexpr double leastExchange = 1e-6;

/// They are made no longer than so many times what they were.
constexpr double mostStretch = 2;

/// Where they would be shorter than this, it may be for an impact of few, which the others, at
/// rest, have no part in.
constexpr double leastHarmless = 0.5;

/// Pairs on their own aim at so much of the tolerance: what they do to each other is little, and
/// changes the scale of the residual.
constexpr double marginAlone = 0.95;

/// Where pairs on their own leave more of the residual, they feel each other (as coarse grains and
/// those with corners do): all contacts are swept twice as often before pairs are tried again.
constexpr double fallAlone = 0.5;

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
	countsExchange_ = pairs_.moveRigidBodies() && !pairs_.areDriven();
	exchangedAtFirst_ = 0;
	if (countsExchange_) adjustImpulses();
}

template <int dim> SweepChange ContactSolver<dim>::sweep(SweepOrder order, int times)
{
	change_.resize(pairs_.count());
	pairs_.forEach(
		order,
		[&](int k) {
			pairs_.fetchForSweep(k, order);
			change_[k] = pairs_.with(k, [&](auto& pair) { return pair.sweep(order); });
		},
		times);
	SweepChange sum;
	for (const SweepChange& change : change_)
		sum += change;
	return sum;
}

template <int dim> void ContactSolver<dim>::extrapolate(double share)
{
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		if (auto* contact = pairs_.rigid(k)) contact->extrapolate(share);
		if (auto* pair = pairs_.grainOnRigid(k)) pair->extrapolate(share);
	});
}

template <int dim>
long ContactSolver<dim>::solvePairsAlone(const std::vector<ResidualSum>& residuals)
{
	const double tolerance = marginAlone * settings_.tolerance;
	const double level =
		commonLevel(residuals, tolerance * tolerance * sumOver(residuals).scale());
	visits_.assign(pairs_.count(), 0);
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		PairSolver<dim>* pair = pairs_.grains(k);
		if (!pair || residuals[k].violation() <= level || !pair->canBeSolvedAlone()) return;
		visits_[k] = static_cast<long>(pair->contacts()) *
			     pair->solveAlone(level, settings_.maxSweeps);
	});
	return std::accumulate(visits_.begin(), visits_.end(), 0L);
}

template <int dim> bool ContactSolver<dim>::bearsNothing() const
{
	if (lastActive_ > 0) return false;
	const ResidualSum sum = sumOver(residualsOfPairs());
	return sum.violation() == 0 && sum.scale() == 0; // nan is something
}

template <int dim> void ContactSolver<dim>::adjustImpulses()
{
	Exchange sum;
	for (int k = 0; k < pairs_.count(); ++k) {
		if (const auto* contact = pairs_.rigid(k)) sum += contact->exchange();
		const auto* pair = pairs_.grainOnRigid(k);
		if (pair && pair->movesPartner()) return;
	}
	if (!(sum.exchanged > leastExchange * sum.present)) return;
	exchangedAtFirst_ = sum.exchanged;
	const double share = std::clamp(sum.wanted / sum.exchanged, 0., mostStretch);
	if (share == 1) return;
	auto beginWith = [this](double part) {
		pairs_.forEach(SweepOrder::forwards, [&](int k) {
			if (auto* contact = pairs_.rigid(k)) contact->beginWith(part);
		});
	};
	auto violation = [this] { return sumOver(residualsOfPairs()).violation(); };
	const bool mayHarm = share < leastHarmless;
	const double before = mayHarm ? violation() : 0;
	beginWith(share);
	if (mayHarm && !(violation() < before)) beginWith(1);
}

template <int dim>
ResidualSum ContactSolver<dim>::sumOver(const std::vector<ResidualSum>& pairs) const
{
	ResidualSum sum;
	for (const ResidualSum& pair : pairs)
		sum += pair;
	if (countsExchange_) sum.countExchanged(exchangedAtFirst_);
	return sum;
}

template <int dim> void ContactSolver<dim>::sweepToTolerance(SolverReport& report)
{
	const int cap = settings_.maxSweeps, inARow = pairs_.moveRigidBodies() ? 1 : sweepsEachWay;
	const bool withGrains = pairs_.haveGrains();
	std::vector<ResidualSum> residuals;
	int sweeps = 0;
	double strictness = 1;
	SweepChange change;
	auto sweepAll = [&](SweepOrder order, int times) {
		change = sweep(order, times);
		sweeps += times;
		report.visits += static_cast<long>(times) * report.contacts;
	};
	auto measure = [&] {
		residuals = residualsOfPairs();
		const ResidualSum sum = sumOver(residuals);
		report.residual = sum.value();
		strictness = sum.strictness();
	};
	auto isPromising = [&] {
		return sweeps == cap ||
		       change.share() <= changePerResidual * strictness * settings_.tolerance;
	};
	auto isDone = [&] { return !(report.residual > settings_.tolerance) || sweeps == cap; };
	for (int k = 0; k < std::min(2 * sweepsEachWay, cap); k += inARow)
		sweepAll(k < sweepsEachWay ? SweepOrder::backwards : SweepOrder::forwards,
			 std::min(inARow, cap - k));
	Extrapolation extrapolation;
	double beyond = 0;
	auto sweepOn = [&] {
		if (countsExchange_) extrapolate(beyond);
		sweepAll(SweepOrder::forwards, 1);
		beyond = extrapolation.shareAfter(change);
	};
	report.residual = std::numeric_limits<double>::infinity(); // until measured
	if (withGrains || isPromising()) measure();
	for (int between = 1; !isDone();) { // sweeps over all, until pairs are solved again
		const double before = report.residual;
		const long alone = withGrains ? solvePairsAlone(residuals) : 0;
		report.visits += alone;
		if (alone > 0) measure();
		between = report.residual < fallAlone * before ? 1 : 2 * between;
		for (int k = 1; k <= between && !isDone(); ++k) {
			sweepOn();
			if (isPromising() || (withGrains && k == between)) measure();
		}
	}
	report.converged = report.residual <= settings_.tolerance;
	report.sweeps = static_cast<double>(report.visits) / report.contacts;
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	for (int k = 0; k < pairs_.count(); ++k)
		report.contacts += pairs_.with(k, [](const auto& pair) { return pair.contacts(); });
	solved_ = report.contacts == 0;
	if (solved_) return report;
	if (!bearsNothing()) sweepToTolerance(report);
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

template <int dim> std::vector<ResidualSum> ContactSolver<dim>::residualsOfPairs() const
{
	std::vector<ResidualSum> sums(pairs_.count());
	pairs_.forEach(SweepOrder::forwards, [&](int k) {
		pairs_.fetchForSweep(k, SweepOrder::forwards);
		sums[k] = pairs_.with(k, [](const auto& pair) { return pair.residual(); });
	});
	return sums;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	return sumOver(residualsOfPairs()).value();
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
