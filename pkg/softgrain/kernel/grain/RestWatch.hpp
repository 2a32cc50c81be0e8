// When a grain counts as at rest, and what a grain that is asleep goes on from.
#pragma once

#include "grain/Batch.hpp"

#include <numbers>

namespace softgrain {

/// A damped grain is calm while its kinetic energy is below a share of its elastic energy. Damping
/// that is more than critical slows the way to equilibrium down: what is left of it is then larger
/// than the speed says, by damping over frequency, and the share is smaller by the square of that.
/// (doc/decisions/0014-inactive-grains.md)
class RestWatch {
public:
	/// `slowest`: period of the slowest vibration, s.
	RestWatch(const Damping& damping, double slowest);

	bool mayRest() const { return mayRest_; }
	bool isCalm(double kineticEnergy, double elasticEnergy) const
	{
		return elasticEnergy > 0 && kineticEnergy <= share_ * elasticEnergy;
	}
	/// Whether forces that change velocities by so much kinetic energy in a step balance:
	/// within a radian of the slowest vibration they would bring up no more than a calm grain
	/// has.
	bool isBalanced(double energyOfChange, double kick, double elasticEnergy) const
	{
		const double radians = 2 * std::numbers::pi * kick / period_;
		return energyOfChange <= share_ * radians * radians * elasticEnergy;
	}
	/// Whether a grain at rest bears, without being computed, that a force on it is not what it
	/// was when it fell asleep, N; `mass` is that of the grain.
	bool bears(double force, double mass, double elasticEnergy) const;
	/// After a further time dt; returns the time since the grain became calm, in periods.
	double count(bool calm, double dt)
	{
		calmTime_ = calm ? calmTime_ + dt : 0;
		watchedTime_ += dt;
		return calmTime_ / period_;
	}
	/// What comes together while a grain is calm tells whether something drives it. What is
	/// left of the motion before dies away meanwhile; so where that is too much it is watched
	/// anew, for as long as the grain has been calm until then.
	void watchFromNow() { watchedTime_ = 0; }
	bool isToBeWatchedAnew() const { return watchedTime_ >= 0.5 * calmTime_; }
	/// For a period at least, of the four and more that a grain is calm before it is asked.
	bool isWatchedForLong() const { return watchedTime_ >= 0.25 * calmTime_; }
	double watchedTime() const { return watchedTime_; } ///< s
	bool isAsleep() const { return asleep_; }
	void fallAsleep() { asleep_ = true; }
	void wake()
	{
		asleep_ = false;
		calmTime_ = 0;
	}

	double calmTime() const { return calmTime_; }
	void restore(double calmTime, double watchedTime, bool asleep)
	{
		calmTime_ = calmTime;
		watchedTime_ = watchedTime;
		asleep_ = asleep;
	}

private:
	double period_; ///< s
	double share_;  ///< kinetic over elastic energy up to which it is calm
	bool mayRest_;
	double calmTime_ = 0, watchedTime_ = 0; ///< s
	bool asleep_ = false;
};

} // namespace softgrain
