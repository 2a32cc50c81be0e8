#include "contact/solve/PairSolver.hpp"
#include "contact/Lever.hpp"
#include "contact/Pressure.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/PairSum.hpp"
#include "lanes/Lanes.hpp"

#include <algorithm>
#include <cassert>

namespace softgrain {

namespace {

/// sum_i w_i v_i over the nodes that bear a contact; of those that are not there the weight is 0.
template <class Constraint> Vec<2> borneVelocity(const Constraint& c, const Vec<2>* v)
{
	auto share = [&](int i) { return c.weight[i] * bothOf(v[c.partner[i]]); };
	const BothComponents sum = (share(0) + share(1)) + (share(2) + share(3));
	return { sum[0], sum[1] };
}

template <class Constraint> Vec<3> borneVelocity(const Constraint& c, const Vec<3>* v)
{
	auto share = [&](int i) { return c.weight[i] * v[c.partner[i]]; };
	return (share(0) + share(1)) + share(2);
}

/// Of the body on which the impulse acts, from the velocities of its nodes.
template <int dim, class Constraint> Vec<dim> ownVelocity(const Constraint& c, const Vec<dim>* v)
{
	if constexpr (dim == 3)
		if (c.isOnEdge()) return (1 - c.share) * v[c.from] + c.share * v[c.to];
	return v[c.node];
}

/// W of the place on it, 1/kg.
template <int dim, class Constraint>
double ownMobility(const BodySide<dim>& side, const Constraint& c)
{
	double W = 0;
	forOwnNodes<dim>(c, c.node, [&](int node, double w) {
		forOwnNodes<dim>(c, c.node, [&](int other, double v) {
			W += w * v *
			     (node == other ? side.mobilityOf(node)
					    : side.mobilityBetween(node, other));
		});
	});
	return W;
}

} // namespace

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
PairSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list, double dt,
			 const SolverSettings& settings, Constraint* room)
{
	list_ = &list;
	first_ = &bodies[list.first];
	second_ = list.second < 0 ? nullptr : &bodies[list.second];
	drift_[1] = second_ ? list.image.velocity : list.plane.velocity;
	drift_[0] = -drift_[1];
	friction_ = list.friction;
	interface_ = list.interface ? &*list.interface : nullptr;
	firstSide_ = BodySide<dim>(*first_);
	secondSide_ = second_ ? BodySide<dim>(*second_) : BodySide<dim>();
	const auto spacingOf = [this](const Contact<dim>& c) {
		return (c.key.body() == 0 ? first_ : second_)->pointSpacing;
	};
	const Bias bias { dt, settings,
			  list.account.isGood(creditOf(list.contacts, dt, spacingOf)) };
	constraints_ = { room, list.contacts.size() };
	start_.resize(list.contacts.size());
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& contact = list.contacts[k];
		Constraint& c = constraints_[k];
		describe(contact, bias, c);
		if (k > 0) constraints_[k - 1].coupling = couplingOf(constraints_[k - 1], c);
		start_[k] = c.impulse;
		if (!c.impulse.isZero(0)) applyImpulse(c, c.impulse);
	}
	findStretch(firstSide_, true);
	if (second_) findStretch(secondSide_, false);
	frictions_.clear();
	if (interface_) engageInterface();
}

template <int dim>
void PairSolver<dim>::describe(const Contact<dim>& contact, const Bias& bias, Constraint& c) const
{
	c.normal = contact.normal;
	c.impulse = onCone<dim>(contact.impulse, contact.normal, friction_);
	static_cast<PlaceOnEdge<dim>&>(c) = contact;
	c.node = contact.key.node;
	c.onFirst = contact.key.body() == 0;
	c.facet = contact.facet;
	c.partners = static_cast<signed char>(contact.partners);
	c.partner = contact.partner;
	c.weight = contact.weight;
	c.bias = bias.of(contact.gap, own(c)->pointSpacing);
	c.W = ownMobility<dim>(ownSide(c), c);
	if (c.partners > 0) c.W += otherSide(c).mobilityOf(c);
	c.inverseW = 1 / c.W;
}

template <int dim> void PairSolver<dim>::engageInterface()
{
	frictions_ = interface_->frictions(friction_);
	interface_->engage(
		constraints_, list_->contacts, contactAreas<dim>(*first_, second_, list_->contacts),
		!second_,
		[this](const Constraint& c, const Vec<dim>& p) {
			applyImpulse(c, p);
			const BodySide<dim>& side = otherSide(c);
			forEachLever(c, [&](int node, const Vec<dim>& a) {
				side.push(side.velocity, node, p.dot(a) * c.normal);
			});
		},
		[this](const Constraint& c) { return velocityBefore(c); });
}

template <int dim>
template <class Visit>
void PairSolver<dim>::forEachLever(const Constraint& c, Visit&& visit) const
{
	const std::size_t k = numberOf(c);
	if (!interface_ || interface_->history[k].bond != Bond::whole) return;
	if (c.partners < mostPartners<dim>) return; // of a plane, which does not turn
	std::array<Vec<dim>, mostPartners<dim>> places;
	for (std::size_t i = 0; i < places.size(); ++i)
		places[i] = other(c)->position[c.partner[i]];
	const Levers<dim> levers = leversOf(places, c.normal, list_->contacts[k].gap);
	for (std::size_t i = 0; i < places.size(); ++i)
		visit(c.partner[i], levers[i]);
}

template <int dim>
Vec<dim> PairSolver<dim>::velocityAcross(const Constraint& c, const Vec<dim>& u,
					 const Vec<dim>* bearing) const
{
	Vec<dim> v = u;
	forEachLever(c, [&](int node, const Vec<dim>& a) { v += a * c.normal.dot(bearing[node]); });
	return v;
}

template <int dim>
double PairSolver<dim>::couplingOf(const Constraint& c, const Constraint& d) const
{
	double W = 0;
	// what an impulse on a place of c, the other way if `sign` is -1, does to the velocity of d
	auto add = [&](const BodySide<dim>& side, const auto& place, double sign) {
		if (side.body == own(d))
			forOwnNodes<dim>(d, d.node, [&](int node, double w) {
				W += sign * w * side.mobilityBetween(place, node);
			});
		if (side.body == other(d))
			for (int i = 0; i < d.partners; ++i)
				W -= sign * d.weight[i] * side.mobilityBetween(place, d.partner[i]);
	};
	forOwnNodes<dim>(c, c.node, [&](int node, double w) { add(ownSide(c), node, w); });
	if (c.partners > 0) add(otherSide(c), c, -1);
	return W;
}

template <int dim> Vec<dim> PairSolver<dim>::velocityBefore(const Constraint& c) const
{
	return relativeVelocity(c, own(c)->velocityBefore.data(), otherBefore(c),
				drift_[c.onFirst]);
}

template <int dim>
Vec<dim> PairSolver<dim>::relativeVelocity(const Constraint& c, const Vec<dim>* own,
					   const Vec<dim>* other, const Vec<dim>& drift) const
{
	const Vec<dim> u = ownVelocity<dim>(c, own) - drift;
	return c.partners > 0 ? Vec<dim>(u - borneVelocity(c, other)) : u;
}

template <int dim> Vec<dim> PairSolver<dim>::wantedImpulse(const Constraint& c) const
{
	return softgrain::wantedImpulse<dim>(c.impulse, velocity(c), c.normal, c.bias, c.inverseW);
}

template <int dim> double PairSolver<dim>::wantedAlongNormal(const Constraint& c) const
{
	return c.impulse.dot(c.normal) - c.inverseW * (velocity(c).dot(c.normal) + c.bias);
}

template <int dim> void PairSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	push(c, J, ownSide(c).velocity, otherSide(c).velocity);
}

template <int dim>
void PairSolver<dim>::push(const Constraint& c, const Vec<dim>& J, Vec<dim>* ownVelocity,
			   Vec<dim>* otherVelocity) const
{
	forOwnNodes<dim>(c, c.node,
			 [&](int node, double w) { ownSide(c).push(ownVelocity, node, w * J); });
	if (c.partners > 0) otherSide(c).push(otherVelocity, c, J, -1);
}

/// (Each contact waits for the impulse of the one before it, and what that does to the nodes would
/// be known late: velocities are read before the impulse moves them, and what it does to them is
/// added by the coupling of the two. Without friction the wanted impulse is one number.)
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS SweepChange PairSolver<dim>::sweep(SweepOrder order)
{
	assert(contacts() > 0);
	const int step = order == SweepOrder::forwards ? 1 : -1;
	// inline: it is to have the instruction set of this function
	auto sweepWith = [&](auto&& wantedAt, auto&& admissible,
			     auto&& partOf) __attribute__((always_inline)) {
		SweepChange sum;
		int k = step > 0 ? 0 : contacts() - 1;
		auto wanted = wantedAt(constraints_[k]);
		for (int left = contacts() - 1; left >= 0; --left, k += step) {
			Constraint& c = constraints_[k];
			const Vec<dim> r = admissible(c, wanted);
			const Vec<dim> J = r - c.impulse;
			sum.total += c.W * r.squaredNorm();
			if (left > 0) wanted = wantedAt(constraints_[k + step]);
			if (J.isZero(0)) continue;
			if (left > 0) {
				const double W = constraints_[std::min(k, k + step)].coupling;
				const Constraint& next = constraints_[k + step];
				wanted -= (W * next.inverseW) * partOf(next, J);
			}
			sum.changed += c.W * J.squaredNorm();
			c.impulse = r;
			applyImpulse(c, J);
		}
		return sum;
	};
	using Row = const Constraint&;
	if (isFrictionless())
		return sweepWith(
			[this](Row c) { return wantedAlongNormal(c); },
			[](Row c, double r) -> Vec<dim> { return std::max(r, 0.) * c.normal; },
			[](Row c, const Vec<dim>& J) { return J.dot(c.normal); });
	return withFriction([&](auto&& friction) {
		return sweepWith([this](Row c) { return wantedImpulse(c); },
				 [&](Row c, const Vec<dim>& r) {
					 return onCone<dim>(r, c.normal, friction(c));
				 },
				 [](Row, const Vec<dim>& J) -> const Vec<dim>& { return J; });
	});
}

template <int dim> SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS ResidualSum PairSolver<dim>::residual() const
{
	return withFriction([&](auto&& friction) {
		ResidualSum sum;
		for (const Constraint& c : constraints_)
			sum.template add<dim>(c.impulse,
					      onCone<dim>(wantedImpulse(c), c.normal, friction(c)),
					      c.W);
		return sum;
	});
}

/// W column by column: what unit impulses on the contacts do to velocities that are zero without
/// them. Directions do not mix, so each direction serves a contact of its own.
template <int dim> void PairSolver<dim>::describe(PairProblem<dim>& problem) const
{
	thread_local std::array<std::vector<Vec<dim>>, 2> response; // of second_, first_
	const bool itself = second_ == first_;                      // its own image
	const int n = contacts();
	problem.resize(n);
	for (int begin = 0; begin < n; begin += dim) {
		const int end = std::min(begin + dim, n);
		response[1].assign(first_->velocity.size(), Vec<dim>::Zero());
		if (second_) response[0].assign(second_->velocity.size(), Vec<dim>::Zero());
		auto of = [&](bool first) { return response[first || itself].data(); };
		for (int k = begin; k < end; ++k) {
			const Constraint& c = constraints_[k];
			push(c, Vec<dim>::Unit(k - begin), of(c.onFirst), of(!c.onFirst));
		}
		for (int l = 0; l < n; ++l) {
			const Constraint& c = constraints_[l];
			const Vec<dim> u = relativeVelocity(c, of(c.onFirst), of(!c.onFirst),
							    Vec<dim>::Zero());
			for (int k = begin; k < end; ++k)
				problem.column(k)[l] = u[k - begin];
		}
	}
	for (int k = 0; k < n; ++k) {
		const Constraint& c = constraints_[k];
		problem.setContact(k, c.normal, c.bias, friction(c), c.impulse, velocity(c));
	}
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS int PairSolver<dim>::solveAlone(double violation, int maxSweeps)
{
	thread_local PairProblem<dim> problem;
	describe(problem);
	const int sweeps = problem.solve(violation, maxSweeps);
	for (int k = 0; k < contacts(); ++k) {
		Constraint& c = constraints_[k];
		const Vec<dim> J = problem.impulse(k) - c.impulse;
		if (J.isZero(0)) continue;
		c.impulse = problem.impulse(k);
		applyImpulse(c, J);
	}
	return sweeps;
}

template <int dim> void PairSolver<dim>::finish()
{
	PairSum<dim> sum;
	WorkOfOverlaps overlaps;
	for (std::size_t k = 0; k < constraints_.size(); ++k) {
		const Constraint& c = constraints_[k];
		list_->contacts[k].impulse = c.impulse;
		if (excessOverlap(list_->contacts[k].gap, own(c)->pointSpacing) > 0)
			overlaps.add(c.impulse.dot(c.normal), velocity(c).dot(c.normal));
		const Vec<dim> r =
			interface_ ? interface_->remember(k,
							  { c.normal, c.impulse,
							    velocityAcross(c, velocity(c),
									   otherSide(c).velocity),
							    spinOfOther(c), list_->contacts[k].gap,
							    own(c)->pointSpacing, c.isOnEdge() },
							  friction_)
				   : c.impulse;
		if (r.isZero(0)) continue;
		sum.add(r, c.normal, c.onFirst ? 1 : -1, placeOf(c));
		forOwnNodes<dim>(c, c.node,
				 [&](int node, double w) { own(c)->impulse[node] += w * r; });
		for (int i = 0; i < c.partners; ++i)
			other(c)->impulse[c.partner[i]] -= c.weight[i] * r;
		forEachLever(c, [&](int node, const Vec<dim>& a) {
			other(c)->impulse[node] += interface_->history[k].pull.dot(a) * c.normal;
		});
	}
	list_->impulse =
		sum.total(constraints_, [this](const Constraint& c) { return placeOf(c); });
	list_->account.enter(overlaps);
}

template <int dim> Vec<dim> PairSolver<dim>::placeOf(const Constraint& c) const
{
	const double gap = list_->contacts[numberOf(c)].gap;
	Vec<dim> place = Vec<dim>::Zero();
	forOwnNodes<dim>(c, c.node, [&](int node, double w) {
		place += w * own(c)->touchedPoint(node, c.normal, gap);
	});
	return c.onFirst ? place : Vec<dim>(place + list_->image.shift);
}

/// That of an edge of the facet that the contact lies against; 0 where that edge is along the
/// normal, as it may be beyond the end of a face.
template <> double PairSolver<3>::spinOfOther(const Constraint& c) const
{
	constexpr double leastShare = 0.25; // of the edge across the normal, squared
	if (c.partners < 2) return 0;
	const int from = c.partner[0], to = c.partner[1];
	const ContactBody<3>& body = *other(c);
	const Vec<3> edge = body.position[to] - body.position[from];
	const Vec<3> velocity = body.velocity[to] - body.velocity[from];
	const Vec<3> across = edge - edge.dot(c.normal) * c.normal;
	if (!(across.squaredNorm() > leastShare * edge.squaredNorm())) return 0;
	return across.cross(velocity).dot(c.normal) / across.squaredNorm();
}

template <> double PairSolver<2>::spinOfOther(const Constraint&) const { return 0; }

template <int dim> void PairSolver<dim>::addHeldMotion(HeldMotion<dim>& motion) const
{
	if (second_)
		motion.addDrift(list_->image.velocity);
	else
		motion.add(list_->plane.velocity);
}

template <int dim> ContactWork PairSolver<dim>::work() const
{
	ContactWork work;
	for (const Constraint& c : constraints_) {
		const Vec<dim>& r = c.impulse;
		const Vec<dim> p = interface_ ? interface_->history[numberOf(c)].pull
					      : Vec<dim>(Vec<dim>::Zero());
		if (r.isZero(0) && p.isZero(0)) continue;
		const Vec<dim> before = velocityBefore(c);
		const Vec<dim> after = velocity(c);
		work.addReaction<dim>(&ContactWork::Halves::before, r, c.normal, before);
		work.addReaction<dim>(&ContactWork::Halves::after, r, c.normal, after);
		work.cohesion.before -= 0.5 * p.dot(velocityAcross(c, before, otherBefore(c)));
		work.cohesion.after -= 0.5 * p.dot(velocityAcross(c, after, otherSide(c).velocity));
		const double driven = 0.5 * (r + p).dot(drift_[c.onFirst]);
		(second_ ? work.cell : work.walls) += { driven, driven };
	}
	return work;
}

template class PairSolver<2>;
template class PairSolver<3>;

} // namespace softgrain
