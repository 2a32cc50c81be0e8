// Coulomb's law at one contact, as a map of impulses.
#pragma once

#include "Vector.hpp"

#include <algorithm>

namespace softgrain {

/// proj_C: normal part first, max(0, r_n); then the tangential part is cut to mu r_n. This is not
/// the nearest point of the cone, which would lift r_n where the tangential part is too large: with
/// it a sliding contact would open, u_n = mu |u_t|. `n` is a unit vector, the friction finite.
template <int dim> Vec<dim> onCone(const Vec<dim>& r, const Vec<dim>& n, double friction)
{
	const double normal = std::max(r.dot(n), 0.); // nan stays
	const double bound = friction * normal;
	if constexpr (dim == 2) { // without branches, which no processor would foresee
		const Vec<dim> t(-n[1], n[0]);
		return normal * n + std::clamp(r.dot(t), -bound, bound) * t;
	} else {
		if (bound == 0) return normal * n;
		const Vec<dim> tangential = r - normal * n;
		const double size = tangential.norm();
		if (size <= bound) return r;
		return normal * n + (bound / size) * tangential;
	}
}

/// Impulse that would leave one contact with the velocity -b n while all others are held, if it
/// could be any: u is the velocity with the present impulse r, b the bias, W the (isotropic)
/// mobility of the contact.
template <int dim>
Vec<dim> wantedImpulse(const Vec<dim>& r, const Vec<dim>& u, const Vec<dim>& n, double b,
		       double inverseW)
{
	return r - inverseW * (u + b * n);
}

/// Impulse that solves one contact exactly while all others are held. Conditions hold at all
/// contacts if and only if this changes no impulse.
template <int dim>
Vec<dim> solvedContact(const Vec<dim>& r, const Vec<dim>& u, const Vec<dim>& n, double b,
		       double inverseW, double friction)
{
	return onCone<dim>(wantedImpulse<dim>(r, u, n, b, inverseW), n, friction);
}

} // namespace softgrain
