// What two surfaces do to each other besides unilateral contact with one coefficient of friction.
//
// Friction: mu_s where a contact stuck in the last step, mu_d where it slid.
// Cohesion (Dugdale): the constant traction sigma_c wherever the gap is below the range delta.
// Bond: bilinear in the effective opening l = |<g - g_0> n + s|, s the slip since the bond formed,
//     traction = - K (1 - D) (<g - g_0> n + s),
//     D = 0 up to l_0 = strength/K,   l_f (L - l_0)/(L (l_f - l_0)) above,   1 from l_f on,
// L the largest l so far: secant unloading, and the energy strength l_f/2 to break it, in whatever
// mixture of opening and slip.
// Restitution (Newton, Moreau): what closes in a step leaves with e times the speed it came with.
#pragma once

#include <array>

namespace softgrain {

struct InterfaceLaw {
	double dynamicFriction = -1; ///< mu_d; negative: that of a contact that sticks
	double cohesion = 0;         ///< sigma_c, Pa
	double cohesionRange = 0;    ///< delta, m
	double bondStrength = 0;     ///< largest traction of a bond, Pa; 0: there are none
	double bondEnergy = 0;       ///< to break it, J/m^2
	double bondStiffness = 0;    ///< K, Pa/m; 0: the strength is met at a tenth of l_f
	bool bondAtTouch = true;     ///< contacts bond when they touch; else only when told to
	double restitution = 0;      ///< e

	/// Throws std::invalid_argument; `friction` is mu_s.
	void validate(double friction) const;
	bool hasDynamicFriction() const { return dynamicFriction >= 0; }
	bool hasCohesion() const { return cohesion > 0; }
	bool hasBond() const { return bondStrength > 0; }
	double finalOpening() const { return 2 * bondEnergy / bondStrength; } ///< l_f, m
	double stiffness() const;                                             ///< K, Pa/m
	/// K (1 - D), Pa/m.
	double secantStiffness(double largest) const;
	/// No traction acts across a larger gap, m.
	double range() const;

	/// For saving, and back.
	using Numbers = std::array<double, 8>;
	Numbers numbers() const;
	static InterfaceLaw fromNumbers(const Numbers& numbers);
	bool operator==(const InterfaceLaw& o) const { return numbers() == o.numbers(); }
};

} // namespace softgrain
