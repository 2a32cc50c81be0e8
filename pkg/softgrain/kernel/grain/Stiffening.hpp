// How much deformation shortens the critical time step of a grain.
#pragma once

#include <algorithm>
#include <vector>

namespace softgrain {

/// Square of the highest frequency of a grain over that of the undeformed one: at most the largest
/// stiffening of a material point, which is known in every step. Now and then it is measured, and
/// taken to keep its share of that bound until the bound has grown
/// (doc/decisions/0003-time-step.md).
class Stiffening {
public:
	/// At least 1.
	double value(double bound) const { return std::max(1., share_ * bound); }
	/// Whether a measurement may find less than `value`.
	bool isDue(double bound) const { return bound > growth * measuredAt_; }
	void set(double bound, double measured)
	{
		measuredAt_ = bound;
		share_ = std::clamp(measured / bound, leastShare, 1.);
	}
	bool isMeasured() const { return measuredAt_ > 1; }

	/// For saving, and back.
	static constexpr int numberCount = 2;
	std::vector<double> numbers() const { return { measuredAt_, share_ }; }
	static Stiffening fromNumbers(const std::vector<double>& numbers)
	{
		Stiffening s;
		s.measuredAt_ = numbers[0];
		s.share_ = std::max(leastShare, numbers[1]);
		return s;
	}

private:
	/// Of the bound between measurements: a grain is measured some twenty times in its life.
	static constexpr double growth = 1.05;
	/// However the share changes, 0.9 of the critical step found with it is stable.
	static constexpr double leastShare = 0.9 * 0.9;

	double measuredAt_ = 1, share_ = 1;
};

} // namespace softgrain
