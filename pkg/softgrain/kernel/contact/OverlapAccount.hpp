// What a pair of bodies lately took and gave where they overlap:
// doc/decisions/0010-grains-at-rest.md.
#pragma once

namespace softgrain {

/// Steps after which an entry is forgotten, and in which overlaps that were there from the start
/// are worked off whatever that gives: at full speed 1e4 steps take away some 5 dr.
inline constexpr int stepsOfAccount = 10000;

/// What overlaps by more than may rest did in a step.
struct WorkOfOverlaps {
	bool any = false;
	double given = 0; ///< to the bodies, J

	/// One of them, with its normal impulse, N s, and velocity, m/s.
	void add(double impulse, double velocity)
	{
		any = true;
		given += impulse * velocity;
	}
};

struct OverlapAccount {
	double taken = 0; ///< work lately taken from the bodies, less what was given, J
	int grace =
		stepsOfAccount; ///< steps left while overlaps that the pair began with are there

	/// Whether overlaps are to be worked off at full speed. So much may be owed (`creditOf`),
	/// J: without it overlaps of a first load, which come about at low forces, would rest under
	/// high ones.
	bool isGood(double credit) const { return grace > 0 || taken > -credit; }
	void enter(const WorkOfOverlaps& work)
	{
		if (grace > 0)
			grace = work.any ? grace - 1 : 0;
		else
			taken = (1 - 1. / stepsOfAccount) * taken - work.given;
	}
};

} // namespace softgrain
