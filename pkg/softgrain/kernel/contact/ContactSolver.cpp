#include "contact/ContactSolver.hpp"
#include "contact/PairColours.hpp"

#include <algorithm>
#include <cmath>
#include <map>
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

/// With fewer pairs a colour than this, threads would wait longer than they work.
constexpr int pairsPerThread = 8;

} // namespace

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies,
				 const std::vector<ContactList<dim>*>& lists, double dt,
				 const SolverSettings& settings, int threads)
{
	settings_ = settings;
	std::vector<ContactList<dim>*> inContact;
	for (ContactList<dim>* list : lists)
		if (!list->contacts.empty()) inContact.push_back(list);
	count_ = static_cast<int>(inContact.size());
	if (static_cast<int>(pairs_.size()) < count_) pairs_.resize(count_);
	change_.resize(count_);

	std::vector<ContactList<dim>*> ordered;
	colourEnd_.clear();
	for (const auto& colour : pairColours<dim>(inContact, static_cast<int>(bodies.size()))) {
		ordered.insert(ordered.end(), colour.begin(), colour.end());
		colourEnd_.push_back(static_cast<int>(ordered.size()));
	}
	const int colours = static_cast<int>(colourEnd_.size());
	threads_ = std::clamp(count_ / (pairsPerThread * std::max(colours, 1)), 1, threads);
	forEachPair(SweepOrder::forwards,
		    [&](int k) { pairs_[k].prepare(bodies, *ordered[k], dt, settings); });
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
		for (int k = begin; k < colourEnd_[colour]; ++k)
			visit(k);
	}
}

template <int dim> double ContactSolver<dim>::sweep(SweepOrder order)
{
	forEachPair(order, [&](int k) { change_[k] = pairs_[k].sweep(order); });
	SweepChange sum;
	for (const SweepChange& change : change_)
		sum += change;
	return sum.changed > 0 ? std::sqrt(sum.changed / sum.total) : 0;
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	for (int k = 0; k < count_; ++k)
		report.contacts += pairs_[k].contacts();
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
	forEachPair(SweepOrder::forwards, [&](int k) { pairs_[k].finish(); });
	for (int k = 0; k < count_; ++k)
		report.active += pairs_[k].active();
	return report;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	std::vector<ResidualSum> sums(count_);
#pragma omp parallel for schedule(static) num_threads(threads_) if (threads_ > 1)
	for (int k = 0; k < count_; ++k)
		sums[k] = pairs_[k].residual();
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
		works[k] = pairs_[k].work();
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
	for (int k = 0; k < count_; ++k)
		for (const auto& c : pairs_[k].constraints()) {
			pairs_[k].forEachShare(
				c, [&](const ContactBody<dim>* body, int node, double w) {
					at[{ body, node }].push_back({ contacts, w });
				});
			++contacts;
		}
	SparseRows<double> rows;
	for (int k = 0; k < count_; ++k)
		for (const auto& c : pairs_[k].constraints()) {
			std::map<int, double> row;
			auto addRow = [&](const ContactBody<dim>* body, int node, double w) {
				const SparseRows<double>& table = *body->delassus;
				for (int e = table.begin(node); e < table.end(node); ++e) {
					const auto found = at.find({ body, table.column[e] });
					if (found == at.end()) continue;
					for (const auto& [l, share] : found->second)
						row[l] += w * share * body->delassusScale *
							  table.value[e];
				}
			};
			pairs_[k].forEachShare(c, addRow);
			for (const auto& [l, W] : row)
				rows.append(l, W);
			rows.closeRow();
		}
	return rows;
}

template <int dim> ContactProblem<dim> ContactSolver<dim>::problem() const
{
	ContactProblem<dim> problem;
	problem.delassus = delassus();
	for (int k = 0; k < count_; ++k) {
		const std::vector<Vec<dim>>& start = pairs_[k].start();
		problem.start.insert(problem.start.end(), start.begin(), start.end());
		for (const auto& c : pairs_[k].constraints()) {
			problem.freeVelocity.push_back(pairs_[k].velocity(c));
			problem.normal.push_back(c.normal);
			problem.bias.push_back(c.bias);
			problem.friction.push_back(pairs_[k].friction());
			problem.impulse.push_back(c.impulse);
		}
	}
	for (int k = 0; k < problem.contacts(); ++k) // takes out what the impulses did
		for (int e = problem.delassus.begin(k); e < problem.delassus.end(k); ++e)
			problem.freeVelocity[k] -= problem.delassus.value[e] *
						   problem.impulse[problem.delassus.column[e]];
	return problem;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
