#include "grain/RestWatch.hpp"

#include <numbers>

namespace softgrain {

namespace {

/// Kinetic over elastic energy up to which a grain is calm: forces are then balanced to its root.
constexpr double calmShare = 1e-8;

/// Of the force that would store the elastic energy, had the grain the stiffness of its slowest
/// vibration: ten times what trembles in grains that are calm.
constexpr double borneShare = 1e-3;

} // namespace

RestWatch::RestWatch(const Damping& damping, double slowest)
	: period_(slowest)
	, mayRest_(damping.acts())
{
	const double omega = 2 * std::numbers::pi / slowest;
	const double overdamped = 1 + damping.mass / omega + damping.stiffness * omega;
	share_ = calmShare / (overdamped * overdamped);
}

bool RestWatch::bears(double force, double mass, double elasticEnergy) const
{
	const double omega = 2 * std::numbers::pi / period_;
	const double scale = borneShare * omega;
	return force * force <= scale * scale * 2 * mass * elasticEnergy;
}

} // namespace softgrain
