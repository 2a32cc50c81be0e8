#include "contact/Interface.hpp"
#include "Numbers.hpp"
#include "contact/Contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace softgrain {

namespace {

/// A sliding contact is on its cone up to rounding.
constexpr double coneRounding = 1e-9;

template <int dim> Vec<dim> across(const Vec<dim>& v, const Vec<dim>& n)
{
	return v - v.dot(n) * n;
}

/// A vector in the plane across the axis, turned about it.
Vec<2> turnedAbout(const Vec<2>& v, const Vec<2>&, double) { return v; }
Vec<3> turnedAbout(const Vec<3>& v, const Vec<3>& axis, double angle)
{
	return Eigen::AngleAxisd(angle, axis) * v;
}

/// Share of a part of an outline in which the gap is below `range`, were it to rise evenly: with
/// whole nodes the force of a curved contact would go by jumps.
double shareWithin(double range, double gap, double spread)
{
	if (spread <= 0) return gap < range ? 1 : 0;
	return std::clamp((range - gap) / spread + 0.5, 0., 1.);
}

} // namespace

template <int dim>
const Vec<dim>& PairInterface<dim>::pullOn(std::size_t k, const InterfacePlace<dim>& place)
{
	ContactHistory<dim>& h = history[k];
	Vec<dim> traction = Vec<dim>::Zero();
	if (law.hasCohesion())
		traction -= law.cohesion *
			    shareWithin(law.cohesionRange, place.gap, place.part.spread) *
			    place.normal;
	if (h.bond == Bond::whole && law.hasBond()) {
		h.slip = across<dim>(h.slip, place.normal);
		const Vec<dim> opening = h.slip + std::max(place.gap - h.start, 0.) * place.normal;
		h.largest = std::max(h.largest, opening.norm());
		if (h.largest >= law.finalOpening())
			h.bond = Bond::broken;
		else
			traction -= law.secantStiffness(h.largest) * opening;
	}
	h.pull = kick_ * place.part.area * traction;
	return h.pull;
}

template <int dim> std::vector<double> PairInterface<dim>::frictions(double friction) const
{
	std::vector<double> all(history.size());
	for (std::size_t k = 0; k < all.size(); ++k)
		all[k] = frictionOf(k, friction);
	return all;
}

template <int dim>
double PairInterface<dim>::biasOf(double bias, double gap, double before, bool closed) const
{
	const bool closes = !closed && before < 0 && gap + dt_ * before <= 0;
	return closes && law.restitution > 0 ? std::min(bias, law.restitution * before) : bias;
}

template <int dim>
Vec<dim> PairInterface<dim>::remember(std::size_t k, const ContactOutcome<dim>& now,
				      double friction)
{
	ContactHistory<dim>& h = history[k];
	h.isNew = false;
	const double pressed = now.reaction.dot(now.normal);
	if (pressed > 0)
		h.slid = across<dim>(now.reaction, now.normal).norm() >=
			 (1 - coneRounding) * frictionOf(k, friction) * pressed;
	if (h.bond == Bond::whole)
		h.slip = turnedAbout(h.slip, now.normal, dt_ * now.spin) +
			 dt_ * across<dim>(now.velocity, now.normal);
	else if (!now.ofEnd && bondsAtTouch(now))
		bondOnce(k, now);
	return now.reaction + h.pull;
}

template <int dim> bool PairInterface<dim>::bondsAtTouch(const ContactOutcome<dim>& now) const
{
	return law.hasBond() && law.bondAtTouch &&
	       touches<dim>(now.reaction, now.gap, now.pointSpacing);
}

template <int dim> double PairInterface<dim>::damage(std::size_t k) const
{
	const ContactHistory<dim>& h = history[k];
	if (h.bond == Bond::broken || !law.hasBond()) return 1;
	return 1 - law.secantStiffness(h.largest) / law.stiffness();
}

template <int dim> void PairInterface<dim>::bondOnce(std::size_t k, const ContactOutcome<dim>& now)
{
	if (history[k].bond == Bond::none) bondNow(k, now.gap + dt_ * now.velocity.dot(now.normal));
}

template <int dim> void PairInterface<dim>::bondNow(std::size_t k, double gap)
{
	ContactHistory<dim>& h = history[k];
	h.bond = Bond::whole;
	h.start = std::max(gap, 0.);
	h.largest = 0;
	h.slip.setZero();
}

template <int dim> void PairInterface<dim>::beginSearch()
{
	last_.swap(history);
	history.clear();
	for (const ContactHistory<dim>& h : last_)
		lost_ += h.bond == Bond::whole;
}

template <int dim> void PairInterface<dim>::carry(std::size_t from, std::size_t to)
{
	history[to] = std::exchange(last_[from], {});
	lost_ -= history[to].bond == Bond::whole;
}

template <int dim> void PairInterface<dim>::noteVanished(const std::vector<Contact<dim>>& last)
{
	for (std::size_t k = 0; k < last_.size(); ++k) {
		const ContactHistory<dim>& h = last_[k];
		if (last[k].key.side == 0 && (h.bond != Bond::none || h.slid))
			vanished.push_back({ last[k].key.node, last[k].normal, h });
	}
}

template <int dim> std::vector<double> PairInterface<dim>::numbers() const
{
	std::vector<double> all;
	for (const ContactHistory<dim>& h : history)
		append(all, h.pull, h.slip, h.start, h.largest, h.bond, h.slid);
	return all;
}

template <int dim> bool PairInterface<dim>::restore(const std::vector<double>& numbers)
{
	constexpr int each = 2 * dim + 4;
	if (numbers.size() % each != 0) return false;
	for (std::size_t bond = 2 * dim + 2; bond < numbers.size(); bond += each)
		if (!(numbers[bond] >= 0 && numbers[bond] <= static_cast<int>(Bond::broken)))
			return false;
	history.resize(numbers.size() / each);
	NumbersInTurn saved(numbers);
	for (ContactHistory<dim>& h : history) {
		saved.take(h.pull, h.slip, h.start, h.largest, h.bond, h.slid);
		h.isNew = false;
	}
	return true;
}

template class PairInterface<2>;
template class PairInterface<3>;

} // namespace softgrain
