// Damping of one grain's material, in Rayleigh's two terms.
#pragma once

#include "Require.hpp"

#include <cmath>

namespace softgrain {

struct Damping {
	/// alpha, 1/s, >= 0: deviations from the grain's rigid motion lose the share
	/// 1 - exp(-alpha t) of their velocity in the time t.
	double mass = 0;
	/// beta, s, >= 0: stress from the rate of strain, beta times the small-strain stiffness.
	double stiffness = 0;

	bool acts() const { return mass > 0 || stiffness > 0; }
	bool operator==(const Damping& o) const
	{
		return mass == o.mass && stiffness == o.stiffness;
	}
	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate() const
	{
		require(mass >= 0 && std::isfinite(mass), "massDamping", mass, "[0, inf) 1/s");
		require(stiffness >= 0 && std::isfinite(stiffness), "stiffnessDamping", stiffness,
			"[0, inf) s");
	}
};

} // namespace softgrain
