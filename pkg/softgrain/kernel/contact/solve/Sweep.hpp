// What sweeps of nonlinear Gauss-Seidel over contacts did, and how far to go on beyond them.
#pragma once

#include <cmath>
#include <limits>

namespace softgrain {

/// What a sweep did, in the residual's norm, kg m^2/s^2.
struct SweepChange {
	double changed = 0; ///< sum W |dr|^2
	double total = 0;   ///< sum W |r|^2
	double along = 0;   ///< sum W dr.(r - r_before): negative if it turns back

	/// What changed over what there is.
	double share() const { return changed > 0 ? std::sqrt(changed / total) : 0; }
	SweepChange& operator+=(const SweepChange& other)
	{
		changed += other.changed;
		total += other.total;
		along += other.along;
		return *this;
	}
};

/// How far to go on beyond what a sweep left before the next one (Nesterov 1983): after the j-th in
/// a row from
///     r + j/(j + 2) (r - r_before),
/// with r, r_before what the last two sweeps left; j starts anew when a sweep turns back, that is
/// when sum W (r - what it began with).(r - r_before) < 0 (O'Donoghue and Candes 2015), or changes
/// more than the one before: wedged contacts of large friction, whose impulses hold each other,
/// would grow without ever turning back. What was extrapolated need not be on the cone; what a
/// sweep leaves is.
class Extrapolation {
public:
	/// j/(j + 2) after this sweep.
	double shareAfter(const SweepChange& sweep)
	{
		const bool turnsBack = sweep.along < 0 || sweep.changed > changed_;
		changed_ = sweep.changed;
		inARow_ = turnsBack ? 0 : inARow_ + 1;
		return inARow_ / (inARow_ + 2.);
	}

private:
	int inARow_ = 0;
	double changed_ = std::numeric_limits<double>::infinity();
};

enum class SweepOrder { forwards, backwards };

} // namespace softgrain
