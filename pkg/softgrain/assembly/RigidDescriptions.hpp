// What the kernel is told of walls and rigid bodies, in three dimensions.
#pragma once

#include "assembly/SpaceVectors.hpp"

#include <array>

namespace softgrain {

/// A rigid plane wall with prescribed motion.
struct WallDescription {
	int id; ///< of the YADE body
	Vec3 point, normal, velocity;
};

/// Surface of a rigid body with its motion. In 2D: a disk, the segment in which a triangle cuts the
/// plane of the grains, a rectangle.
struct RigidBodyDescription {
	enum class Form { ball, plate, block };
	int id; ///< of the YADE body with this surface
	Form form;
	Vec3 position, velocity, angularVelocity;
	Vec3 pivot; ///< the place that has this velocity, and that moments are about, m
	Rotation orientation;
	Vec3 size;                  ///< of a ball: the radius; of a block: half sides, m
	std::array<Vec3, 3> corner; ///< of a plate, in space
};

/// How a grain sees its partner in a periodic cell: displaced by a period, and moving with the
/// cell.
struct ImageDescription {
	Vec3 shift = Vec3::Zero();    ///< from the partner to its image, m
	Vec3 velocity = Vec3::Zero(); ///< of the shift, m/s
};

/// A rigid body in the contacts of a step: what it weighs and how it moves.
struct RigidMotionDescription {
	Vec3 centre;                            ///< of mass, m
	Vec3 velocity, angularVelocity;         ///< half a step ago
	Vec3 freeVelocity, freeAngularVelocity; ///< in half a step, without contact
	Vec3 inverseMass;                       ///< along each axis of space, 1/kg; 0: held
	Mat3 inverseInertia;                    ///< in the axes of space, 1/(kg m^2); 0: held
	/// By the step: out of overlaps with other rigid bodies, besides the motion, m and rad.
	Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
};

/// Two rigid bodies where they touch, or may in the coming step.
struct RigidContactDescription {
	int first, second;      ///< numbers of their RigidMotionDescription
	Vec3 point, normal;     ///< m; unit, from the first to the second
	double gap;             ///< m, negative for an overlap
	double size;            ///< what the spacing of material points is to soft grains, m
	double friction;        ///< mu
	double restitution;     ///< e
	Vec3 impulse;           ///< on the second, N s: the last one, after a step the solved one
	ImageDescription image; ///< of the second, which the first touches
};

} // namespace softgrain
