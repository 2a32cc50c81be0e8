#include "contact/PairSolver.hpp"
#include "contact/CoulombCone.hpp"

#include <algorithm>

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

/// Adds W_k J to the velocity of each node that is moved. (J is a copy: the compiler cannot know
/// that no velocity is part of it.)
template <int dim, class Mobility>
void move(std::vector<Vec<dim>>& velocity, const Mobility& moved, const Vec<dim> J)
{
	Vec<dim>* v = velocity.data();
	for (int k = 0; k < moved.count; ++k)
		addScaled<dim>(v[moved.column[k]], moved.value[k], J);
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
	start_.resize(list.contacts.size());
	reservePartnerMobility();
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& contact = list.contacts[k];
		Constraint& c = constraints_[k];
		c.normal = contact.normal;
		c.impulse = onCone<dim>(contact.impulse, contact.normal, friction_);
		c.node = contact.key.node;
		c.onFirst = contact.key.side == 0;
		c.partners = contact.partners;
		c.partner = contact.partner;
		c.weight = contact.weight;
		const ContactBody<dim>& body = *own(c);
		c.bias = biasOf(contact.gap, body.pointSpacing, dt, settings);
		const SparseRows<double>& table = *body.delassus;
		const int begin = table.begin(c.node);
		c.moved = { table.column.data() + begin, table.value.data() + begin,
			    table.end(c.node) - begin };
		c.W = body.mobility(c.node, c.node);
		if (c.partners > 0) c.W += findPartnerMobility(contact, c);
		c.inverseW = 1 / c.W;
		start_[k] = c.impulse;
		if (!c.impulse.isZero(0)) applyImpulse(c, c.impulse);
	}
}

/// Room for all rows, since contacts point into them.
template <int dim> void PairSolver<dim>::reservePartnerMobility()
{
	std::size_t entries = 0;
	for (const Contact<dim>& contact : list_->contacts) {
		if (contact.partners == 0) continue;
		const ContactBody<dim>& partner = contact.key.side == 0 ? *second_ : *first_;
		if (partner.facetMobility)
			entries += partner.facetMobility->mostColumns();
		else
			for (int i = 0; i < contact.partners; ++i)
				entries += partner.delassus->end(contact.partner[i]) -
					   partner.delassus->begin(contact.partner[i]);
	}
	partnerValue_.clear();
	partnerColumn_.clear();
	partnerValue_.reserve(entries);
	partnerColumn_.reserve(entries);
}

/// Finds what the impulse moves of the partner; returns the partner's share of W. Neighbouring
/// partner nodes move almost the same nodes: over a facet their rows are added up once, not in
/// every sweep.
template <int dim>
double PairSolver<dim>::findPartnerMobility(const Contact<dim>& contact, Constraint& c)
{
	const ContactBody<dim>& partner = *other(c);
	const std::size_t begin = partnerValue_.size();
	if (partner.facetMobility) {
		const FacetMobility<dim>& facets = *partner.facetMobility;
		const int count = facets.columns(contact.facet);
		partnerValue_.resize(begin + count);
		c.movedPartner = { facets.column(contact.facet), partnerValue_.data() + begin,
				   count };
		return partner.delassusScale *
		       facets.combine(contact.facet, contact.weight, partnerValue_.data() + begin);
	}
	double W = 0;
	const SparseRows<double>& table = *partner.delassus;
	for (int i = 0; i < contact.partners; ++i) {
		const int node = contact.partner[i];
		for (int k = table.begin(node); k < table.end(node); ++k) {
			partnerColumn_.push_back(table.column[k]);
			partnerValue_.push_back(contact.weight[i] * table.value[k]);
		}
		for (int j = 0; j < contact.partners; ++j)
			W += contact.weight[i] * contact.weight[j] *
			     partner.mobility(node, contact.partner[j]);
	}
	const std::size_t columns = partnerValue_.size() - begin;
	c.movedPartner = { partnerColumn_.data() + partnerColumn_.size() - columns,
			   partnerValue_.data() + begin, static_cast<int>(columns) };
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
	move<dim>(own(c)->velocity, c.moved, own(c)->delassusScale * J);
	if (c.partners > 0)
		move<dim>(other(c)->velocity, c.movedPartner, -other(c)->delassusScale * J);
}

template <int dim> [[gnu::flatten]] SweepChange PairSolver<dim>::sweep(SweepOrder order)
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

template <int dim> [[gnu::flatten]] ResidualSum PairSolver<dim>::residual() const
{
	ResidualSum sum;
	for (const Constraint& c : constraints_)
		sum.add<dim>(c.impulse, solvedImpulse(c), c.W);
	return sum;
}

template <int dim> void PairSolver<dim>::finish()
{
	PairImpulse<dim>& sum = list_->impulse;
	sum = {};
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		const Constraint& c = constraints_[k];
		list_->contacts[k].impulse = c.impulse;
		sum.point += own(c)->contactPoint(c.node);
		if (c.impulse.isZero(0)) continue;
		++sum.active;
		const Vec<dim> normal = c.impulse.dot(c.normal) * c.normal;
		sum.normal += (c.onFirst ? 1 : -1) * normal;
		sum.shear += (c.onFirst ? 1 : -1) * (c.impulse - normal);
		own(c)->impulse[c.node] += c.impulse;
		for (int i = 0; i < c.partners; ++i)
			other(c)->impulse[c.partner[i]] -= c.weight[i] * c.impulse;
	}
	sum.point /= static_cast<double>(constraints_.size());
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
