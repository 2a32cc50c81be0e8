#include "contact/ContactList.hpp"

#include <cmath>

namespace softgrain {

template <int dim> bool ContactList<dim>::hasStillSupport() const
{
	if (rigid)
		return !rigid->moves && !rigid->hasVelocity &&
		       rigid->velocities.largestNorm() == 0 && image.velocity.isZero(0);
	return second < 0 && plane.velocity.isZero(0);
}

template <int dim> std::optional<std::size_t> ContactList<dim>::placeOfBond(std::size_t k) const
{
	const Contact<dim>& c = contacts[k];
	if (!rigid && c.key.isOfEdges()) return std::nullopt;
	if (!rigid || c.key.side == 0) return k;
	std::optional<std::size_t> place;
	double most = 0;
	for (int i = 0; i < c.partners; ++i) {
		const ContactKey key { 0, c.partner[i], -1 };
		const auto found = std::lower_bound(
			contacts.begin(), contacts.end(), key,
			[](const Contact<dim>& a, const ContactKey& b) { return a.key < b; });
		if (c.weight[i] <= most || found == contacts.end() || !(found->key == key))
			continue;
		most = c.weight[i];
		place = found - contacts.begin();
	}
	return place;
}

template <int dim> std::vector<double> ContactList<dim>::placeOfSecond() const
{
	if (second >= 0 && image.shift.isZero(0)) return {};
	if (second >= 0) return { image.shift.begin(), image.shift.end() };
	if (rigid) return placeNumbers<dim>(rigid->surface);
	std::vector<double> place(plane.point.begin(), plane.point.end());
	place.insert(place.end(), plane.normal.begin(), plane.normal.end());
	return place;
}

/// Where contacts only push, that is the direction of the sum; where others pull, they must not
/// cancel.
template <int dim> Vec<dim> ContactList<dim>::direction() const
{
	if (!interface) return impulse.normal.stableNormalized();
	Vec<dim> sum = Vec<dim>::Zero();
	for (std::size_t k = 0; k < contacts.size(); ++k) {
		const Contact<dim>& c = contacts[k];
		const Vec<dim> r = c.impulse + interface->history[k].pull;
		sum += (c.key.body() == 0 ? 1 : -1) * std::abs(r.dot(c.normal)) * c.normal;
	}
	return sum.stableNormalized();
}

template struct ContactList<2>;
template struct ContactList<3>;

} // namespace softgrain
