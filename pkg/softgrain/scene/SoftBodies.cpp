#include "scene/SoftBodies.hpp"
#include "Require.hpp"
#include "Threads.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/Bodies.hpp"
#include "scene/SceneAssembly.hpp"
#include "scene/StateChange.hpp"

#include <atomic>
#include <sstream>

namespace yade {

using softgrain::Vec3;

namespace {

/// How far a shift may be from whole periods, over the radius.
constexpr Real wrapTolerance = 1e-6;

/// 40 us of work: waking a thread for this pass, after a stretch on one, takes some 30.
constexpr int loadsPerThread = 2000;

/// Steps from one look for grains that overlap themselves to the next: so it takes 0.8 % of a step
/// of polygons.
constexpr long selfOverlapInterval = 20;

/// Outlines leave their boxes when they are as near to its sides as this, over the spacing of
/// material points, or as surfaces reach: contacts start before touch.
constexpr Real boxReserve = 0.1;

/// Nothing of it would act.
void requireGravityInPlane(const Vector3r& gravity, const SoftGrain& grain)
{
	if (grain.dim == 2)
		softgrain::require(gravity[2] == 0, "NewtonIntegrator.gravity[2]", gravity[2],
				   "0 m/s^2: 2D soft grains lie in a plane z = const");
}

bool isFinite(const softgrain::GrainLoad& load)
{
	return load.acceleration.allFinite() && load.angularAcceleration.allFinite();
}

} // namespace

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

void SoftBodies::stopOnSelfOverlap(Real maxOverlap, int threads) const
{
	if (assembly_.continuation().steps % selfOverlapInterval != 0) return;
	const int count = assembly_.grains();
	std::vector<Real> overlap(count);
#pragma omp parallel for schedule(static) num_threads(softgrain::threadsFor(count, threads))
	for (int g = 0; g < count; ++g)
		if (!assembly_.isRigid(g)) overlap[g] = assembly_.overlapWithItself(g);
	for (int g = 0; g < count; ++g) {
		if (overlap[g] <= maxOverlap) continue;
		std::ostringstream message;
		message << "soft grain #" << assembly_.idOf(g) << " overlaps itself by "
			<< overlap[g] << " point spacings, more than maxOverlap = " << maxOverlap
			<< ": contact of a grain with itself is not computed. Hint: make its arms "
			   "grains of their own, with a bond between them, or end the run before "
			   "they meet";
		throw std::runtime_error(message.str());
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
	requireMotion(body);
	assembly_.host.publishedAsleep[g] = false; // whatever becomes of it, State is written next
	if (isBehind(body, assembly_.continuation().lastStep)) {
		state.pos = grain.written.position;
		state.ori = grain.written.orientation;
	}
	StateChange change = changeOf(body);
	requireInPlane(body, change, scene_.dt);
	const auto image = change.shift.isZero(0) ? std::nullopt
						  : followWrap(scene_, body, change.shift,
							       wrapTolerance * grain.radius);
	if (image) { // State too: the flow's share in the load of this step is taken from it
		const Vec3 faster = flow.before(*image, comingVelGrad(scene_) * *image, scene_.dt);
		change.velocity += faster;
		state.vel += faster;
		state.pos += *image - change.shift;
		change.shift = *image;
	}
	if (change.isNone()) return false;
	assembly_.moveRigidly(g, change.turn, change.shift, change.velocity, change.spin);
	grain.written = assembly_.motion(g); // done, whatever becomes of the step
	return true;
}

void SoftBodies::applyLoads(const NewtonIntegrator& newton, const CellFlow& flow, int threads) const
{
	const SoftGrain* first =
		assembly_.grains() > 0 ? &grainOf(scene_, assembly_.idOf(0)) : nullptr;
	if (first) requireGravityInPlane(newton.gravity, *first);
	const bool isFlat = first && first->dim == 2;
	std::atomic<bool> finite { true }, inPlane { true };
	assembly_.setLoads(
		[&](int g) {
			const softgrain::GrainLoad load = loadOf(g, newton, flow);
			if (!isFinite(load)) finite = false;
			if (isFlat && !isLoadedInPlane(g)) inPlane = false;
			return load;
		},
		softgrain::threadsFor(assembly_.grains(), threads, loadsPerThread));
	if (!finite) refuseLoads(newton, flow);
	if (!inPlane) refuseLoadsAcrossPlane();
}

bool SoftBodies::isLoadedInPlane(int g) const
{
	const int id = assembly_.idOf(g);
	return scene_.forces.getForce(id)[2] == 0 &&
	       scene_.forces.getTorque(id).head<2>().isZero(0);
}

void SoftBodies::refuseLoadsAcrossPlane() const
{
	int g = 0;
	while (isLoadedInPlane(g))
		++g;
	const int id = assembly_.idOf(g);
	std::ostringstream message;
	message << "soft grain #" << id << ": O.forces across the plane of 2D grains (force "
		<< scene_.forces.getForce(id).transpose() << " N/m, torque "
		<< scene_.forces.getTorque(id).transpose()
		<< " N) would be lost; admissible: forces along x and y, torques about z";
	throw std::runtime_error(message.str());
}

void SoftBodies::refuseLoads(const NewtonIntegrator& newton, const CellFlow& flow) const
{
	int g = 0;
	while (isFinite(loadOf(g, newton, flow)))
		++g;
	const int id = assembly_.idOf(g);
	const bool isDisk = grainOf(scene_, id).dim == 2;
	std::ostringstream message;
	message << "soft grain #" << id
		<< ": its load is not finite; admissible are finite O.forces"
		<< " (force " << scene_.forces.getForce(id).transpose()
		<< (isDisk ? " N/m, torque " : " N, torque ")
		<< scene_.forces.getTorque(id).transpose() << (isDisk ? " N" : " N m")
		<< "), NewtonIntegrator.gravity (" << newton.gravity.transpose()
		<< " m/s^2) and O.cell.velGrad";
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
