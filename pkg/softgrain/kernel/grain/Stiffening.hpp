// How much deformation shortens the critical time step of a grain.
#pragma once

#include "grain/Batch.hpp"

#include <algorithm>
#include <vector>

namespace softgrain {

/// Square of the highest frequency of a grain over that of the undeformed one: at most about the
/// largest stiffening of a material point (the bound), which is known in every step. Now and then
/// it is measured. What it is of the bound, its share, counts while the grain is deformed much as
/// it was then; otherwise a share counts that is safe whatever happens
/// (doc/decisions/0003-time-step.md, with the rules that were compared for the numbers below).
class Stiffening {
public:
	/// However the share changes, 0.9 of the critical step found with it is stable.
	static constexpr double safeShare = 0.9 * 0.9;

	/// At least 1.
	double value(const BulkReport& present) const
	{
		const double safe = std::max(share_, safeShare) * present.stiffening;
		if (!isAlike(present)) return std::max(1., safe);
		// what was measured, as far as it is not known to have fallen
		const double measured = share_ * std::max(bound_, present.stiffening);
		return std::max(1., std::min(safe, measured));
	}
	/// Whether a measurement may find less than `value`, and is worth its time.
	bool isDue(const BulkReport& present) const
	{
		if (value(present) <= 1) return false;
		return present.stiffening > dueGrowth * bound_ ||
		       (share_ < safeShare && present.elasticEnergy > spread * energy_);
	}
	/// Nothing is due after it until the deformation has changed. (Where it gave no number, as
	/// of a grain squeezed to a point, the bound stands.)
	void set(const BulkReport& present, double measured)
	{
		bound_ = std::max(1., present.stiffening);
		energy_ = std::max(0., present.elasticEnergy); // one carried on may be negative
		share_ = measured > 0 ? admissible(measured / bound_) : 1;
	}
	bool isMeasured() const { return bound_ > 1; }

	/// For saving, and back.
	static constexpr int numberCount = 3;
	std::vector<double> numbers() const { return { bound_, energy_, share_ }; }
	static Stiffening fromNumbers(const std::vector<double>& numbers)
	{
		Stiffening s;
		s.bound_ = numbers[0];
		s.energy_ = numbers[1];
		s.share_ = admissible(numbers[2]);
		return s;
	}

private:
	static double admissible(double share) { return std::clamp(share, leastShare, mostShare); }
	/// Neither stiffer where it is stiffest, nor deformed in more places, nor let go since:
	/// what is pressed all round after it was pressed in one place holds more energy. (No
	/// proof: how far it is from the truth in packings and impacts was measured.)
	bool isAlike(const BulkReport& present) const
	{
		return present.stiffening <= growth * bound_ &&
		       present.elasticEnergy <= spread * energy_ &&
		       present.elasticEnergy >= release * energy_;
	}

	/// Of the bound while a grain counts as deformed alike, and from which on a measurement may
	/// find less.
	static constexpr double growth = 1.25, dueGrowth = 1.02;
	/// Of the elastic energy.
	static constexpr double spread = 1.5, release = 0.25;
	/// With smaller ones dense packings take a few per cent fewer steps; it limits what a wrong
	/// "alike" can do.
	static constexpr double leastShare = 0.5;
	/// Coarse grains pressed all round were up to 1.23 of the bound, by the largest of their
	/// own frequencies.
	static constexpr double mostShare = 1.5;

	/// At the last measurement; the energy in J (2D: J/m).
	double bound_ = 1, energy_ = 0, share_ = 1;
};

} // namespace softgrain
