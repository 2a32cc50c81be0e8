// What a contact asks of its normal velocity.
#pragma once

#include "contact/SolverSettings.hpp"

#include <algorithm>

namespace softgrain {

/// Overlaps up to this share of dr are left as they are: working off what the tolerance of the
/// solver leaves in every step would heat grains at rest (doc/decisions/0010-grains-at-rest.md).
inline constexpr double restingOverlap = 1e-3;

/// b: the speed at which a gap may close, or minus that at which an overlap is worked off.
inline double biasOf(double gap, double pointSpacing, double dt, const SolverSettings& settings)
{
	if (gap >= 0) return gap / dt;
	const double excess = std::min(gap + restingOverlap * pointSpacing, 0.);
	return std::max(settings.overlapRelaxation * excess / dt, -settings.overlapSpeed);
}

} // namespace softgrain
