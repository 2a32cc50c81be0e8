#include "contact/ContactSolver.hpp"
#include "contact/CoulombCone.hpp"
#include "contact/Residual.hpp"

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

/// Overlaps up to this share of dr are left as they are: working off what the tolerance of the
/// solver leaves in every step would heat grains at rest (doc/decisions/0010-grains-at-rest.md).
constexpr double restingOverlap = 1e-3;

/// b: the speed at which a gap may close, or minus that at which an overlap is worked off.
double biasOf(double gap, double pointSpacing, double dt, const SolverSettings& settings)
{
	if (gap >= 0) return gap / dt;
	const double excess = std::min(gap + restingOverlap * pointSpacing, 0.);
	return std::max(settings.overlapRelaxation * excess / dt, -settings.overlapSpeed);
}

/// Worth measuring the residual: it was 0.55 to 1.1 times the change of the sweep before it in
/// problems of a compaction.
constexpr double changePerResidual = 2;

} // namespace

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies,
				 std::vector<ContactList<dim>*>& lists, double dt,
				 const SolverSettings& settings)
{
	settings_ = settings;
	constraints_.clear();
	partnerMobility_.clear();
	for (ContactList<dim>* list : lists)
		for (Contact<dim>& contact : list->contacts) {
			ContactBody<dim>* first = &bodies[list->first];
			ContactBody<dim>* second =
				list->second < 0 ? nullptr : &bodies[list->second];
			Constraint c;
			c.contact = contact;
			c.listed = &contact;
			c.body = contact.key.side == 0 ? first : second;
			c.partner = contact.key.side == 0 ? second : first;
			c.planeVelocity =
				second ? Vec<dim>(Vec<dim>::Zero()) : list->plane.velocity;
			c.freeVelocity = relativeVelocity(c, &ContactBody<dim>::velocity);
			c.inverseW = 1 / (c.body->mobility(contact.key.node, contact.key.node) +
					  appendPartnerMobility(contact, c.partner));
			c.bias = biasOf(contact.gap, c.body->pointSpacing, dt, settings);
			c.friction = list->friction;
			constraints_.push_back(c);
		}
}

/// Neighbouring partner nodes move almost the same nodes: their rows are added up once, not in
/// every sweep.
template <int dim>
double ContactSolver<dim>::appendPartnerMobility(const Contact<dim>& contact,
						 const ContactBody<dim>* partner)
{
	std::vector<double>& sum = partnerSum_; // all 0 between calls
	const int begin = static_cast<int>(partnerMobility_.column.size());
	for (int i = 0; i < contact.partners; ++i) {
		if (contact.weight[i] == 0) continue; // at the end of a segment
		const SparseRows<double>& table = *partner->delassus;
		if (static_cast<int>(sum.size()) < table.rows()) sum.resize(table.rows(), 0.);
		const double share = contact.weight[i] * partner->delassusScale;
		const int node = contact.partner[i];
		for (int k = table.begin(node); k < table.end(node); ++k) {
			double& moved = sum[table.column[k]];
			// A sum that is 0 again is listed twice, the second time with 0.
			if (moved == 0) partnerMobility_.append(table.column[k], 0);
			moved += share * table.value[k];
		}
	}
	double W = 0;
	for (int i = 0; i < contact.partners; ++i)
		W += contact.weight[i] * sum[contact.partner[i]];
	for (int k = begin; k < static_cast<int>(partnerMobility_.column.size()); ++k)
		partnerMobility_.value[k] = std::exchange(sum[partnerMobility_.column[k]], 0.);
	partnerMobility_.closeRow();
	return W;
}

template <int dim>
Vec<dim> ContactSolver<dim>::relativeVelocity(const Constraint& c,
					      std::vector<Vec<dim>> ContactBody<dim>::* field) const
{
	const Contact<dim>& contact = c.contact;
	Vec<dim> u = (c.body->*field)[contact.key.node] - c.planeVelocity;
	for (int i = 0; i < contact.partners; ++i)
		u -= contact.weight[i] * (c.partner->*field)[contact.partner[i]];
	return u;
}

template <int dim> void ContactSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	c.body->push(c.contact.key.node, J);
	const int row = static_cast<int>(&c - constraints_.data());
	for (int k = partnerMobility_.begin(row); k < partnerMobility_.end(row); ++k)
		c.partner->velocity[partnerMobility_.column[k]] -= partnerMobility_.value[k] * J;
}

template <int dim> Vec<dim> ContactSolver<dim>::solvedImpulse(const Constraint& c) const
{
	return solvedContact<dim>(c.contact.impulse,
				  relativeVelocity(c, &ContactBody<dim>::velocity),
				  c.contact.normal, c.bias, c.inverseW, c.friction);
}

template <int dim> void ContactSolver<dim>::warmStart()
{
	for (Constraint& c : constraints_) {
		c.contact.impulse = onCone<dim>(c.contact.impulse, c.contact.normal, c.friction);
		c.start = c.contact.impulse;
		if (!c.start.isZero(0)) applyImpulse(c, c.start);
	}
}

template <int dim> double ContactSolver<dim>::sweep(Order order)
{
	double changed = 0, total = 0;
	auto visit = [&](Constraint& c) {
		const Vec<dim> r = solvedImpulse(c);
		const Vec<dim> J = r - c.contact.impulse;
		total += r.squaredNorm() / c.inverseW;
		if (J.isZero(0)) return;
		changed += J.squaredNorm() / c.inverseW;
		c.contact.impulse = r;
		applyImpulse(c, J);
	};
	if (order == Order::forwards)
		std::for_each(constraints_.begin(), constraints_.end(), visit);
	else
		std::for_each(constraints_.rbegin(), constraints_.rend(), visit);
	return changed > 0 ? std::sqrt(changed / total) : 0;
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	report.contacts = static_cast<int>(constraints_.size());
	if (constraints_.empty()) return report;
	report.converged = false;
	while (!report.converged && report.sweeps < settings_.maxSweeps) {
		const double change =
			sweep(report.sweeps < sweepsEachWay ? Order::backwards : Order::forwards);
		++report.sweeps;
		const bool promising = report.sweeps >= 2 * sweepsEachWay &&
				       change <= changePerResidual * settings_.tolerance;
		if (!promising && report.sweeps < settings_.maxSweeps) continue;
		report.residual = residual();
		report.converged = report.residual <= settings_.tolerance;
	}
	for (const Constraint& c : constraints_) {
		report.active += !c.contact.impulse.isZero(0);
		c.listed->impulse = c.contact.impulse;
	}
	return report;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	ResidualSum sum;
	for (const Constraint& c : constraints_)
		sum.add<dim>(c.contact.impulse, solvedImpulse(c), c.inverseW);
	return sum.value();
}

template <int dim> void ContactSolver<dim>::collectImpulses()
{
	for (const Constraint& c : constraints_) {
		const Contact<dim>& contact = c.contact;
		c.body->impulse[contact.key.node] += contact.impulse;
		for (int i = 0; i < contact.partners; ++i)
			c.partner->impulse[contact.partner[i]] -=
				contact.weight[i] * contact.impulse;
	}
}

template <int dim> ContactWork ContactSolver<dim>::work() const
{
	ContactWork work;
	for (const Constraint& c : constraints_) {
		const Vec<dim>& r = c.contact.impulse;
		const Vec<dim> normal = r.dot(c.contact.normal) * c.contact.normal;
		const Vec<dim> before = relativeVelocity(c, &ContactBody<dim>::velocityBefore);
		const Vec<dim> after = relativeVelocity(c, &ContactBody<dim>::velocity);
		work.impact.before -= 0.5 * normal.dot(before);
		work.impact.after -= 0.5 * normal.dot(after);
		work.friction.before -= 0.5 * (r - normal).dot(before);
		work.friction.after -= 0.5 * (r - normal).dot(after);
		work.planes.before += 0.5 * r.dot(c.planeVelocity);
		work.planes.after += 0.5 * r.dot(c.planeVelocity);
	}
	return work;
}

template <int dim> SparseRows<double> ContactSolver<dim>::delassus() const
{
	using Share = std::pair<int, double>; // of a contact in a node
	std::map<std::pair<const ContactBody<dim>*, int>, std::vector<Share>> at;
	for (std::size_t k = 0; k < constraints_.size(); ++k)
		forEachShare(constraints_[k],
			     [&](const ContactBody<dim>* body, int node, double w) {
				     at[{ body, node }].push_back({ static_cast<int>(k), w });
			     });
	SparseRows<double> rows;
	for (const Constraint& c : constraints_) {
		std::map<int, double> row;
		forEachShare(c, [&](const ContactBody<dim>* body, int node, double w) {
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
	}
	return rows;
}

template <int dim> ContactProblem<dim> ContactSolver<dim>::problem() const
{
	ContactProblem<dim> problem;
	problem.delassus = delassus();
	for (const Constraint& c : constraints_) {
		problem.normal.push_back(c.contact.normal);
		problem.freeVelocity.push_back(c.freeVelocity);
		problem.bias.push_back(c.bias);
		problem.friction.push_back(c.friction);
		problem.start.push_back(c.start);
		problem.impulse.push_back(c.contact.impulse);
	}
	return problem;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
