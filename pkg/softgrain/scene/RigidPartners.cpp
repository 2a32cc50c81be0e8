#include "scene/RigidPartners.hpp"
#include "Require.hpp"
#include "scene/Bodies.hpp"

#include <cmath>

namespace yade {

using softgrain::Vec3;

namespace {

string rigidNameOf(const Body& body)
{
	return "rigid body #" + std::to_string(body.getId()) + " (" +
	       (body.shape ? body.shape->getClassName() : string("no shape")) + ")";
}

/// Whether forces change the motion that it gives to a body.
bool isFreeUnder(const Body& body, const NewtonIntegrator& newton)
{
	return isMoved(body, newton) && body.state->blockedDOFs != State::DOF_ALL;
}

bool isDampedBy(const NewtonIntegrator& newton, const Body& body)
{
	return newton.damping != 0 && body.state->isDamped;
}

void requireExactReactions(const Body& body, const NewtonIntegrator& newton)
{
	const State& state = *body.state;
	if (isDampedBy(newton, body))
		throw std::runtime_error(
			rigidNameOf(body) +
			" takes part in contact dynamics and is free, but NewtonIntegrator.damping "
			"= " +
			std::to_string(newton.damping) +
			" would damp the reactions; set NewtonIntegrator.damping = 0, or "
			"state.isDamped = False for this body");
	const bool translates = (state.blockedDOFs & State::DOF_XYZ) != State::DOF_XYZ,
		   turns = (state.blockedDOFs & State::DOF_RXRYRZ) != State::DOF_RXRYRZ;
	if (translates && !(state.mass > 0 && std::isfinite(state.mass)))
		softgrain::refuse(
			rigidNameOf(body) +
				" takes part in contact dynamics and is free to move: state.mass",
			state.mass, "(0, inf) kg");
	if (turns && dynamic_cast<const Wall*>(body.shape.get()))
		throw std::runtime_error(
			rigidNameOf(body) +
			" touches soft grains and is free to turn, which a Wall cannot; block "
			"'XYZ' in state.blockedDOFs, or use a Box");
	if (turns && !(state.inertia.minCoeff() > 0))
		throw std::runtime_error(rigidNameOf(body) +
					 " takes part in contact dynamics and is free to turn, but "
					 "state.inertia has a component that is not in (0, inf)");
}

/// All that acts on a body: what is in O.forces, and for a clump what acts on its members.
void forcesOn(const Body& body, Scene& scene, Vec3& force, Vec3& torque)
{
	force = scene.forces.getForce(body.getId());
	torque = scene.forces.getTorque(body.getId());
	if (body.isClump())
		static_cast<Clump&>(*body.shape)
			.addForceTorqueFromMembers(body.state.get(), &scene, force, torque);
}

/// The motion that a body has, with what the cell adds to it.
softgrain::RigidMotionDescription
undisturbedMotion(const Body& body, Real dt, const NewtonIntegrator& newton, const CellFlow& flow)
{
	const State& state = *body.state;
	softgrain::RigidMotionDescription d;
	d.centre = state.pos;
	d.velocity = d.freeVelocity = d.angularVelocity = d.freeAngularVelocity = Vec3::Zero();
	d.inverseMass.setZero();
	d.inverseInertia.setZero();
	if (isMoved(body, newton)) {
		d.velocity = d.freeVelocity = state.vel;
		d.angularVelocity = d.freeAngularVelocity = state.angVel;
		d.freeVelocity += flow.added(state.pos, state.vel, dt);
		d.freeAngularVelocity += flow.spinChange;
	}
	return d;
}

bool turnsAsAspherical(const Body& body, const NewtonIntegrator& newton)
{
	const bool freely = (body.state->blockedDOFs & State::DOF_RXRYRZ) == State::DOF_NONE;
	return newton.exactAsphericalRot && body.isAspherical() && freely;
}

/// In the axes of space, along which NewtonIntegrator takes the components of `inertia` where a
/// body does not turn as an aspherical one.
Matrix3r inverseInertia(const State& state, Real scaling, bool aspherical)
{
	if (aspherical) {
		const Matrix3r axes = state.ori.toRotationMatrix();
		return scaling * axes * state.inertia.cwiseInverse().asDiagonal() *
		       axes.transpose();
	}
	Matrix3r inverse = Matrix3r::Zero();
	for (int a = 0; a < 3; ++a)
		if (!(state.blockedDOFs & State::axisDOF(a, true)))
			inverse(a, a) = scaling / state.inertia[a];
	return inverse;
}

Vec3 gyroscopicTorque(const State& state)
{
	const Matrix3r axes = state.ori.toRotationMatrix();
	const Matrix3r inertia = axes * state.inertia.asDiagonal() * axes.transpose();
	return state.angVel.cross(inertia * state.angVel);
}

} // namespace

/// What NewtonIntegrator will make of a body in this step without contact dynamics.
softgrain::RigidMotionDescription RigidPartners::motionOf(const Body& body, Load& load) const
{
	const Real dt = scene_->dt;
	softgrain::RigidMotionDescription d = undisturbedMotion(body, dt, *newton_, flow_);
	if (!isFreeUnder(body, *newton_)) return d;
	requireExactReactions(body, *newton_);

	const State& state = *body.state;
	forcesOn(body, *scene_, load.force, load.torque);
	load.force += state.mass * newton_->gravity;
	const Real scaling = newton_->densityScaling ? state.densityScaling : 1;
	for (int a = 0; a < 3; ++a) {
		if (state.blockedDOFs & State::axisDOF(a, false)) continue;
		d.inverseMass[a] = scaling / state.mass;
		d.freeVelocity[a] += load.kick * d.inverseMass[a] * load.force[a];
	}
	const bool aspherical = turnsAsAspherical(body, *newton_);
	d.inverseInertia = inverseInertia(state, scaling, aspherical);
	d.freeAngularVelocity += load.kick * d.inverseInertia * load.torque;
	if (aspherical) {
		d.freeAngularVelocity -= dt * d.inverseInertia * gyroscopicTorque(state);
		d.freeAngularVelocity -= flow_.spinChange; // Newton's integrator leaves it out here
	}
	return d;
}

void RigidPartners::begin(Scene& scene, const NewtonIntegrator& newton, const CellFlow& flow,
			  Real kick)
{
	scene_ = &scene;
	newton_ = &newton;
	flow_ = flow;
	kick_ = kick;
	motions_.clear();
	loads_.clear();
	movers_.clear();
	numberOf_.assign(scene.bodies->size(), -1);
}

const Body& RigidPartners::moverOf(const Body& body) const
{
	return body.isClumpMember() ? *(*scene_->bodies)[body.clumpId] : body;
}

int RigidPartners::numberOfMover(const Body& mover, Real kick)
{
	int& number = numberOf_[mover.getId()];
	if (number < 0) {
		number = static_cast<int>(motions_.size());
		motions_.push_back(motionOf(mover, loads_.emplace_back(Load { kick })));
		movers_.push_back(mover.getId());
	}
	return number;
}

int RigidPartners::numberOf(const Body& body) { return numberOfMover(moverOf(body), kick_); }

void RigidPartners::addFreeBodies()
{
	for (const auto& body : *scene_->bodies)
		if (!body->isClumpMember() && isFree(*body) && !isDampedBy(*newton_, *body))
			numberOfMover(*body, scene_->dt);
}

bool RigidPartners::isFree(const Body& body) const { return isFreeUnder(moverOf(body), *newton_); }

bool RigidPartners::isHeld(int number) const
{
	return motions_[number].inverseMass.isZero(0) && motions_[number].inverseInertia.isZero(0);
}

void RigidPartners::publishLoads() const
{
	for (std::size_t k = 0; k < loads_.size(); ++k) {
		const Real besides = loads_[k].kick / scene_->dt - 1;
		if (besides == 0) continue;
		scene_->forces.addForce(movers_[k], besides * loads_[k].force);
		scene_->forces.addTorque(movers_[k], besides * loads_[k].torque);
	}
}

void RigidPartners::moveApart() const
{
	for (std::size_t k = 0; k < motions_.size(); ++k) {
		const Real angle = motions_[k].turn.norm();
		if (angle == 0 && motions_[k].shift.isZero(0)) continue;
		State& state = *(*scene_->bodies)[movers_[k]]->state;
		state.pos += motions_[k].shift;
		if (angle == 0) continue;
		state.ori = Quaternionr(AngleAxisr(angle, motions_[k].turn / angle)) * state.ori;
		state.ori.normalize();
	}
}

} // namespace yade
