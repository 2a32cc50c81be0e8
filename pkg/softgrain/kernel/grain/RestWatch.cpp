#include "grain/RestWatch.hpp"

#include <numbers>

namespace softgrain {

namespace {

/// Kinetic over elastic energy up to which a grain is calm: forces are then balanced to its root.
constexpr double calmShare = 1e-8;

} // namespace

RestWatch::RestWatch(const Damping& damping, double slowest)
	: period_(slowest)
	, mayRest_(damping.acts())
{
	const double omega = 2 * std::numbers::pi / slowest;
	const double overdamped = 1 + damping.mass / omega + damping.stiffness * omega;
	share_ = calmShare / (overdamped * overdamped);
}

} // namespace softgrain
