// Forces of the second differences that hold patterns of nodes (reference/Hourglass.hpp).
#pragma once

#include "reference/Hourglass.hpp"

namespace softgrain {

/// Adds the forces of the stencils and their energy; `x(place, a)` and `force(place, a)` are
/// numbers (or lanes of them) of the nodes in the box, in radii and in radii^(dim - 1) times the
/// stress.
template <class Number, int dim, class Field, class Forces>
void addHourglassForces(const std::vector<HourglassStencil>& stencils, const Number& mu, Field&& x,
			Forces&& force, Number& energy)
{
	constexpr int nodes = 9;
	constexpr double share[nodes] { 1. / 16, -1. / 8, 1. / 16, -1. / 8, 1. / 4,
					-1. / 8, 1. / 16, -1. / 8, 1. / 16 };
	for (const HourglassStencil& s : stencils) {
		const auto [u, v] = s.way;
		const int place[nodes] { s.place - u - v, s.place - u, s.place - u + v,
					 s.place - v,     s.place,     s.place + v,
					 s.place + u - v, s.place + u, s.place + u + v };
		const Number stiffness = s.stiffness * mu;
		for (int a = 0; a < dim; ++a) {
			Number q = share[0] * x(place[0], a);
			for (int k = 1; k < nodes; ++k)
				q += share[k] * x(place[k], a);
			const Number f = stiffness * q;
			energy += 0.5 * f * q;
			for (int k = 0; k < nodes; ++k)
				force(place[k], a) -= share[k] * f;
		}
	}
}

} // namespace softgrain
