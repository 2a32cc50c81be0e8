#include "contact/RigidPairSolver.hpp"
#include "contact/Bias.hpp"
#include "contact/Pressure.hpp"

namespace softgrain {

template <int dim>
void RigidPairSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list,
				   std::vector<RigidPartner<dim>>& partners, double dt,
				   const SolverSettings& settings)
{
	list_ = &list;
	grain_ = &bodies[list.first];
	partner_ = &partners[list.rigid->partner];
	friction_ = list.friction;
	interface_ = list.interface ? &*list.interface : nullptr;
	constraints_.resize(list.contacts.size());
	start_.resize(list.contacts.size());
	moved_.clear();
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& contact = list.contacts[k];
		Constraint& c = constraints_[k];
		const bool ofNode = contact.key.side == 0;
		c.normal = ofNode ? contact.normal : Vec<dim>(-contact.normal);
		c.impulse = onCone<dim>(ofNode ? contact.impulse : Vec<dim>(-contact.impulse),
					c.normal, friction_);
		c.bias = biasOf(contact.gap, grain_->pointSpacing, dt, settings);
		c.nodes = ofNode ? 1 : contact.partners;
		c.node = contact.partner;
		c.weight = contact.weight;
		if (ofNode) {
			c.node[0] = contact.key.node;
			c.weight[0] = 1;
		}
		c.arm = -imageCentre();
		for (int i = 0; i < c.nodes; ++i)
			c.arm += c.weight[i] * grain_->contactPoint(c.node[i]);
		findMobility(c);
		start_[k] = c.impulse;
		if (!c.impulse.isZero(0)) applyImpulse(c, c.impulse);
	}
	if (interface_) // ends of the rigid body stand for no area: the nodes about them do
		interface_->engage(
			constraints_, list.contacts,
			contactAreas<dim>(*grain_, nullptr, list.contacts), true,
			[this](const Constraint& c, const Vec<dim>& p) { applyImpulse(c, p); },
			[this](const Constraint& c) {
				return Vec<dim>(
					grainVelocity(c, &ContactBody<dim>::velocityBefore) -
					partner_->velocityBeforeAt(c.arm) - list_->image.velocity);
			});
}

template <int dim> void RigidPairSolver<dim>::findMobility(Constraint& c)
{
	const SparseRows<double>& table = *grain_->delassus;
	double w = 0;
	c.firstMoved = static_cast<int>(moved_.size());
	for (int i = 0; i < c.nodes; ++i) {
		for (int e = table.begin(c.node[i]); e < table.end(c.node[i]); ++e)
			moved_.push_back({ table.column[e], c.weight[i] * table.value[e] });
		for (int j = 0; j < c.nodes; ++j)
			w += c.weight[i] * c.weight[j] * grain_->mobility(c.node[i], c.node[j]);
	}
	c.endMoved = static_cast<int>(moved_.size());
	c.setMobility(w * Mat<dim>::Identity() + partner_->mobilityAt(c.arm));
}

template <int dim>
Vec<dim>
RigidPairSolver<dim>::grainVelocity(const Constraint& c,
				    const std::vector<Vec<dim>> ContactBody<dim>::* field) const
{
	Vec<dim> v = Vec<dim>::Zero();
	for (int i = 0; i < c.nodes; ++i)
		v += c.weight[i] * (grain_->*field)[c.node[i]];
	return v;
}

template <int dim> Vec<dim> RigidPairSolver<dim>::velocity(const Constraint& c) const
{
	return grainVelocity(c, &ContactBody<dim>::velocity) - partner_->velocityAt(c.arm) -
	       list_->image.velocity;
}

template <int dim> void RigidPairSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	const Vec<dim> scaled = grain_->delassusScale * J;
	for (int k = c.firstMoved; k < c.endMoved; ++k)
		addScaled<dim>(grain_->velocity[moved_[k].node], moved_[k].W, scaled);
	if (list_->rigid->moves) partner_->push(c.arm, -J);
}

template <int dim> SweepChange RigidPairSolver<dim>::sweep(SweepOrder order)
{
	return sweepOver(
		constraints_, order,
		[this](const Constraint& c) { return c.solvedAt(velocity(c), friction(c)); },
		[](const Constraint& c, const Vec<dim>& r) { return c.energy(r); },
		[this](const Constraint& c, const Vec<dim>& J) { applyImpulse(c, J); });
}

template <int dim> ResidualSum RigidPairSolver<dim>::residual() const
{
	ResidualSum sum;
	for (const Constraint& c : constraints_)
		c.addResidual(sum, velocity(c), friction(c));
	return sum;
}

template <int dim> Vec<dim> RigidPairSolver<dim>::finishInterface(std::size_t k)
{
	const Constraint& c = constraints_[k];
	interface_->remember(k, c.normal, c.impulse, velocity(c), friction_, list_->contacts[k].gap,
			     touchingGap * grain_->pointSpacing);
	return c.impulse + interface_->history[k].pull;
}

template <int dim> void RigidPairSolver<dim>::finish()
{
	PairImpulse<dim>& sum = list_->impulse;
	sum = {};
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		const Constraint& c = constraints_[k];
		const Vec<dim> place = imageCentre() + c.arm;
		list_->contacts[k].impulse =
			list_->contacts[k].key.side == 0 ? c.impulse : Vec<dim>(-c.impulse);
		sum.point += place;
		const Vec<dim> r = interface_ ? finishInterface(k) : c.impulse;
		if (r.isZero(0)) continue;
		++sum.active;
		const Vec<dim> normal = r.dot(c.normal) * c.normal;
		sum.normal += normal;
		sum.shear += r - normal;
		sum.moment -= moment<dim>(place - list_->rigid->pivot, r);
		for (int i = 0; i < c.nodes; ++i)
			grain_->impulse[c.node[i]] += c.weight[i] * r;
	}
	sum.point /= static_cast<double>(constraints_.size());
}

template <int dim> ContactWork RigidPairSolver<dim>::work() const
{
	ContactWork work;
	auto pull = [this](const Constraint& c) {
		return interface_ ? interface_->history[numberOf(c)].pull
				  : Vec<dim>(Vec<dim>::Zero());
	};
	auto book = [&](const Constraint& c, const Vec<dim>& grain, const Vec<dim>& rigid,
			double ContactWork::Halves::* half) {
		const Vec<dim> normal = c.impulse.dot(c.normal) * c.normal;
		const Vec<dim> drift = list_->image.velocity;
		const Vec<dim> relative = grain - rigid - drift;
		work.impact.*half -= 0.5 * normal.dot(relative);
		work.friction.*half -= 0.5 * (c.impulse - normal).dot(relative);
		const Vec<dim> p = pull(c);
		work.cohesion.*half -= 0.5 * p.dot(relative);
		work.planes.*half += 0.5 * (c.impulse + p).dot(rigid);
		work.cell.*half += 0.5 * (c.impulse + p).dot(drift);
	};
	for (const Constraint& c : constraints_) {
		if (c.impulse.isZero(0) && pull(c).isZero(0)) continue;
		book(c, grainVelocity(c, &ContactBody<dim>::velocityBefore),
		     partner_->velocityBeforeAt(c.arm), &ContactWork::Halves::before);
		book(c, grainVelocity(c, &ContactBody<dim>::velocity), partner_->velocityAt(c.arm),
		     &ContactWork::Halves::after);
	}
	return work;
}

template class RigidPairSolver<2>;
template class RigidPairSolver<3>;

} // namespace softgrain
