#include "contact/InterfaceLaw.hpp"
#include "Require.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace softgrain {

namespace {

/// l_0 over l_f where no stiffness is given: a soft onset, which hardly limits the time step.
constexpr double usualOnset = 0.1;

void requireNonNegative(const char* parameter, double value, const char* range)
{
	require(value >= 0 && std::isfinite(value), parameter, value, range);
}

/// As angles, which is what users give.
void requireDynamicFriction(double dynamicFriction, double friction)
{
	if (dynamicFriction <= friction) return;
	std::ostringstream range;
	range << "[0, " << std::atan(friction) << "] rad, up to the angle of static friction "
	      << "(tangensOfDynamicFrictionAngle: up to " << friction << ")";
	refuse("dynamicFrictAngle", std::atan(dynamicFriction), range.str());
}

} // namespace

void InterfaceLaw::validate(double friction) const
{
	require(friction >= 0 && std::isfinite(friction), "friction", friction, "[0, inf)");
	requireDynamicFriction(dynamicFriction, friction);
	requireNonNegative("cohesion", cohesion, "[0, inf) Pa");
	requireNonNegative("cohesionRange", cohesionRange, "[0, inf) m");
	require(!hasCohesion() || cohesionRange > 0, "cohesionRange", cohesionRange,
		"(0, inf) m where cohesion > 0");
	requireNonNegative("bondStrength", bondStrength, "[0, inf) Pa");
	requireNonNegative("bondEnergy", bondEnergy, "[0, inf) J/m^2");
	requireNonNegative("bondStiffness", bondStiffness, "[0, inf) Pa/m");
	require(restitution >= 0 && restitution <= 1, "restitution", restitution, "[0, 1]");
	if (!hasBond()) return;
	require(bondEnergy > 0, "bondEnergy", bondEnergy, "(0, inf) J/m^2 where bondStrength > 0");
	require(bondStrength / stiffness() < finalOpening(), "bondStiffness", bondStiffness,
		"(bondStrength^2/(2 bondEnergy), inf) Pa/m, or 0 for the usual one");
}

double InterfaceLaw::stiffness() const
{
	return bondStiffness > 0 ? bondStiffness : bondStrength / (usualOnset * finalOpening());
}

double InterfaceLaw::secantStiffness(double largest) const
{
	const double K = stiffness(), onset = bondStrength / K, end = finalOpening();
	if (largest <= onset) return K;
	if (largest >= end) return 0;
	return bondStrength * (end - largest) / ((end - onset) * largest);
}

double InterfaceLaw::range() const
{
	return std::max(hasCohesion() ? cohesionRange : 0, hasBond() ? finalOpening() : 0);
}

InterfaceLaw::Numbers InterfaceLaw::numbers() const
{
	return { dynamicFriction, cohesion,      cohesionRange,         bondStrength,
		 bondEnergy,      bondStiffness, bondAtTouch ? 1. : 0., restitution };
}

InterfaceLaw InterfaceLaw::fromNumbers(const Numbers& n)
{
	return { n[0], n[1], n[2], n[3], n[4], n[5], n[6] != 0, n[7] };
}

} // namespace softgrain
