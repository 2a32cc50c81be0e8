#include "scene/StateChange.hpp"
#include "classes/SoftGrain.hpp"
#include "scene/Bodies.hpp"

namespace yade {

using softgrain::GrainMotion;
using softgrain::Mat3;
using softgrain::Rotation;
using softgrain::Vec3;

namespace {

/// What NewtonIntegrator's own sums leave between State and what was written, and more than that of
/// a user's change that is worth an answer: lengths over the radius, angles in rad.
constexpr Real lengthRounding = 1e-9, angleRounding = 1e-9;
/// Squared difference of quaternions within `angleRounding`.
constexpr Real quaternionRounding = 1e-19;
/// Over the distance from the origin and over the speed of the grain.
constexpr Real placeRounding = 1e-14, speedRounding = 1e-12;
/// Over the spin of the grain.
constexpr Real spinRounding = 1e-9;

/// A rotation within a step that is none, rad.
constexpr Real noTurn = 1e-16;

/// Of the norm of a quaternion that stands for a rotation.
constexpr Real unitRounding = 1e-6;

const SoftGrain& grainOf(const Body& body) { return static_cast<const SoftGrain&>(*body.shape); }

void refuseOutOfPlane(const Body& body, const string& what, const string& admissible)
{
	throw std::runtime_error("soft grain #" + std::to_string(body.getId()) + ": its State." +
				 what + " the plane of 2D grains; admissible: " + admissible);
}

void requireTurnInPlane(const Body& body, const Rotation& turn)
{
	if (turn.vec().head<2>().norm() > angleRounding)
		refuseOutOfPlane(body, "ori turns it out of", "turns about z");
}

bool isFinite(const State& state)
{
	return state.pos.allFinite() && state.vel.allFinite() && state.angVel.allFinite() &&
	       state.ori.coeffs().allFinite();
}

} // namespace

void requireMotion(const Body& body)
{
	const State& state = *body.state;
	for (const Vector3r& v : { state.pos, state.vel, state.angVel })
		if (!v.allFinite())
			throw std::runtime_error("soft grain #" + std::to_string(body.getId()) +
						 ": its State (pos, vel, angVel) holds a value "
						 "that is not finite; assign a finite one");
	softgrain::requireDigits(body.getId(), state.pos, grainOf(body).radius);
	const Real norm = state.ori.norm();
	if (!(std::abs(norm - 1) <= unitRounding))
		throw std::runtime_error("soft grain #" + std::to_string(body.getId()) +
					 ": its State.ori has the norm " + std::to_string(norm) +
					 "; admissible: 1, a rotation");
}

void requireFirstMotion(const Body& body)
{
	requireMotion(body);
	if (grainOf(body).dim == 2) requireTurnInPlane(body, body.state->ori);
}

void requireInPlane(const Body& body, const StateChange& change, Real dt)
{
	const SoftGrain& grain = grainOf(body);
	if (grain.dim == 3) return;
	const State& state = *body.state;
	requireTurnInPlane(body, change.turn);
	const Real length = lengthRounding * grain.radius;
	if (std::abs(change.shift.z()) > length)
		refuseOutOfPlane(body, "pos shifts it out of", "the z it has had");
	if (std::abs(state.vel.z()) * dt > length)
		refuseOutOfPlane(body, "vel leads out of", "vel[2] = 0");
	if (state.angVel.head<2>().norm() * dt > angleRounding)
		refuseOutOfPlane(body, "angVel turns it out of", "angVel[0] = angVel[1] = 0");
}

Placement stepBefore(const GrainMotion& motion, Real dt)
{
	const Real rate = motion.angularVelocity.norm();
	const Rotation turn =
		rate * dt > noTurn
			? Rotation(Eigen::AngleAxisd(-rate * dt, motion.angularVelocity / rate))
			: Rotation(Rotation::Identity());
	return { motion.position - dt * motion.velocity, turn * motion.orientation };
}

bool isBehind(const Body& body, Real dt)
{
	const State& state = *body.state;
	const Placement behind = stepBefore(grainOf(body).written, dt);
	return state.pos == behind.pos && state.ori.coeffs() == behind.ori.coeffs();
}

bool isAsWritten(const Body& body)
{
	const State& state = *body.state;
	const SoftGrain& grain = grainOf(body);
	const GrainMotion& written = grain.written;
	const Real length = lengthRounding * grain.radius;
	return state.vel == written.velocity && state.angVel == written.angularVelocity &&
	       (state.pos - written.position).squaredNorm() <= length * length &&
	       (state.ori.coeffs() - written.orientation.coeffs()).squaredNorm() <=
		       quaternionRounding;
}

StateChange changeOf(const Body& body)
{
	const State& state = *body.state;
	const SoftGrain& grain = grainOf(body);
	const GrainMotion& written = grain.written;
	const Rotation turn = state.ori * written.orientation.conjugate();
	StateChange change;
	change.centre = written.position;
	if (turn.vec().norm() > angleRounding) change.turn = turn;
	const Vec3 shift = state.pos - written.position;
	if (shift.norm() > lengthRounding * grain.radius + placeRounding * state.pos.norm())
		change.shift = shift;
	const Real speed = state.vel.norm(), rate = state.angVel.norm();
	const Vec3 velocity = state.vel - change.turn * written.velocity;
	if (velocity.norm() > speedRounding * speed) change.velocity = velocity;
	const Vec3 spin = state.angVel - change.turn * written.angularVelocity;
	if (spin.norm() > spinRounding * rate && spin.norm() * grain.radius > speedRounding * speed)
		change.spin = spin;
	return change;
}

StateChange shownChangeOf(const Body& body, Real lastStep)
{
	if (!isFinite(*body.state) || isBehind(body, lastStep)) return {};
	return changeOf(body);
}

bool StateChange::isNone() const
{
	return turn.vec().isZero(0) && shift.isZero(0) && velocity.isZero(0) && spin.isZero(0);
}

Vec3 StateChange::positionOf(const Vec3& x) const
{
	if (turn.vec().isZero(0)) return x + shift;
	return centre + turn * (x - centre) + shift;
}

std::vector<Vec3> StateChange::positionsOf(std::vector<Vec3> places) const
{
	for (Vec3& x : places)
		x = positionOf(x);
	return places;
}

Vec3 StateChange::velocityOf(const Vec3& x, const Vec3& v) const
{
	return turn * v + velocity + spin.cross(turn * (x - centre));
}

Mat3 StateChange::tensorOf(const Mat3& tensor) const
{
	const Mat3 R = turn.toRotationMatrix();
	return R * tensor * R.transpose();
}

Real StateChange::energyOf(const GrainMotion& written, const Mat3& inertia) const
{
	const Vec3 before = turn * written.velocity, spinBefore = turn * written.angularVelocity;
	return written.mass * (before + 0.5 * velocity).dot(velocity) +
	       (spinBefore + 0.5 * spin).dot(tensorOf(inertia) * spin);
}

} // namespace yade
