// What a contact asks of its normal velocity.
#pragma once

#include "contact/SolverSettings.hpp"

#include <algorithm>

namespace softgrain {

/// Overlaps up to this share of dr are left as they are: working off what the tolerance of the
/// solver leaves in every step would heat grains at rest (doc/decisions/0010-grains-at-rest.md).
inline constexpr double restingOverlap = 1e-3;
/// The same of a rigid ball against the outline between nodes. In the dent that it makes the
/// outline comes nearer to it than the nodes that hold it, on both sides of each, and nearest now
/// here, now there: worked off by turns, that would heat for ever (0.12 dr for balls as large as
/// dr).
inline constexpr double restingOverlapOfBall = 0.2;

/// b: the speed at which a gap may close, or minus that at which an overlap is worked off but for
/// what may rest, in dr.
inline double biasOf(double gap, double pointSpacing, double dt, const SolverSettings& settings,
		     double resting = restingOverlap)
{
	if (gap >= 0) return gap / dt;
	const double excess = std::min(gap + resting * pointSpacing, 0.);
	return std::max(settings.overlapRelaxation * excess / dt, -settings.overlapSpeed);
}

} // namespace softgrain
