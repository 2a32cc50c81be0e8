#include "contact/PairSolver.hpp"
#include "contact/CoulombCone.hpp"

#include <algorithm>
#include <utility>

namespace softgrain {

namespace {

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

/// Adds `value[k] J` to the velocity of node `column[k]`. (J is a copy: the compiler cannot know
/// that no velocity is part of it.)
template <int dim>
void addToVelocities(std::vector<Vec<dim>>& velocity, const SparseRows<double>& table, int row,
		     const Vec<dim> J)
{
	double* v = velocity.data()->data();
	for (int k = table.begin(row); k < table.end(row); ++k) {
		double* at = v + dim * table.column[k];
		const double W = table.value[k];
		for (int a = 0; a < dim; ++a)
			at[a] += W * J[a];
	}
}

} // namespace

template <int dim>
void PairSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list,
			      double dt, const SolverSettings& settings)
{
	list_ = &list;
	first_ = &bodies[list.first];
	second_ = list.second < 0 ? nullptr : &bodies[list.second];
	planeVelocity_ = second_ ? Vec<dim>(Vec<dim>::Zero()) : list.plane.velocity;
	friction_ = list.friction;
	constraints_.resize(list.contacts.size());
	freeVelocity_.resize(list.contacts.size());
	start_.resize(list.contacts.size());
	partnerMobility_.clear();
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& contact = list.contacts[k];
		Constraint& c = constraints_[k];
		c.normal = contact.normal;
		c.impulse = contact.impulse;
		c.node = contact.key.node;
		c.onFirst = contact.key.side == 0;
		c.partners = contact.partners;
		c.partner = contact.partner;
		c.weight = contact.weight;
		c.bias = biasOf(contact.gap, own(c)->pointSpacing, dt, settings);
		c.W = own(c)->mobility(c.node, c.node);
		c.partnerRow = partnerMobility_.rows();
		if (c.partners > 0) c.W += appendPartnerMobility(contact, *other(c));
		c.inverseW = 1 / c.W;
		freeVelocity_[k] = relativeVelocity(c, &ContactBody<dim>::velocity);
	}
}

/// Adds a row to `partnerMobility_`; returns what of it the contact itself feels, the partner's
/// share of W. Neighbouring partner nodes move almost the same nodes: their rows are added up once,
/// not in every sweep.
template <int dim>
double PairSolver<dim>::appendPartnerMobility(const Contact<dim>& contact,
					      const ContactBody<dim>& partner)
{
	static thread_local std::vector<double> sum; // by node; all 0 between calls
	const SparseRows<double>& table = *partner.delassus;
	if (static_cast<int>(sum.size()) < table.rows()) sum.resize(table.rows(), 0.);
	const int begin = static_cast<int>(partnerMobility_.column.size());
	for (int i = 0; i < contact.partners; ++i) {
		if (contact.weight[i] == 0) continue; // at the end of a segment
		const double share = contact.weight[i] * partner.delassusScale;
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
		partnerMobility_.value[k] = -std::exchange(sum[partnerMobility_.column[k]], 0.);
	partnerMobility_.closeRow();
	return W;
}

template <int dim>
Vec<dim> PairSolver<dim>::relativeVelocity(const Constraint& c,
					   std::vector<Vec<dim>> ContactBody<dim>::* field) const
{
	Vec<dim> u = (own(c)->*field)[c.node] - planeVelocity_;
	for (int i = 0; i < c.partners; ++i)
		u -= c.weight[i] * (other(c)->*field)[c.partner[i]];
	return u;
}

template <int dim> Vec<dim> PairSolver<dim>::solvedImpulse(const Constraint& c) const
{
	return solvedContact<dim>(c.impulse, relativeVelocity(c, &ContactBody<dim>::velocity),
				  c.normal, c.bias, c.inverseW, friction_);
}

template <int dim> void PairSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	ContactBody<dim>& body = *own(c);
	addToVelocities<dim>(body.velocity, *body.delassus, c.node, body.delassusScale * J);
	if (c.partners > 0)
		addToVelocities<dim>(other(c)->velocity, partnerMobility_, c.partnerRow, J);
}

template <int dim> void PairSolver<dim>::warmStart()
{
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		Constraint& c = constraints_[k];
		start_[k] = c.impulse = onCone<dim>(c.impulse, c.normal, friction_);
		if (!c.impulse.isZero(0)) applyImpulse(c, c.impulse);
	}
}

template <int dim> SweepChange PairSolver<dim>::sweep(SweepOrder order)
{
	SweepChange sum;
	auto visit = [&](Constraint& c) {
		const Vec<dim> r = solvedImpulse(c);
		const Vec<dim> J = r - c.impulse;
		sum.total += c.W * r.squaredNorm();
		if (J.isZero(0)) return;
		sum.changed += c.W * J.squaredNorm();
		c.impulse = r;
		applyImpulse(c, J);
	};
	if (order == SweepOrder::forwards)
		std::for_each(constraints_.begin(), constraints_.end(), visit);
	else
		std::for_each(constraints_.rbegin(), constraints_.rend(), visit);
	return sum;
}

template <int dim> ResidualSum PairSolver<dim>::residual() const
{
	ResidualSum sum;
	for (const Constraint& c : constraints_)
		sum.add<dim>(c.impulse, solvedImpulse(c), c.W);
	return sum;
}

template <int dim> int PairSolver<dim>::finish()
{
	int active = 0;
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		list_->contacts[k].impulse = constraints_[k].impulse;
		active += !constraints_[k].impulse.isZero(0);
	}
	return active;
}

template <int dim> void PairSolver<dim>::collectImpulses()
{
	for (const Constraint& c : constraints_) {
		if (c.impulse.isZero(0)) continue;
		own(c)->impulse[c.node] += c.impulse;
		for (int i = 0; i < c.partners; ++i)
			other(c)->impulse[c.partner[i]] -= c.weight[i] * c.impulse;
	}
}

template <int dim> ContactWork PairSolver<dim>::work() const
{
	ContactWork work;
	for (const Constraint& c : constraints_) {
		const Vec<dim>& r = c.impulse;
		if (r.isZero(0)) continue;
		const Vec<dim> normal = r.dot(c.normal) * c.normal;
		const Vec<dim> before = relativeVelocity(c, &ContactBody<dim>::velocityBefore);
		const Vec<dim> after = relativeVelocity(c, &ContactBody<dim>::velocity);
		work.impact.before -= 0.5 * normal.dot(before);
		work.impact.after -= 0.5 * normal.dot(after);
		work.friction.before -= 0.5 * (r - normal).dot(before);
		work.friction.after -= 0.5 * (r - normal).dot(after);
		work.planes.before += 0.5 * r.dot(planeVelocity_);
		work.planes.after += 0.5 * r.dot(planeVelocity_);
	}
	return work;
}

template class PairSolver<2>;
template class PairSolver<3>;

} // namespace softgrain
