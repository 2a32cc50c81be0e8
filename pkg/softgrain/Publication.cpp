// What SoftGrainIntegrator leaves behind after a step: forces, motions, figures, energies, the
// state that a save needs, a call for the collider.
#include "PeriodicCell.hpp"
#include "PythonContactProblem.hpp"
#include "SceneAssembly.hpp"
#include "SoftContact.hpp"
#include "SoftGrainIntegrator.hpp"
#include "Threads.hpp"
#include "Timing.hpp"

#include <array>
#include <cctype>
#include <map>

namespace yade {

using softgrain::Rotation;
using softgrain::Vec3;

namespace {

/// What functions of YADE that know pairs of spheres go by. `normal` from #1 to #2.
void describePair(const Scene& scene, const Interaction& I, const Vec3& normal, SoftGeom& geom)
{
	const Body &b1 = *(*scene.bodies)[I.getId1()], &b2 = *(*scene.bodies)[I.getId2()];
	const bool soft1 = isSoftGrain(b1), soft2 = isSoftGrain(b2);
	const Vec3 second = b2.state->pos + imageShift(scene, I);
	geom.normal = normal;
	if (soft1) geom.refR1 = std::max(0., normal.dot(geom.contactPoint - b1.state->pos));
	if (soft2) geom.refR2 = std::max(0., normal.dot(second - geom.contactPoint));
	if (soft1 && !soft2 && !YADE_PTR_DYN_CAST<Sphere>(b2.shape)) geom.refR2 = geom.refR1;
	if (soft2 && !soft1 && !YADE_PTR_DYN_CAST<Sphere>(b1.shape)) geom.refR1 = geom.refR2;
}

} // namespace

/// To the interactions in parallel, then to O.forces in the order of the interactions.
void SoftGrainIntegrator::publishForces(const std::vector<Interaction*>& interactions, Real kick)
{
	const long count = static_cast<long>(interactions.size());
#pragma omp parallel for schedule(static) num_threads(softgrain::threadsFor(count, threads()))
	for (long k = 0; k < count; ++k) {
		SoftGeom& geom = static_cast<SoftGeom&>(*interactions[k]->geom);
		SoftPhys& phys = static_cast<SoftPhys&>(*interactions[k]->phys);
		if (geom.pair->isKept()) continue; // it holds these forces already
		const softgrain::SumOfImpulses sum = geom.pair->impulse();
		const bool firstIsBody2 =
			assembly_->idOf(geom.pair->firstGrain()) == interactions[k]->getId2();
		const Real sign = firstIsBody2 ? 1 : -1,
			   onBody2 = sign / kick;                    // forces act on body #2
		if (sum.contacts > 0) geom.contactPoint = sum.point; // on the side of body #1
		if (firstIsBody2) geom.contactPoint += imageShift(*scene, *interactions[k]);
		phys.normalForce = onBody2 * sum.normal;
		phys.shearForce = onBody2 * sum.shear;
		phys.contacts = sum.contacts;
		phys.activeContacts = sum.active;
		if (!sum.direction.isZero(0))
			describePair(*scene, *interactions[k], sign * sum.direction, geom);
	}
	for (const Interaction* I : interactions) {
		const SoftPhys& phys = static_cast<const SoftPhys&>(*I->phys);
		if (static_cast<SoftGeom&>(*I->geom).pair->hasRigidBody()) {
			const Vector3r onGrain = phys.normalForce + phys.shearForce;
			const bool grainIsBody2 = rigidBodyOf(*I).getId() == I->getId1();
			scene->forces.addForce(grainIsBody2 ? I->getId2() : I->getId1(),
					       grainIsBody2 ? onGrain : Vector3r(-onGrain));
			publishReactions(*I, kick);
			continue;
		}
		const Vector3r force = phys.normalForce + phys.shearForce;
		scene->forces.addForce(I->getId2(), force);
		scene->forces.addForce(I->getId1(), -force);
	}
}

/// NewtonIntegrator, next, adds the flow of a periodic cell to vel and angVel, then vel dt to pos,
/// and turns ori by angVel dt; it lands on the grain.
void SoftGrainIntegrator::publishMotions()
{
	const Real dt = scene->dt;
	const int count = assembly_->grains();
	const CellFlow flow = cellFlow(*scene, newtonIntegrator());
#pragma omp parallel for schedule(static) num_threads(softgrain::threadsFor(count, threads()))
	for (int g = 0; g < count; ++g) {
		const Body& body = *(*scene->bodies)[assembly_->idOf(g)];
		SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
		const bool asleep = assembly_->isAsleep(g);
		if (asleep && grain.writtenAsleep) continue;
		grain.writtenAsleep = asleep;
		State& state = *body.state;
		softgrain::GrainMotion& written = grain.written;
		written = assembly_->motion(g);
		state.angVel = written.angularVelocity - flow.spinChange;
		state.mass = written.mass;
		state.inertia = Vector3r::Constant(written.inertia);
		state.pos = written.position - dt * written.velocity;
		state.vel = flow.before(state.pos, written.velocity, dt);
		const Real rate = written.angularVelocity.norm();
		const Rotation turn = rate * dt > 1e-16
					      ? Rotation(Eigen::AngleAxisd(
							-rate * dt, written.angularVelocity / rate))
					      : Rotation(Rotation::Identity());
		state.ori = turn * written.orientation;
	}
}

void SoftGrainIntegrator::publishReport(const softgrain::StepReport& report)
{
	contacts = report.solver.contacts;
	activeContacts = report.solver.active;
	sweeps = report.solver.sweeps;
	residual = report.solver.residual;
	largestResidual = std::max(largestResidual, residual);
	overlap = report.deepest;
	largestOverlap = std::max(largestOverlap, overlap);
	templates = assembly_->templates();
	activeGrains = report.activeGrains;
	sleepingGrains = report.sleepingGrains;
	droppedMomentum += report.droppedMomentum;
	droppedEnergy += report.droppedEnergy;
	lostBonds = report.lostBonds;
	totalGrainSteps += activeGrains;
	steps += 1;
	totalSweeps += sweeps;
	pointsUpdated += report.work.points;
	pairsSearched += report.work.pairs;
	candidatesTested += report.work.candidates;
	contactsSwept += report.work.visits;
	if (!report.solver.converged) cappedSteps += 1;
}

void SoftGrainIntegrator::publishTimes()
{
	for (const auto& entry : clock_.take())
		addTime(*timingDeltas, string(entry.phase), entry.nanoseconds, entry.count);
}

namespace {

constexpr std::array<const char*, 10> energyNames { "kinetic", "elastic", "friction", "impact",
						    "walls",   "loads",   "damping",  "sleep",
						    "cell",    "cohesion" };
constexpr std::array<const char*, 6> rigidEnergyNames { "rigidFriction", "rigidImpact",
							"rigidKinetic",  "rigidWalls",
							"rigidCell",     "rigidLoads" };
/// Of these O.energy has the first; YADE counts kinetic energy and gravity itself.
constexpr std::size_t rigidEnergiesForYade = 2;

} // namespace

void SoftGrainIntegrator::publishEnergy()
{
	const auto e = assembly_->energy();
	energies = { e.kinetic, e.elastic, e.friction, e.impact, e.planes,
		     e.loads,   e.damping, e.sleep,    e.cell,   e.cohesion };
	for (std::size_t k = 0; k < energies.size(); ++k) {
		string name = string("soft") + energyNames[k];
		name[4] = static_cast<char>(std::toupper(name[4]));
		scene->energy->set(energies[k], name, energyIds_[k]);
	}
	if (!tracksRigidBodies()) return;
	const softgrain::RigidBalance& r = e.rigid;
	rigidEnergies = { r.friction, r.impact, r.kinetic, r.walls, r.cell, r.loads };
	for (std::size_t k = 0; k < rigidEnergiesForYade; ++k)
		scene->energy->set(rigidEnergies[k], rigidEnergyNames[k],
				   energyIds_[energies.size() + k]);
}

py::dict SoftGrainIntegrator::energyDict() const
{
	py::dict d;
	for (std::size_t k = 0; k < energyNames.size(); ++k)
		d[energyNames[k]] = k < energies.size() ? energies[k] : 0.;
	for (std::size_t k = 0; k < rigidEnergies.size(); ++k)
		d[rigidEnergyNames[k]] = rigidEnergies[k];
	return d;
}

py::dict SoftGrainIntegrator::ratesDict() const
{
	std::map<int, int> grainsAt;
	for (int g = 0; assembly_ && g < assembly_->grains(); ++g)
		++grainsAt[assembly_->rate(g)];
	py::dict d;
	for (const auto& [rate, count] : grainsAt)
		d[rate] = count;
	return d;
}

py::dict SoftGrainIntegrator::contactProblem() const
{
	return softgrain::toDict(assembly_ ? assembly_->contactProblem()
					   : softgrain::ContactProblemArrays());
}

void SoftGrainIntegrator::saveContinuation()
{
	const auto state = assembly_->continuation();
	lastStep = state.lastStep;
	assemblySteps = state.steps;
	workSums = {
		state.sums.friction, state.sums.impact, state.sums.planes, state.sums.loads,
		state.sums.damping,  state.sums.sleep,  state.sums.cell,   state.sums.cohesion
	};
	bondRate = state.bondRate;
	const softgrain::RigidBalance& rigid = state.sums.rigid;
	rigidWorkSums = { rigid.friction, rigid.impact, rigid.walls, rigid.cell, rigid.loads };
}

/// The collider watches State.pos only; outlines that leave their boxes are watched here.
void SoftGrainIntegrator::callColliderIfNeeded() const
{
	for (int g = 0; g < assembly_->grains(); ++g) {
		if (assembly_->isAsleep(g)) continue; // inside as before
		const Body& body = *(*scene->bodies)[assembly_->idOf(g)];
		const SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
		if (!body.bound) continue;
		const double margin = 0.1 * assembly_->pointSpacing(g) +
				      interfaceRange; // contacts start before touch
		const softgrain::Box<3> box { body.bound->min, body.bound->max };
		if (scene->isPeriodic
			    ? !assembly_->isInside(g, box, margin, toBoxes(*scene, grain.boundCell))
			    : !assembly_->isInside(g, box, margin)) {
			scene->doSort = true;
			return;
		}
	}
}

} // namespace yade
