// What a contact asks of its normal velocity.
#pragma once

#include "contact/solve/SolverSettings.hpp"

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
/// Overlaps from this share of dr on are worked off at full speed in any case. Contacts that
/// wander leave 1e-2 dr, which are worked off at less than a hundredth of it
/// (doc/decisions/0010-grains-at-rest.md).
inline constexpr double urgentOverlap = 0.05;

/// What is to be worked off of an overlap: all but what may rest, in dr. m
inline double excessOverlap(double gap, double pointSpacing, double resting = restingOverlap)
{
	return std::max(-gap - resting * pointSpacing, 0.);
}

/// What the contacts of a pair may owe (OverlapAccount): the work of the forces of the last step
/// over what may rest, J. `spacingOf(contact)` is dr of its node's grain, m.
template <class Contacts, class Spacing>
double creditOf(const Contacts& contacts, double dt, Spacing&& spacingOf)
{
	double sum = 0; // N m s
	for (const auto& contact : contacts)
		sum += contact.impulse.dot(contact.normal) * spacingOf(contact);
	return restingOverlap * sum / dt;
}

/// What the contacts of a pair ask for in a step.
struct Bias {
	double dt; ///< s
	const SolverSettings& settings;
	bool atFullSpeed; ///< OverlapAccount::isGood

	/// b: the speed at which a gap may close, or minus that at which an overlap is worked off.
	/// Where it came about against no force, so that the account of the pair is not good, as
	/// where contacts wander over the outline, the speed falls with its cube: the work would
	/// make grains tremble for ever.
	double of(double gap, double pointSpacing, double resting = restingOverlap) const
	{
		if (gap >= 0) return gap / dt;
		const double excess = excessOverlap(gap, pointSpacing, resting);
		if (excess == 0) return 0;
		const double urgency = std::min(excess / (urgentOverlap * pointSpacing), 1.);
		const double share = atFullSpeed ? 1 : urgency * urgency * urgency;
		return -std::min(settings.overlapRelaxation * excess / dt,
				 share * settings.overlapSpeed);
	}
};

} // namespace softgrain
