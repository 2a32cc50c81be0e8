// What a pair of bodies lately took and gave where they overlap: doc/decisions/0010.
#pragma once

namespace softgrain {

/// Steps after which an entry is forgotten, and in which overlaps that were there from the start
/// are worked off whatever that gives.
inline constexpr int stepsOfAccount = 10000;

struct OverlapAccount {
	double taken = 0; ///< work lately taken from the bodies, less what was given, J
	int grace =
		stepsOfAccount; ///< steps left while overlaps that the pair began with are there

	/// Whether overlaps are to be worked off at full speed.
	bool isGood() const { return grace > 0 || taken > 0; }
	/// Enters a step: whether there are overlaps to be worked off, and what they gave, J.
	void enter(bool overlaps, double given)
	{
		if (grace > 0)
			grace = overlaps ? grace - 1 : 0;
		else
			taken = (1 - 1. / stepsOfAccount) * taken - given;
	}
};

} // namespace softgrain
