// What others did to the State of a soft grain since it was written there: a rigid motion, which
// the grain is given at the beginning of its next step, and is shown with until then.
#pragma once

#include "Yade.hpp"
#include "assembly/SpaceVectors.hpp"

#include <vector>

namespace softgrain {
struct GrainMotion;
}

namespace yade {

struct Placement {
	Vector3r pos;
	Quaternionr ori;
};

/// From where NewtonIntegrator lands on a motion in a step dt.
Placement stepBefore(const softgrain::GrainMotion& motion, Real dt);

/// Zero and the identity where State is as it was written, up to the rounding of NewtonIntegrator,
/// which adds vel dt to pos and turns ori.
struct StateChange {
	softgrain::Vec3 centre = softgrain::Vec3::Zero();           ///< of mass, as written, m
	softgrain::Rotation turn = softgrain::Rotation::Identity(); ///< about it, velocities, too
	softgrain::Vec3 shift = softgrain::Vec3::Zero();            ///< m
	softgrain::Vec3 velocity = softgrain::Vec3::Zero();         ///< added after the turn, m/s
	softgrain::Vec3 spin = softgrain::Vec3::Zero();             ///< the same, 1/s

	bool isNone() const;
	softgrain::Vec3 positionOf(const softgrain::Vec3& x) const;
	std::vector<softgrain::Vec3> positionsOf(std::vector<softgrain::Vec3> places) const;
	/// Of what is at x with the velocity v.
	softgrain::Vec3 velocityOf(const softgrain::Vec3& x, const softgrain::Vec3& v) const;
	softgrain::Mat3 tensorOf(const softgrain::Mat3& tensor) const;
	/// Kinetic energy it adds to a grain of this motion and inertia (axes of space), J.
	Real energyOf(const softgrain::GrainMotion& written, const softgrain::Mat3& inertia) const;
};

/// Throws std::runtime_error where State is no motion.
void requireMotion(const Body& body);
/// Of a soft grain that is not yet in an assembly: or turned out of the plane of 2D grains, which
/// would be built into the nodes.
void requireFirstMotion(const Body& body);
/// Of a change and the coming step dt of a 2D grain: what it would have besides its motion in the
/// plane would be lost.
void requireInPlane(const Body& body, const StateChange& change, Real dt);

/// Whether State is what was written: the usual case, told apart at little cost. False where a
/// value is not finite.
bool isAsWritten(const Body& body);

/// Of a State that is finite.
StateChange changeOf(const Body& body);

/// The same between any two engines of a step, as the last one, lastStep s long, left State; none
/// of a State that is not finite.
StateChange shownChangeOf(const Body& body, Real lastStep);

/// Where an engine stopped the last step, which was dt, before NewtonIntegrator, State is left
/// behind the grain: no motion of the user's.
bool isBehind(const Body& body, Real dt);

} // namespace yade
