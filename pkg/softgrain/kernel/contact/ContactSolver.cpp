#include "contact/ContactSolver.hpp"
#include "contact/SweepPlan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace softgrain {

namespace {

/// Sweeps that every step makes, so many backwards and then so many forwards: what the impulses
/// still lack then answers to the velocities as springs would, and feeds no vibration
/// (doc/decisions/0010-grains-at-rest.md).
constexpr int sweepsEachWay = 2;

/// Worth measuring the residual: it was 0.55 to 1.1 times the change of the sweep before it in
/// problems of a compaction.
constexpr double changePerResidual = 2;

/// More pairs are not kept in the caches from sweep to sweep: the next ones are asked for while one
/// is solved (10 000 disks: half the time; fewer pairs: in vain).
constexpr int pairsInCache = 4000;

/// With fewer pairs a colour than this, threads would wait longer than they work.
constexpr int pairsPerThread = 8;

} // namespace

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies,
				 const std::vector<ContactList<dim>*>& lists, double dt,
				 const SolverSettings& settings, int threads,
				 std::vector<RigidPartner<dim>>* partners)
{
	settings_ = settings;
	std::vector<ContactList<dim>*> inContact;
	for (ContactList<dim>* list : lists)
		if (!list->contacts.empty()) inContact.push_back(list);
	count_ = static_cast<int>(inContact.size());
	change_.resize(count_);

	const SweepPlan<dim> plan =
		planSweeps<dim>(inContact, static_cast<int>(bodies.size()),
				partners ? static_cast<int>(partners->size()) : 0);
	const auto& ordered = plan.pairs;
	taskEnd_ = plan.taskEnd;
	colourEnd_ = plan.colourEnd;
	slot_.clear();
	std::size_t soft = 0, rigid = 0;
	for (const ContactList<dim>* list : ordered)
		slot_.push_back({ list->rigid.has_value(),
				  static_cast<int>(list->rigid ? rigid++ : soft++) });
	if (pairs_.size() < soft) pairs_.resize(soft);
	if (rigidPairs_.size() < rigid) rigidPairs_.resize(rigid);

	const int colours = static_cast<int>(colourEnd_.size());
	threads_ = std::clamp(count_ / (pairsPerThread * std::max(colours, 1)), 1, threads);
	forEachPair(SweepOrder::forwards, [&](int k) {
		if (const auto [isRigid, index] = slot_[k]; isRigid)
			rigidPairs_[index].prepare(bodies, *ordered[k], *partners, dt, settings);
		else
			pairs_[index].prepare(bodies, *ordered[k], dt, settings);
	});
}

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachPair(SweepOrder order, Visit&& visit)
{
	const int colours = static_cast<int>(colourEnd_.size());
#pragma omp parallel num_threads(threads_) if (threads_ > 1)
	for (int i = 0; i < colours; ++i) {
		const int colour = order == SweepOrder::forwards ? i : colours - 1 - i;
		const int begin = colour > 0 ? colourEnd_[colour - 1] : 0;
#pragma omp for schedule(static)
		for (int task = begin; task < colourEnd_[colour]; ++task)
			forEachPairOf(task, order, visit);
	}
}

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachPairOf(int task, SweepOrder order, Visit&& visit)
{
	const int begin = task > 0 ? taskEnd_[task - 1] : 0, end = taskEnd_[task];
	if (order == SweepOrder::forwards)
		for (int k = begin; k < end; ++k)
			visit(k);
	else
		for (int k = end - 1; k >= begin; --k)
			visit(k);
}

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachConstraint(Visit&& visit) const
{
	for (int k = 0; k < count_; ++k)
		withPair(k, [&](const auto& pair) {
			for (const auto& c : pair.constraints())
				visit(pair, c);
		});
}

template <int dim>
void ContactSolver<dim>::fetch(int k, void (PairSolver<dim>::*what)() const) const
{
	if (k < 0 || k >= count_ || slot_[k].rigid) return;
	(pairs_[slot_[k].index].*what)();
}

template <int dim> double ContactSolver<dim>::sweep(SweepOrder order)
{
	const int ahead = order == SweepOrder::forwards ? 1 : -1;
	const bool fetching = count_ > pairsInCache;
	forEachPair(order, [&](int k) {
		if (fetching) {
			fetch(k + 2 * ahead, &PairSolver<dim>::fetchConstraints);
			fetch(k + ahead, &PairSolver<dim>::fetchVelocities);
		}
		change_[k] = withPair(k, [&](auto& pair) { return pair.sweep(order); });
	});
	SweepChange sum;
	for (const SweepChange& change : change_)
		sum += change;
	return sum.changed > 0 ? std::sqrt(sum.changed / sum.total) : 0;
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	for (int k = 0; k < count_; ++k)
		report.contacts += withPair(k, [](const auto& pair) { return pair.contacts(); });
	if (report.contacts == 0) return report;
	report.converged = false;
	while (!report.converged && report.sweeps < settings_.maxSweeps) {
		const double change = sweep(report.sweeps < sweepsEachWay ? SweepOrder::backwards
									  : SweepOrder::forwards);
		++report.sweeps;
		const bool promising = report.sweeps >= 2 * sweepsEachWay &&
				       change <= changePerResidual * settings_.tolerance;
		if (!promising && report.sweeps < settings_.maxSweeps) continue;
		report.residual = residual();
		report.converged = report.residual <= settings_.tolerance;
	}
	forEachPair(SweepOrder::forwards,
		    [&](int k) { withPair(k, [](auto& pair) { pair.finish(); }); });
	for (int k = 0; k < count_; ++k)
		report.active += withPair(k, [](const auto& pair) { return pair.active(); });
	return report;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	std::vector<ResidualSum> sums(count_);
#pragma omp parallel for schedule(static) num_threads(threads_) if (threads_ > 1)
	for (int k = 0; k < count_; ++k)
		sums[k] = withPair(k, [](const auto& pair) { return pair.residual(); });
	ResidualSum sum;
	for (const ResidualSum& ofPair : sums)
		sum += ofPair;
	return sum.value();
}

template <int dim> ContactWork ContactSolver<dim>::work() const
{
	std::vector<ContactWork> works(count_);
#pragma omp parallel for schedule(static) num_threads(threads_) if (threads_ > 1)
	for (int k = 0; k < count_; ++k)
		works[k] = withPair(k, [](const auto& pair) { return pair.work(); });
	ContactWork work;
	for (const ContactWork& ofPair : works)
		work += ofPair;
	return work;
}

template <int dim> SparseRows<double> ContactSolver<dim>::delassus() const
{
	using Share = std::pair<int, double>; // of a contact in a node
	std::map<std::pair<const ContactBody<dim>*, int>, std::vector<Share>> at;
	int contacts = 0;
	forEachConstraint([&](const auto& pair, const auto& c) {
		pair.forEachShare(c, [&](const ContactBody<dim>* body, int node, double w) {
			at[{ body, node }].push_back({ contacts, w });
		});
		++contacts;
	});
	SparseRows<double> rows;
	forEachConstraint([&](const auto& pair, const auto& c) {
		std::map<int, double> row;
		pair.forEachShare(c, [&](const ContactBody<dim>* body, int node, double w) {
			const SparseRows<double>& table = *body->delassus;
			for (int e = table.begin(node); e < table.end(node); ++e) {
				const auto found = at.find({ body, table.column[e] });
				if (found == at.end()) continue;
				for (const auto& [l, share] : found->second)
					row[l] += w * share * body->delassusScale * table.value[e];
			}
		});
		for (const auto& [l, W] : row)
			rows.append(l, W);
		rows.closeRow();
	});
	return rows;
}

template <int dim> ContactProblem<dim> ContactSolver<dim>::problem() const
{
	ContactProblem<dim> problem;
	for (const Slot& slot : slot_)
		if (slot.rigid && rigidPairs_[slot.index].movesPartner())
			throw std::logic_error(
				"the contact problem cannot be given as data: a rigid body that "
				"contact moves takes part, whose blocks of W are no multiples of "
				"the identity");
	problem.delassus = delassus();
	for (int k = 0; k < count_; ++k)
		withPair(k, [&](const auto& pair) {
			problem.start.insert(problem.start.end(), pair.start().begin(),
					     pair.start().end());
		});
	forEachConstraint([&](const auto& pair, const auto& c) {
		problem.freeVelocity.push_back(pair.velocity(c));
		problem.normal.push_back(c.normal);
		problem.bias.push_back(c.bias);
		problem.friction.push_back(pair.friction());
		problem.impulse.push_back(c.impulse);
	});
	for (int k = 0; k < problem.contacts(); ++k) // takes out what the impulses did
		for (int e = problem.delassus.begin(k); e < problem.delassus.end(k); ++e)
			problem.freeVelocity[k] -= problem.delassus.value[e] *
						   problem.impulse[problem.delassus.column[e]];
	return problem;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
