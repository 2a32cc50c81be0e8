#include "SoftBodies.hpp"
#include "Require.hpp"
#include "SceneAssembly.hpp"
#include "SoftGrain.hpp"
#include "SoftMat.hpp"
#include "Threads.hpp"

#include <atomic>
#include <sstream>

namespace yade {

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

/// How far a shift may be from whole periods, over the radius.
constexpr Real wrapTolerance = 1e-6;

/// Of the norm of a quaternion that stands for a rotation.
constexpr Real unitRounding = 1e-6;

/// A rotation within a step that is none, rad.
constexpr Real noTurn = 1e-16;

/// 40 us of work: waking a thread for this pass, after a stretch on one, takes some 30.
constexpr int loadsPerThread = 2000;

/// Outlines leave their boxes when they are as near to its sides as this, over the spacing of
/// material points, or as surfaces reach: contacts start before touch.
constexpr Real boxReserve = 0.1;

void requireMotion(const Body& body)
{
	const State& state = *body.state;
	for (const Vector3r& v : { state.pos, state.vel, state.angVel })
		if (!v.allFinite())
			throw std::runtime_error("soft grain #" + std::to_string(body.getId()) +
						 ": its State (pos, vel, angVel) holds a value "
						 "that is not finite; assign a finite one");
	softgrain::requireDigits(body.getId(), state.pos,
				 static_cast<const SoftGrain&>(*body.shape).radius);
	const Real norm = state.ori.norm();
	if (!(std::abs(norm - 1) <= unitRounding))
		throw std::runtime_error("soft grain #" + std::to_string(body.getId()) +
					 ": its State.ori has the norm " + std::to_string(norm) +
					 "; admissible: 1, a rotation");
}

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

/// Nothing of it would act.
void requireGravityInPlane(const Vector3r& gravity, const SoftGrain& grain)
{
	if (grain.dim == 2)
		softgrain::require(gravity[2] == 0, "NewtonIntegrator.gravity[2]", gravity[2],
				   "0 m/s^2: 2D soft grains lie in a plane z = const");
}

struct Placement {
	Vector3r pos;
	Quaternionr ori;
};

/// From where NewtonIntegrator lands on a motion.
Placement stepBefore(const softgrain::GrainMotion& motion, Real dt)
{
	const Real rate = motion.angularVelocity.norm();
	const Rotation turn =
		rate * dt > noTurn
			? Rotation(Eigen::AngleAxisd(-rate * dt, motion.angularVelocity / rate))
			: Rotation(Rotation::Identity());
	return { motion.position - dt * motion.velocity, turn * motion.orientation };
}

/// Where an engine stopped the last step, which was dt, before NewtonIntegrator, State is left
/// behind the grain: no motion of the user's.
void catchUp(State& state, const softgrain::GrainMotion& written, Real dt)
{
	const Placement behind = stepBefore(written, dt);
	if (state.pos != behind.pos || state.ori.coeffs() != behind.ori.coeffs()) return;
	state.pos = written.position;
	state.ori = written.orientation;
}

bool isFinite(const softgrain::GrainLoad& load)
{
	return load.acceleration.allFinite() && load.angularAcceleration.allFinite();
}

/// Of a 2D grain, in a step dt: what it would have besides its motion in the plane would be lost.
void requireInPlane(const Body& body, const Vec3& shift, const Rotation& turn, Real dt)
{
	const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
	if (grain.dim == 3) return;
	const State& state = *body.state;
	requireTurnInPlane(body, turn);
	const Real length = lengthRounding * grain.radius;
	if (std::abs(shift.z()) > length)
		refuseOutOfPlane(body, "pos shifts it out of", "the z it has had");
	if (std::abs(state.vel.z()) * dt > length)
		refuseOutOfPlane(body, "vel leads out of", "vel[2] = 0");
	if (state.angVel.head<2>().norm() * dt > angleRounding)
		refuseOutOfPlane(body, "angVel turns it out of", "angVel[0] = angVel[1] = 0");
}

} // namespace

void requireFirstMotion(const Body& body)
{
	requireMotion(body);
	if (static_cast<const SoftGrain&>(*body.shape).dim == 2)
		requireTurnInPlane(body, body.state->ori);
}

bool isAsWritten(const Body& body)
{
	const State& state = *body.state;
	const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
	const softgrain::GrainMotion& written = grain.written;
	const Real length = lengthRounding * grain.radius;
	return state.vel == written.velocity && state.angVel == written.angularVelocity &&
	       (state.pos - written.position).squaredNorm() <= length * length &&
	       (state.ori.coeffs() - written.orientation.coeffs()).squaredNorm() <=
		       quaternionRounding;
}

void SoftBodies::requireCarried(const NewtonIntegrator& newton) const
{
	if (newton.mask <= 0) return;
	for (int g = 0; g < assembly_.grains(); ++g) {
		const Body& body = *(*scene_.bodies)[assembly_.idOf(g)];
		if (isMoved(body, newton)) continue;
		throw std::runtime_error(
			"NewtonIntegrator.mask = " + std::to_string(newton.mask) +
			" leaves out soft grain #" + std::to_string(body.getId()) +
			" of mask = " + std::to_string(body.groupMask) +
			"; it carries State along: let masks have a bit in common");
	}
}

/// (assembleScene, which looks at all bodies in each step, has told which grains may be moved:
/// another pass would wait for memory again.)
std::set<int> SoftBodies::applyUserMotions(const CellFlow& flow) const
{
	std::set<int> moved;
	for (int g = 0; g < assembly_.grains(); ++g)
		if (assembly_.host.moved[g] && applyUserMotion(g, flow))
			moved.insert(assembly_.idOf(g));
	return moved;
}

/// Whether there was a motion.
bool SoftBodies::applyUserMotion(int g, const CellFlow& flow) const
{
	const Body& body = *(*scene_.bodies)[assembly_.idOf(g)];
	State& state = *body.state;
	SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
	const softgrain::GrainMotion written = grain.written;
	const Real radius = grain.radius;
	requireMotion(body);
	assembly_.host.publishedAsleep[g] = false; // whatever becomes of it, State is written next
	catchUp(state, written, assembly_.continuation().lastStep);
	Vec3 shift = state.pos - written.position;
	Rotation turn = state.ori * written.orientation.conjugate();
	requireInPlane(body, shift, turn, scene_.dt);
	const bool turned = turn.vec().norm() > angleRounding;
	if (!turned) turn.setIdentity();
	// what a turn of the whole grain, velocities included, does not bring along
	Vec3 velocity = state.vel - turn * written.velocity;
	const Vec3 spin = state.angVel - turn * written.angularVelocity;
	const bool moved =
		shift.norm() > lengthRounding * radius + placeRounding * state.pos.norm();
	const auto image =
		moved ? followWrap(scene_, body, shift, wrapTolerance * radius) : std::nullopt;
	if (image) { // State too: the flow's share in the load of this step is taken from it
		const Vec3 faster = flow.before(*image, comingVelGrad(scene_) * *image, scene_.dt);
		velocity += faster;
		state.vel += faster;
		state.pos += *image - shift;
		shift = *image;
	}
	const bool pushed = velocity.norm() > speedRounding * state.vel.norm();
	const bool spun = spin.norm() > spinRounding * state.angVel.norm() &&
			  spin.norm() * radius > speedRounding * state.vel.norm();
	if (!moved && !turned && !pushed && !spun) return false;
	assembly_.moveRigidly(g, turn, moved ? shift : Vec3(Vec3::Zero()),
			      pushed ? velocity : Vec3(Vec3::Zero()),
			      spun ? spin : Vec3(Vec3::Zero()));
	grain.written = assembly_.motion(g); // done, whatever becomes of the step
	return true;
}

void SoftBodies::applyLoads(const NewtonIntegrator& newton, const CellFlow& flow, int threads) const
{
	scene_.forces.sync();
	if (assembly_.grains() > 0)
		requireGravityInPlane(newton.gravity, grainOf(scene_, assembly_.idOf(0)));
	std::atomic<bool> finite { true };
	assembly_.setLoads(
		[&](int g) {
			const softgrain::GrainLoad load = loadOf(g, newton, flow);
			if (!isFinite(load)) finite = false;
			return load;
		},
		softgrain::threadsFor(assembly_.grains(), threads, loadsPerThread));
	if (!finite) refuseLoads(newton, flow);
}

void SoftBodies::refuseLoads(const NewtonIntegrator& newton, const CellFlow& flow) const
{
	int g = 0;
	while (isFinite(loadOf(g, newton, flow)))
		++g;
	const int id = assembly_.idOf(g);
	std::ostringstream message;
	message << "soft grain #" << id
		<< ": its load is not finite; admissible are finite O.forces"
		<< " (force " << scene_.forces.getForce(id).transpose() << " N, torque "
		<< scene_.forces.getTorque(id).transpose() << " N m), NewtonIntegrator.gravity ("
		<< newton.gravity.transpose() << " m/s^2) and O.cell.velGrad";
	throw std::runtime_error(message.str());
}

softgrain::GrainLoad SoftBodies::loadOf(int g, const NewtonIntegrator& newton,
					const CellFlow& flow) const
{
	const int id = assembly_.idOf(g);
	const Vector3r& force = scene_.forces.getForce(id);
	const Vector3r& torque = scene_.forces.getTorque(id);
	softgrain::GrainLoad load;
	if (!force.isZero(0) || !torque.isZero(0)) load = assembly_.load(g, force, torque);
	if (!newton.gravity.isZero(0))
		load.acceleration += newton.gravity / materialOf(scene_, id).massScaling;
	if (!flow.isZero()) {
		const State& state = *(*scene_.bodies)[id]->state;
		const Real dt = scene_.dt, kick = assembly_.kickTime(dt);
		load.acceleration += flow.added(state.pos, state.vel, dt) / kick;
		load.angularAcceleration += flow.spinChange / kick;
	}
	return load;
}

void SoftBodies::publishSleepers(const CellFlow& flow) const
{
	for (int g = 0; g < assembly_.grains(); ++g)
		if (!assembly_.host.publishedAsleep[g] && assembly_.isAsleep(g))
			publishMotion(g, flow);
}

void SoftBodies::publishMotion(int g, const CellFlow& flow) const
{
	const Body& body = *(*scene_.bodies)[assembly_.idOf(g)];
	const Real dt = scene_.dt;
	State& state = *body.state;
	assembly_.host.publishedAsleep[g] = assembly_.isAsleep(g);
	softgrain::GrainMotion& written = static_cast<SoftGrain&>(*body.shape).written;
	written = assembly_.motion(g);
	state.angVel = written.angularVelocity - flow.spinChange;
	state.mass = written.mass;
	state.inertia = Vector3r::Constant(written.inertia);
	const Placement before = stepBefore(written, dt);
	state.pos = before.pos;
	state.vel = flow.before(state.pos, written.velocity, dt);
	state.ori = before.ori;
}

namespace {

/// How near the outline of a grain may come to the sides of its box before the collider is called,
/// m.
Real reserveOfBox(const softgrain::GrainAssembly& assembly, int g)
{
	return std::max(boxReserve * assembly.pointSpacing(g), assembly.reachAtRest(g));
}

} // namespace

/// (With as much as the reserve alone, the collider would run in every step.)
Real roomInBox(const softgrain::GrainAssembly& assembly, int g, Real margin)
{
	const Real least = boxReserve * assembly.pointSpacing(g);
	return reserveOfBox(assembly, g) + std::max(margin - least, least);
}

/// (A grain that sleeps is where it was, unless it was put there in this step.)
bool SoftBodies::mayHaveMoved(int g) const
{
	return !assembly_.host.publishedAsleep[g] || assembly_.host.moved[g];
}

bool SoftBodies::needCollider(int threads) const
{
	const int count = assembly_.grains();
	bool needed = false;
#pragma omp parallel for schedule(static) reduction(|| : needed)                                   \
	num_threads(softgrain::threadsFor(count, threads))
	for (int g = 0; g < count; ++g)
		needed = needed || (mayHaveMoved(g) && !isInItsBox(g));
	return needed;
}

bool SoftBodies::isInItsBox(int g) const
{
	const Body& body = *(*scene_.bodies)[assembly_.idOf(g)];
	if (!body.bound) return true;
	const Real margin = reserveOfBox(assembly_, g);
	const softgrain::Box<3> box { body.bound->min, body.bound->max };
	if (!scene_.isPeriodic) return assembly_.isInside(g, box, margin);
	const SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
	return assembly_.isInside(g, box, margin, toBoxes(scene_, grain.boundCell));
}

} // namespace yade
