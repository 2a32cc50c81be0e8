#include "contact/solve/RigidPairSolver.hpp"
#include "contact/Pressure.hpp"
#include "contact/solve/PairSum.hpp"
#include "lanes/Lanes.hpp"

#include <algorithm>

namespace softgrain {

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
RigidPairSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list,
			      std::vector<RigidPartner<dim>>& partners, double dt,
			      const SolverSettings& settings)
{
	list_ = &list;
	dt_ = dt;
	grain_ = &bodies[list.first];
	side_ = BodySide<dim>(*grain_);
	partner_ = &partners[list.rigid->partner];
	moves_ = partner_->moves();
	drift_ = list.image.velocity;
	friction_ = list.friction;
	interface_ = list.interface ? &*list.interface : nullptr;
	frictions_ = interface_ ? interface_->frictions(friction_) : std::vector<double>();
	const double credit = creditOf(
		list.contacts, dt, [this](const Contact<dim>&) { return grain_->pointSpacing; });
	const Bias bias { dt, settings, list.account.isGood(credit) };
	constraints_.resize(list.contacts.size());
	start_.resize(list.contacts.size());
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		Constraint& c = constraints_[k];
		describe(list.contacts[k], bias, c);
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
					rigidVelocityBefore(c) - drift_);
			});
}

template <int dim>
void RigidPairSolver<dim>::describe(const Contact<dim>& contact, const Bias& bias,
				    Constraint& c) const
{
	c.ofNode = contact.key.side == 0;
	c.normal = c.ofNode ? contact.normal : Vec<dim>(-contact.normal);
	c.begin(onCone<dim>(c.ofNode ? contact.impulse : Vec<dim>(-contact.impulse), c.normal,
			    friction_));
	c.bias = bias.of(contact.gap, grain_->pointSpacing, restingOverlapOf(c));
	c.facet = contact.facet;
	c.partners = c.ofNode ? 1 : contact.partners;
	c.partner = contact.partner;
	c.weight = contact.weight;
	if (c.ofNode) {
		c.partner[0] = contact.key.node;
		c.weight[0] = 1;
	}
	c.arm = -imageCentre();
	for (int i = 0; i < c.partners; ++i)
		c.arm += c.weight[i] * grain_->contactPoint(c.partner[i]);
	c.halfTurn = halfTurnOf(c);
	c.grainMobility = c.ofNode ? side_.mobilityOf(c.partner[0]) : side_.mobilityOf(c);
	c.setMobility(c.grainMobility * Mat<dim>::Identity() + partner_->mobilityAt(c.arm));
}

template <int dim> double RigidPairSolver<dim>::restingOverlapOf(const Constraint& c) const
{
	const bool isBall = std::holds_alternative<BallSurface<dim>>(list_->rigid->surface);
	return isBall && !c.ofNode ? restingOverlapOfBall : restingOverlap;
}

/// What turns carries what sticks to it along circles: half a step later the velocity of a place
/// leads to where it will be, not outwards along the tangent. That is the place on a side, but the
/// centre of a ball, which turns under its contacts; and along the surface, since across it gaps
/// tell. (Of the spin without impulses: known in the sweeps, so impulses act at one place on both.)
template <int dim> Vec<dim> RigidPairSolver<dim>::halfTurnOf(const Constraint& c) const
{
	const Spin<dim>& spin = partner_->freeSpin;
	if (spin.isZero(0)) return Vec<dim>::Zero();
	const auto* ball = std::get_if<BallSurface<dim>>(&list_->rigid->surface);
	const Vec<dim> arm = ball ? Vec<dim>(ball->centre - imageCentre()) : c.arm;
	const Vec<dim> gained = spinCross<dim>(spin, 0.5 * dt_ * spinCross<dim>(spin, arm));
	return gained - gained.dot(c.normal) * c.normal;
}

template <int dim>
Vec<dim>
RigidPairSolver<dim>::grainVelocity(const Constraint& c,
				    const std::vector<Vec<dim>> ContactBody<dim>::* field) const
{
	Vec<dim> v = Vec<dim>::Zero();
	for (int i = 0; i < c.partners; ++i)
		v += c.weight[i] * (grain_->*field)[c.partner[i]];
	return v;
}

template <int dim> Vec<dim> RigidPairSolver<dim>::velocity(const Constraint& c) const
{
	return grainVelocity(c, &ContactBody<dim>::velocity) - rigidVelocity(c) - drift_;
}

template <int dim> void RigidPairSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	if (c.ofNode)
		side_.push(side_.velocity, c.partner[0], J);
	else
		side_.push(side_.velocity, c, J, 1);
	if (moves_) partner_->push(c.arm, -J);
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS SweepChange RigidPairSolver<dim>::sweep(SweepOrder order)
{
	SweepChange change;
	auto visit = [&](Constraint& c) {
		change += c.visit(velocity(c), friction(c),
				  [&](const Vec<dim>& J) { applyImpulse(c, J); });
	};
	if (order == SweepOrder::forwards)
		std::for_each(constraints_.begin(), constraints_.end(), visit);
	else
		std::for_each(constraints_.rbegin(), constraints_.rend(), visit);
	if (!moves_) change.along = 0; // where nothing is extrapolated
	return change;
}

template <int dim> void RigidPairSolver<dim>::extrapolate(double share)
{
	if (!moves_) return;
	for (Constraint& c : constraints_) {
		const Vec<dim> J = c.extrapolate(share);
		if (!J.isZero(0)) applyImpulse(c, J);
	}
}

template <int dim> ResidualSum RigidPairSolver<dim>::residual() const
{
	ResidualSum sum;
	for (const Constraint& c : constraints_) {
		c.addResidual(sum, velocity(c), friction(c));
		if (moves_) addExchange(sum, c);
	}
	return sum;
}

/// (What goes to the grain counts in full.)
template <int dim>
void RigidPairSolver<dim>::addExchange(ResidualSum& sum, const Constraint& c) const
{
	const double toGrain = c.grainMobility * c.impulse.squaredNorm();
	const Vec<dim> gained = partner_->velocityAt(c.arm) - partner_->freeVelocityAt(c.arm);
	sum.addExchange(c.energy(c.impulse) - toGrain, -c.impulse.dot(gained));
}

template <int dim> void RigidPairSolver<dim>::addHeldMotion(HeldMotion<dim>& motion) const
{
	motion.addDrift(drift_);
	motion.add(*partner_);
}

template <int dim> void RigidPairSolver<dim>::finish()
{
	PairSum<dim> sum;
	Spin<dim> turning = Spin<dim>::Zero();
	WorkOfOverlaps overlaps;
	const auto placeOf = [this](const Constraint& c) -> Vec<dim> {
		if (!c.ofNode) return imageCentre() + c.arm;
		const double gap = list_->contacts[numberOf(c)].gap;
		return grain_->touchedPoint(c.partner[0], c.normal, gap);
	};
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		const Constraint& c = constraints_[k];
		list_->contacts[k].impulse =
			list_->contacts[k].key.side == 0 ? c.impulse : Vec<dim>(-c.impulse);
		if (excessOverlap(list_->contacts[k].gap, grain_->pointSpacing,
				  restingOverlapOf(c)) > 0)
			overlaps.add(c.impulse.dot(c.normal), velocity(c).dot(c.normal));
		const Vec<dim> r = interface_ ? remember(k) : c.impulse;
		if (r.isZero(0)) continue;
		list_->contacts[k].setTwist(dt_ * spinOfPartner(list_->contacts[k].normal));
		sum.add(r, c.normal, 1, placeOf(c));
		turning -= moment<dim>(imageCentre() + c.arm - list_->rigid->pivot, r);
		for (int i = 0; i < c.partners; ++i)
			grain_->impulse[c.partner[i]] += c.weight[i] * r;
	}
	list_->impulse = sum.total(constraints_, placeOf);
	list_->impulse.moment = turning;
	list_->account.enter(overlaps);
}

template <int dim> ContactOutcome<dim> RigidPairSolver<dim>::outcomeOf(std::size_t k) const
{
	const Constraint& c = constraints_[k];
	return { c.normal,
		 c.impulse,
		 velocity(c),
		 spinOfPartner(c.normal),
		 list_->contacts[k].gap,
		 grain_->pointSpacing,
		 !c.ofNode };
}

template <int dim> Vec<dim> RigidPairSolver<dim>::remember(std::size_t k)
{
	const ContactOutcome<dim> now = outcomeOf(k);
	if (now.ofEnd && interface_->bondsAtTouch(now))
		if (const auto beside = list_->placeOfBond(k))
			interface_->bondOnce(*beside, outcomeOf(*beside));
	return interface_->remember(k, now, friction_);
}

template <> double RigidPairSolver<3>::spinOfPartner(const Vec<3>& normal) const
{
	return partner_->spin.dot(normal);
}

template <> double RigidPairSolver<2>::spinOfPartner(const Vec<2>&) const { return 0; }

template <int dim> ContactWork RigidPairSolver<dim>::work() const
{
	ContactWork work;
	auto pull = [this](const Constraint& c) {
		return interface_ ? interface_->history[numberOf(c)].pull
				  : Vec<dim>(Vec<dim>::Zero());
	};
	auto book = [&](const Constraint& c, const Vec<dim>& grain, const Vec<dim>& rigid,
			double ContactWork::Halves::* half) {
		const Vec<dim> relative = grain - rigid - drift_;
		work.addReaction<dim>(half, c.impulse, c.normal, relative);
		const Vec<dim> p = pull(c);
		work.cohesion.*half -= 0.5 * p.dot(relative);
		work.walls.*half += 0.5 * (c.impulse + p).dot(rigid);
		work.cell.*half += 0.5 * (c.impulse + p).dot(drift_);
	};
	for (const Constraint& c : constraints_) {
		if (c.impulse.isZero(0) && pull(c).isZero(0)) continue;
		book(c, grainVelocity(c, &ContactBody<dim>::velocityBefore), rigidVelocityBefore(c),
		     &ContactWork::Halves::before);
		book(c, grainVelocity(c, &ContactBody<dim>::velocity), rigidVelocity(c),
		     &ContactWork::Halves::after);
	}
	return work;
}

template class RigidPairSolver<2>;
template class RigidPairSolver<3>;

} // namespace softgrain
