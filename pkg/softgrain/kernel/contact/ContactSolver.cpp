#include "contact/ContactSolver.hpp"
#include "Fetch.hpp"
#include "Threads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <omp.h>
#include <stdexcept>
#include <utility>

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

/// More pairs are not kept in the caches from sweep to sweep.
constexpr int pairsInCache = 4000;

/// While one pair is worked on, those that come so many and twice so many after it are asked for:
/// by `prepare` always, by sweeps where pairs do not stay in the caches
/// (doc/decisions/0029-memory.md).
constexpr int pairsAhead = 2;

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

/// With fewer pairs a colour than this, threads would wait longer than they work.
constexpr int pairsPerThread = 8;

/// A pair of grains has so many times the work of a contact of two rigid bodies.
constexpr int rigidContactsPerPair = 16;

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
	lists_.clear();
	bodiesOf_.clear();
	listed_.clear();
	partners_ = partners;
	contactsOfRigid_ = rigidContacts;
	for (ContactList<dim>* list : lists) {
		if (list->contacts.empty()) continue;
		lists_.push_back(list);
		bodiesOf_.push_back(
			{ list->first, list->sharedSecond(grains), rigidContactsPerPair });
		listed_.push_back(
			{ list->rigid ? Kind::grainOnRigid : Kind::grains, list->contacts.size() });
	}
	if (rigidContacts)
		for (const RigidContact<dim>& c : *rigidContacts) {
			const bool both =
				(*partners)[c.first].moves() && (*partners)[c.second].moves();
			const int first = (*partners)[c.first].moves() ? c.first : c.second;
			bodiesOf_.push_back({ grains + first, both ? grains + c.second : -1 });
			listed_.push_back({ Kind::rigid, 1 });
		}
	count_ = static_cast<int>(bodiesOf_.size());
	const int bodies = grains + (partners ? static_cast<int>(partners->size()) : 0);
	if (bodies != plannedBodies_ || bodiesOf_ != planned_) {
		plan_ = planSweeps(bodiesOf_, bodies);
		planned_ = bodiesOf_;
		plannedBodies_ = bodies;
	}
	makeRoom();
}

/// A solver for each pair, and constraints for its contacts.
template <int dim> void ContactSolver<dim>::makeRoom()
{
	change_.resize(count_);
	slot_.clear();
	constraintsBegin_.clear();
	std::size_t constraints = 0;
	int used[3] = { 0, 0, 0 };
	for (int k = 0, task = 0; k < count_; ++k) {
		while (k == plan_.taskEnd[task])
			++task;
		const Listed& pair = listed_[plan_.pairs[k]];
		slot_.push_back({ pair.kind, used[static_cast<int>(pair.kind)]++, task });
		constraintsBegin_.push_back(constraints);
		if (pair.kind == Kind::grains) constraints += pair.contacts;
	}
	constraintsBegin_.push_back(constraints);
	auto holdAtLeast = [](auto& kept, std::size_t count) {
		if (kept.size() < count) kept.resize(count);
	};
	holdAtLeast(pairs_, used[0]);
	holdAtLeast(rigidPairs_, used[1]);
	holdAtLeast(rigidContacts_, used[2]);
	holdAtLeast(constraints_, constraints);
}

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, double dt,
				 const SolverSettings& settings, int threads)
{
	settings_ = settings;
	const int listed = static_cast<int>(lists_.size());
	const int work = listed + (count_ - listed) / rigidContactsPerPair;
	threads_ = threadsFor(work / std::max(plan_.colours(), 1), threads, pairsPerThread);
	if (partners_)
		for (RigidPartner<dim>& partner : *partners_)
			partner.noteFree();
	if (dim == 3) noteNodesInContact(bodies);
	forEachPair(SweepOrder::forwards, [&](int k) {
		fetchForPrepare(k);
		const Kind kind = slot_[k].kind;
		const int index = slot_[k].index;
		const int pair = plan_.pairs[k];
		if (kind == Kind::rigid)
			rigidContacts_[index].prepare((*contactsOfRigid_)[pair - listed],
						      *partners_, dt);
		else if (kind == Kind::grainOnRigid)
			rigidPairs_[index].prepare(bodies, *lists_[pair], *partners_, dt, settings);
		else
			pairs_[index].prepare(bodies, *lists_[pair], dt, settings,
					      &constraints_[constraintsBegin_[k]]);
	});
	countsExchange_ = movesRigidBodies() && !isDriven();
	exchangedAtFirst_ = 0;
	if (countsExchange_) adjustImpulses();
}

template <int dim>
void ContactSolver<dim>::noteNodesInContact(std::vector<ContactBody<dim>>& bodies)
{
	forEachPair(SweepOrder::forwards, [&](int k) {
		if (slot_[k].kind == Kind::rigid) return;
		const ContactList<dim>& list = *lists_[plan_.pairs[k]];
		ContactBody<dim>* first = &bodies[list.first];
		ContactBody<dim>* second = list.second < 0 ? nullptr : &bodies[list.second];
		for (const Contact<dim>& c : list.contacts) {
			const bool onFirst = c.key.side == 0;
			if (ContactBody<dim>* own = onFirst ? first : second)
				own->noteContactAt(c.key.node);
			if (ContactBody<dim>* other = onFirst ? second : first)
				for (int i = 0; i < c.partners; ++i)
					other->noteContactAt(c.partner[i]);
		}
	});
}

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachPair(SweepOrder order, Visit&& visit, int times) const
{
	const int colours = plan_.colours();
#pragma omp parallel num_threads(threads_) if (threads_ > 1)
	for (int i = 0; i < colours; ++i) {
		const int colour = order == SweepOrder::forwards ? i : colours - 1 - i;
		const auto [begin, end] =
			plan_.shareOf(colour, omp_get_thread_num(), omp_get_num_threads());
		for (int task = begin; task < end; ++task)
			for (int turn = 0; turn < times; ++turn)
				forEachPairOf(task, order, visit);
#pragma omp barrier
	}
}

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachPairOf(int task, SweepOrder order, Visit&& visit) const
{
	const int begin = task > 0 ? plan_.taskEnd[task - 1] : 0, end = plan_.taskEnd[task];
	if (order == SweepOrder::forwards)
		for (int k = begin; k < end; ++k)
			visit(k);
	else
		for (int k = end - 1; k >= begin; --k)
			visit(k);
}

template <int dim> bool ContactSolver<dim>::staysInCache() const { return count_ <= pairsInCache; }

template <int dim>
void ContactSolver<dim>::fetch(int k, void (PairSolver<dim>::*what)() const) const
{
	if (k < 0 || k >= count_) return;
	if (slot_[k].kind == Kind::grains) (pairs_[slot_[k].index].*what)();
}

template <int dim> void ContactSolver<dim>::fetchAfter(int k, SweepOrder order) const
{
	if (staysInCache()) return;
	const int ahead = order == SweepOrder::forwards ? pairsAhead : -pairsAhead;
	fetch(k + 2 * ahead, &PairSolver<dim>::fetchConstraints);
	fetch(k + ahead, &PairSolver<dim>::fetchVelocities);
}

template <int dim> void ContactSolver<dim>::fetchForPrepare(int k) const
{
	auto listOf = [this](int pair) -> const ContactList<dim>* {
		const bool listed = pair < count_ && slot_[pair].kind == Kind::grains;
		return listed ? lists_[plan_.pairs[pair]] : nullptr;
	};
	const int next = k + pairsAhead;
	if (const auto* list = listOf(next + pairsAhead)) fetchBytes(list, list + 1);
	if (const auto* list = listOf(next))
		fetchBytes(list->contacts.data(), list->contacts.data() + list->contacts.size());
	if (next < count_)
		fetchBytes(constraints_.data() + constraintsBegin_[next],
			   constraints_.data() + constraintsBegin_[next + 1]);
	// a pair of another task may be changed by another thread while it is looked at
	if (threads_ > 1 && next < count_ && slot_[next].task != slot_[k].task) return;
	fetch(next, &PairSolver<dim>::fetchBodies);
	fetch(next, &PairSolver<dim>::fetchVelocities);
}

template <int dim> SweepChange ContactSolver<dim>::sweep(SweepOrder order, int times)
{
	forEachPair(
		order,
		[&](int k) {
			fetchAfter(k, order);
			change_[k] = withPair(k, [&](auto& pair) { return pair.sweep(order); });
		},
		times);
	SweepChange sum;
	for (const SweepChange& change : change_)
		sum += change;
	return sum;
}

template <int dim> void ContactSolver<dim>::extrapolate(double share)
{
	forEachPair(SweepOrder::forwards, [&](int k) {
		const Slot& slot = slot_[k];
		if (slot.kind == Kind::rigid) rigidContacts_[slot.index].extrapolate(share);
		if (slot.kind == Kind::grainOnRigid) rigidPairs_[slot.index].extrapolate(share);
	});
}

template <int dim>
long ContactSolver<dim>::solvePairsAlone(const std::vector<ResidualSum>& residuals)
{
	const double tolerance = marginAlone * settings_.tolerance;
	const double level =
		commonLevel(residuals, tolerance * tolerance * sumOver(residuals).scale());
	visits_.assign(count_, 0);
	forEachPair(SweepOrder::forwards, [&](int k) {
		if (slot_[k].kind != Kind::grains || residuals[k].violation() <= level) return;
		PairSolver<dim>& pair = pairs_[slot_[k].index];
		if (!pair.canBeSolvedAlone()) return;
		visits_[k] = static_cast<long>(pair.contacts()) *
			     pair.solveAlone(level, settings_.maxSweeps);
	});
	return std::accumulate(visits_.begin(), visits_.end(), 0L);
}

template <int dim> bool ContactSolver<dim>::hasGrains() const
{
	return std::any_of(slot_.begin(), slot_.end(),
			   [](const Slot& slot) { return slot.kind == Kind::grains; });
}

template <int dim> bool ContactSolver<dim>::movesRigidBodies() const
{
	return std::any_of(slot_.begin(), slot_.end(), [this](const Slot& slot) {
		return slot.kind == Kind::rigid ||
		       (slot.kind == Kind::grainOnRigid && rigidPairs_[slot.index].movesPartner());
	});
}

template <int dim> bool ContactSolver<dim>::bearsNothing() const
{
	if (lastActive_ > 0) return false;
	const ResidualSum sum = sumOver(residualsOfPairs());
	return sum.violation() == 0 && sum.scale() == 0; // nan is something
}

template <int dim> bool ContactSolver<dim>::isDriven() const
{
	return std::any_of(slot_.begin(), slot_.begin() + count_, [this](const Slot& slot) {
		if (slot.kind == Kind::rigid) return rigidContacts_[slot.index].isDriven();
		return slot.kind == Kind::grainOnRigid && rigidPairs_[slot.index].isDriven();
	});
}

template <int dim> void ContactSolver<dim>::adjustImpulses()
{
	Exchange sum;
	for (const Slot& slot : slot_) {
		if (slot.kind == Kind::rigid) sum += rigidContacts_[slot.index].exchange();
		if (slot.kind == Kind::grainOnRigid && rigidPairs_[slot.index].movesPartner())
			return;
	}
	if (!(sum.exchanged > leastExchange * sum.present)) return;
	exchangedAtFirst_ = sum.exchanged;
	const double share = std::clamp(sum.wanted / sum.exchanged, 0., mostStretch);
	if (share == 1) return;
	auto beginWith = [this](double part) {
		forEachPair(SweepOrder::forwards, [&](int k) {
			if (slot_[k].kind == Kind::rigid)
				rigidContacts_[slot_[k].index].beginWith(part);
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
	const int cap = settings_.maxSweeps, inARow = movesRigidBodies() ? 1 : sweepsEachWay;
	const bool withGrains = hasGrains();
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
	for (int k = 0; k < count_; ++k)
		report.contacts += withPair(k, [](const auto& pair) { return pair.contacts(); });
	solved_ = report.contacts == 0;
	if (solved_) return report;
	if (!bearsNothing()) sweepToTolerance(report);
	if (!std::isfinite(report.residual)) return report;
	const int ahead = staysInCache() ? 1 : pairsAhead; // from a near cache it comes soon
	forEachPair(SweepOrder::forwards, [&](int k) {
		fetch(k + ahead, &PairSolver<dim>::fetchResults);
		withPair(k, [](auto& pair) { pair.finish(); });
	});
	for (int k = 0; k < count_; ++k)
		report.active += withPair(k, [](const auto& pair) { return pair.active(); });
	lastActive_ = report.active;
	solved_ = true;
	return report;
}

template <int dim> void ContactSolver<dim>::separateRigidBodies(double dt)
{
	bool overlaps = false;
	for (int k = 0; k < count_; ++k)
		if (slot_[k].kind == Kind::rigid)
			overlaps |= rigidContacts_[slot_[k].index].findSeparation(dt, settings_);
	if (!overlaps) return;
	for (int sweep = 0; sweep < separatingSweeps; ++sweep)
		forEachPair(sweep < sweepsEachWay ? SweepOrder::backwards : SweepOrder::forwards,
			    [&](int k) {
				    if (slot_[k].kind == Kind::rigid)
					    rigidContacts_[slot_[k].index].separate();
			    });
}

template <int dim> std::vector<ResidualSum> ContactSolver<dim>::residualsOfPairs() const
{
	std::vector<ResidualSum> sums(count_);
	forEachPair(SweepOrder::forwards, [&](int k) {
		fetchAfter(k, SweepOrder::forwards);
		sums[k] = withPair(k, [](const auto& pair) { return pair.residual(); });
	});
	return sums;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	return sumOver(residualsOfPairs()).value();
}

template <int dim> ContactWork ContactSolver<dim>::work() const
{
	std::vector<ContactWork> works(count_);
#pragma omp parallel for schedule(static) num_threads(threads_) if (threads_ > 1)
	for (int k = 0; k < count_; ++k)
		withGrainPair(k, [&](const auto& pair) { works[k] = pair.work(); });
	ContactWork work;
	for (const ContactWork& ofPair : works)
		work += ofPair;
	return work;
}

template <int dim> ContactWork ContactSolver<dim>::rigidWork() const
{
	ContactWork work;
	for (int k = 0; k < count_; ++k)
		if (slot_[k].kind == Kind::rigid) work += rigidContacts_[slot_[k].index].work();
	return work;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
