// Rigid bodies in the contacts of a step: what NewtonIntegrator will do with them, and the
// reactions that it is to do it with.
#include "PeriodicCell.hpp"
#include "SceneAssembly.hpp"
#include "SoftContact.hpp"
#include "SoftGrainIntegrator.hpp"

namespace yade {

using softgrain::Vec3;

namespace {

string nameOf(const Body& body)
{
	return "rigid body #" + std::to_string(body.getId()) + " (" +
	       (body.shape ? body.shape->getClassName() : string("no shape")) + ")";
}

/// Whether NewtonIntegrator moves a body.
bool isMoved(const Body& body, const NewtonIntegrator& newton)
{
	return newton.mask <= 0 || body.maskCompatible(newton.mask);
}

/// Whether forces change the motion of a body.
bool isFree(const Body& body, const NewtonIntegrator& newton)
{
	return isMoved(body, newton) && body.state->blockedDOFs != State::DOF_ALL;
}

void requireExactReactions(const Body& body, const NewtonIntegrator& newton)
{
	const State& state = *body.state;
	if (newton.damping != 0 && state.isDamped)
		throw std::runtime_error(
			nameOf(body) +
			" takes part in contact dynamics and is free, but NewtonIntegrator.damping "
			"= " +
			std::to_string(newton.damping) +
			" would damp the reactions; set NewtonIntegrator.damping = 0, or "
			"state.isDamped = False for this body");
	const bool translates = (state.blockedDOFs & State::DOF_XYZ) != State::DOF_XYZ,
		   turns = (state.blockedDOFs & State::DOF_RXRYRZ) != State::DOF_RXRYRZ;
	if (translates && !(state.mass > 0))
		throw std::runtime_error(
			nameOf(body) +
			" takes part in contact dynamics and is free to move, but state.mass = " +
			std::to_string(state.mass) + "; admissible: (0, inf) kg");
	if (turns && dynamic_cast<const Wall*>(body.shape.get()))
		throw std::runtime_error(
			nameOf(body) +
			" touches soft grains and is free to turn, which a Wall cannot; block "
			"'XYZ' in state.blockedDOFs, or use a Box");
	if (turns && !(state.inertia.minCoeff() > 0))
		throw std::runtime_error(nameOf(body) +
					 " takes part in contact dynamics and is free to turn, but "
					 "state.inertia has a component that is not in (0, inf)");
}

/// All that acts on a body: what is in O.forces, and for a clump what acts on its members.
void addForces(const Body& body, Scene& scene, Vec3& force, Vec3& torque)
{
	force = scene.forces.getForce(body.getId());
	torque = scene.forces.getTorque(body.getId());
	if (body.isClump())
		static_cast<Clump&>(*body.shape)
			.addForceTorqueFromMembers(body.state.get(), &scene, force, torque);
}

/// What NewtonIntegrator would make of a body in this step without contact dynamics.
softgrain::RigidMotionDescription motionOf(const Body& body, Scene& scene,
					   const NewtonIntegrator& newton, const CellFlow& flow)
{
	const State& state = *body.state;
	softgrain::RigidMotionDescription d;
	d.centre = state.pos;
	d.velocity = d.freeVelocity = state.vel;
	d.angularVelocity = d.freeAngularVelocity = state.angVel;
	d.inverseMass.setZero();
	d.inverseInertia.setZero();
	if (isMoved(body, newton)) {
		d.freeVelocity += flow.added(state.pos, state.vel, scene.dt);
		d.freeAngularVelocity += flow.spinChange;
	}
	if (!isFree(body, newton)) return d;
	requireExactReactions(body, newton);

	Vec3 force, torque;
	addForces(body, scene, force, torque);
	const Real scaling = newton.densityScaling ? state.densityScaling : 1;
	for (int a = 0; a < 3; ++a) {
		if (state.blockedDOFs & State::axisDOF(a, false)) continue;
		d.inverseMass[a] = scaling / state.mass;
		d.freeVelocity[a] +=
			scene.dt * scaling * (force[a] / state.mass + newton.gravity[a]);
	}
	const bool turnsFreely = (state.blockedDOFs & State::DOF_RXRYRZ) == State::DOF_NONE;
	if (newton.exactAsphericalRot && body.isAspherical() && turnsFreely) {
		const Matrix3r axes = state.ori.toRotationMatrix();
		const Matrix3r inertia = axes * state.inertia.asDiagonal() * axes.transpose();
		d.inverseInertia = scaling * axes * state.inertia.cwiseInverse().asDiagonal() *
				   axes.transpose();
		torque -= state.angVel.cross(inertia * state.angVel);
		d.freeAngularVelocity -= flow.spinChange; // Newton's integrator leaves it out here
	} else // as NewtonIntegrator has it: components of inertia along the axes of space
		for (int a = 0; a < 3; ++a)
			if (!(state.blockedDOFs & State::axisDOF(a, true)))
				d.inverseInertia(a, a) = scaling / state.inertia[a];
	d.freeAngularVelocity += scene.dt * d.inverseInertia * torque;
	return d;
}

/// Change of the force on a wall over the way that it moves within a step, for engines that choose
/// that way (doc/decisions/0023-laboratory-loading.md): a wave gets no further than c dt by then,
/// so it is rho c A/dt, tens of times what a grain as a whole resists with.
Real stiffnessWithinStep(const SoftGrain& grain, const Scene& scene)
{
	const SoftMat& material = materialOf(scene, grain.assembly->idOf(grain.index));
	const auto constants = material.constants();
	const Real impedance = constants.density * constants.waveSpeed(grain.condition(material));
	const Real diameter = 2 * grain.radius;
	return impedance * (grain.dim == 2 ? diameter : diameter * diameter) / scene.dt;
}

/// The body whose motion is that of a rigid body: itself, or its clump.
const Body& moverOf(const Body& body, const Scene& scene)
{
	return body.isClumpMember() ? *(*scene.bodies)[body.clumpId] : body;
}

} // namespace

const Body& SoftGrainIntegrator::rigidBodyOf(const Interaction& I) const
{
	const auto &b1 = (*scene->bodies)[I.getId1()], &b2 = (*scene->bodies)[I.getId2()];
	return YADE_PTR_DYN_CAST<SoftGrain>(b1->shape) ? *b2 : *b1;
}

const SoftGrain& SoftGrainIntegrator::softGrainOf(const Interaction& I) const
{
	const Body::id_t rigid = rigidBodyOf(I).getId();
	return grainOf(*scene, I.getId1() == rigid ? I.getId2() : I.getId1());
}

/// Numbers the rigid bodies in contact; O.forces hold all that else acts on them.
void SoftGrainIntegrator::describeRigidBodies(const std::vector<Interaction*>& interactions)
{
	partners_.clear();
	movers_.clear();
	numberOf_.assign(scene->bodies->size(), -1);
	newton_ = &newtonIntegrator();
	flow_ = cellFlow(*scene, *newton_);
	for (const Interaction* I : interactions) {
		softgrain::PairContacts& pair = *static_cast<SoftGeom&>(*I->geom).pair;
		if (pair.hasRigidBody()) pair.setPartner(numberOf(rigidBodyOf(*I)));
	}
	describeRigidContacts();
	if (tracksRigidBodies()) describeFreeBodies();
}

/// The balance of energies of rigid bodies is that of all contacts they have had, and of their
/// flight between them.
bool SoftGrainIntegrator::tracksRigidBodies() const { return scene->trackEnergy && nonsmooth_; }

void SoftGrainIntegrator::describeFreeBodies()
{
	for (const auto& body : *scene->bodies)
		if (body && !body->isClumpMember() && isFree(*body, *newton_)) numberOf(*body);
}

/// Number of the motion of a body in the step at hand, described when first asked for.
int SoftGrainIntegrator::numberOf(const Body& body)
{
	const Body& mover = moverOf(body, *scene);
	int& number = numberOf_[mover.getId()];
	if (number < 0) {
		number = static_cast<int>(partners_.size());
		partners_.push_back(motionOf(mover, *scene, *newton_, flow_));
		movers_.push_back(mover.getId());
	}
	return number;
}

/// Bodies that soft grains cannot touch as they stand.
void SoftGrainIntegrator::checkRigidBodies(const std::vector<Interaction*>& interactions) const
{
	for (const Interaction* I : interactions) {
		const softgrain::PairContacts& pair = *static_cast<SoftGeom&>(*I->geom).pair;
		if (!pair.hasRigidBody()) continue;
		const Body& body = rigidBodyOf(*I);
		const auto described =
			describeRigid(*body.shape, *body.state, body.getId(), softGrainOf(*I));
		if (described) assembly_->checkRigidBody(*described);
	}
}

/// A free body is to get the impulse itself, which NewtonIntegrator makes of a force in the step
/// dt; on others it is the mean force of the step.
void SoftGrainIntegrator::publishReactions(const Interaction& I, Real kick)
{
	const softgrain::PairContacts& pair = *static_cast<SoftGeom&>(*I.geom).pair;
	const softgrain::SumOfImpulses sum = pair.impulse();
	const Body& body = rigidBodyOf(I);
	const bool free = isFree(moverOf(body, *scene), *newton_);
	SoftPhys& phys = static_cast<SoftPhys&>(*I.phys);
	phys.kn = phys.ks = free ? 0 : stiffnessWithinStep(softGrainOf(I), *scene);
	if (sum.active == 0) return;
	const Real time = free ? scene->dt : kick;
	scene->forces.addForce(body.getId(), -(sum.normal + sum.shear) / time);
	if (!YADE_PTR_DYN_CAST<Wall>(body.shape)) // which has no place, and cannot turn
		scene->forces.addTorque(body.getId(), sum.moment / time);
}

} // namespace yade
