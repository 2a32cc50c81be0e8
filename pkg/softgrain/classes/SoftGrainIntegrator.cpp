#include "classes/SoftGrainIntegrator.hpp"
#include "Require.hpp"
#include "checks/Engines.hpp"
#include "checks/HighPressure.hpp"
#include "checks/HostChecks.hpp"
#include "python/PythonContactProblem.hpp"
#include "scene/DrawnOutline.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/PushedWalls.hpp"
#include "scene/SceneAssembly.hpp"
#include "scene/SoftBodies.hpp"
#include "scene/Timing.hpp"

#include <limits>
#include <map>
#include <sstream>

namespace yade {

YADE_PLUGIN((SoftGrainIntegrator));

CREATE_LOGGER(SoftGrainIntegrator);

using softgrain::require;

namespace {

/// Steps from one look at pressures to the next, so that the stresses of one grain cost nothing.
constexpr long pressureInterval = 100;

} // namespace

void SoftGrainIntegrator::postLoad(SoftGrainIntegrator&)
{
	require(timeStepFraction > 0 && timeStepFraction <= 1, "timeStepFraction", timeStepFraction,
		"(0, 1]");
	require(tolerance > 0 && math::isfinite(tolerance), "tolerance", tolerance, "(0, inf)");
	require(maxSweeps >= 1, "maxSweeps", maxSweeps, "1, 2, ...");
	require(overlapRelaxation >= 0 && overlapRelaxation <= 1, "overlapRelaxation",
		overlapRelaxation, "[0, 1]");
	require(overlapSpeed >= 0, "overlapSpeed", overlapSpeed, "[0, inf]");
	require(interfaceRange >= 0 && math::isfinite(interfaceRange), "interfaceRange",
		interfaceRange, "[0, inf) m");
	require(maxOverlap > 0, "maxOverlap", maxOverlap, "(0, inf]");
}

void SoftGrainIntegrator::action()
{
	struct AtEnd {
		SoftGrainIntegrator& integrator;
		~AtEnd() { integrator.letAssemblyGo(); }
	} atEnd { *this };
	const StepBesideRenderers besideRenderers;
	try {
		lastError = "";
		advance();
		besideRenderers.leaveOutlines(*scene);
		publishedIn_ = scene->iter;
	} catch (const softgrain::StepError& e) {
		std::ostringstream message;
		message << "SoftGrainIntegrator, step " << scene->iter << ": soft grain #"
			<< assembly_->idOf(e.grain);
		if (e.point >= 0) message << ", material point " << e.point;
		message << ": " << e.what()
			<< ". Hint: load more slowly, reduce timeStepFraction (now "
			<< timeStepFraction
			<< "), refine the grain (smaller zeta), or, under pressures above young, "
			   "make it with nodeSpacing = 2.";
		fail(message.str());
	} catch (const std::exception& e) {
		fail("SoftGrainIntegrator, step " + std::to_string(scene->iter) + ": " + e.what());
	}
}

void SoftGrainIntegrator::fail(const std::string& message)
{
	lastError = message;
	takeBackPrologue(*scene);
	if (const auto assembly = assembly_ ? assembly_ : lastAssembly_.lock())
		assembly->forgetContactProblem();
	throw std::runtime_error(message);
}

void SoftGrainIntegrator::letAssemblyGo()
{
	if (assembly_) lastAssembly_ = assembly_;
	assembly_.reset();
}

/// The assembly of the scene, in a scene of rigid bodies alone one without grains; false if there
/// is nothing to do.
bool SoftGrainIntegrator::assemble()
{
	forgetOtherScene();
	rigidContacts_.list(*scene);
	const auto last = lastAssembly_.lock();
	assembly_ = assembleForStep(*scene, threads());
	// one more step tells that the grains are gone
	if (!assembly_ && !rigidContacts_.hasLaw() && !hadGrains_) return false;
	if (!assembly_) {
		if (!withoutGrains_)
			withoutGrains_ = softgrain::GrainAssembly::createWithoutGrains();
		assembly_ = withoutGrains_;
	}
	hadGrains_ = assembly_->grains() > 0;
	if (assembly_ != last) continueSums();
	checkEngineOrder(*scene, *this);
	collider_.followEngines(*scene);
	SoftBodies(*scene, *assembly_).requireCarried(*newtonIntegratorOf(*scene));
	checkCell(*scene, *assembly_);
	const int unbounded = assembly_->host.unbounded;
	if (unbounded >= 0) checkBounds(*scene, unbounded);
	assembly_->setMultirate(multirate);
	if (assembly_->setInterfaceRange(interfaceRange)) scene->doSort = true;
	return true;
}

/// One step. Whatever may be wrong is found before a grain moves, but for motions by hand, which
/// count once.
void SoftGrainIntegrator::advance()
{
	clock_.start(TimingInfo::enabled);
	scene->forces.sync(); // if the step is refused, what was not summed would count again
	postLoad(*this);      // YADE keeps a value that was refused
	holdWalls();
	if (!assemble()) return;
	clock_.end("assembleScene");
	const NewtonIntegrator& newton = *newtonIntegratorOf(*scene);
	const SoftBodies bodies(*scene, *assembly_);
	const CellFlow flow = cellFlow(*scene, newton);
	const auto moved = bodies.applyUserMotions(flow);
	clock_.end("applyUserMotions");
	assembly_->updateForces(threads());
	clock_.end("updateForces");
	chooseTimeStep();
	clock_.end("chooseTimeStep");
	const SoftInteractions interactions(*scene, assembly_, order_, moved);
	interactions.check(maxOverlap);
	bodies.stopOnSelfOverlap(maxOverlap, threads());
	interactions.updateVelocities(newton);
	clock_.end("softInteractions");
	bodies.applyLoads(newton, flow, threads());
	partners_.begin(*scene, newton, flow, assembly_->kickTime(scene->dt));
	interactions.numberPartners(partners_);
	rigidContacts_.describe(*scene, partners_, maxOverlap);
	if (tracksRigidBodies()) partners_.addFreeBodies();
	clock_.end("applyLoads");

	softgrain::StepSettings step = settings();
	step.moved = [&](int g) { bodies.publishMotion(g, flow); };
	const auto report = assembly_->step(step, interactions.pairs(), partners_.motions(),
					    rigidContacts_.descriptions());

	if (report.sleepingGrains > 0) bodies.publishSleepers(flow);
	const bool needed = bodies.needCollider(threads()) ||
			    (assembly_->host.hasPlates && isPlateOutsideItsBox(*scene, threads()));
	if (needed) scene->doSort = true;
	clock_.end("callColliderIfNeeded");
	keepBooks(report);
	warnOfPressure();
	warnOfOverlapsInCell();
	// last, for the shortest way from its threads to those of NewtonIntegrator: on a long one
	// they would fall asleep
	interactions.publish(partners_, threads());
	rigidContacts_.publish(*scene);
	partners_.publishLoads();
	partners_.moveApart();
	clock_.end("publishForces");
	publishTimes();
}

/// What is to be known of the step, and what a save needs of it.
void SoftGrainIntegrator::keepBooks(const softgrain::StepReport& report)
{
	publishReport(report);
	saveContinuation();
	clock_.end("publishReport");
	if (!scene->trackEnergy) return;
	publishEnergy();
	clock_.end("publishEnergy");
}

void SoftGrainIntegrator::holdWalls()
{
	for (const Body::id_t id : holdUnpushedWalls(*scene))
		LOG_WARN("step "
			 << scene->iter << ": body #" << id
			 << " is pushed by no WallStressController any more, and held from "
			    "now on (state.blockedDOFs, state.vel). Take what it needs to move "
			    "freely out of 'xyzXYZ'");
}

/// After O.reset() the last step and the sums of an engine that is used again are those of a scene
/// that is gone.
void SoftGrainIntegrator::forgetOtherScene()
{
	const bool isOther = ownScene_.isGone();
	ownScene_.enter();
	if (!isOther) return;
	lastAssembly_.reset();
	withoutGrains_.reset();
	lastStep = longestDt_ = 0;
	dtOfSpheres = -1;
	stepsToRaise = 0;
	steps = totalGrainSteps = totalSweeps = cappedSteps = 0;
	pointsUpdated = pointsMeasured = pairsSearched = candidatesTested = contactsSwept = 0;
	largestResidual = largestOverlap = 0;
	droppedMomentum = droppedEnergy = lostBonds = 0;
	warnedOfPressure_ = warnedOfOverlaps_ = hadSmallOverlaps_ = false;
	warnedOfStiffness_ = warnedOfCollapse_ = hadGrains_ = false;
	bodiesLookedAt_ = 0;
	softenedIn_ = publishedIn_ = -1;
	assemblySteps = 0;
	bondRate = 0;
	energies.clear();
	rigidEnergies.clear();
	workSums.clear();
	rigidWorkSums.clear();
	energyBooks_ = {};
}

/// A run that was loaded, or whose grains were assembled anew, goes on with its sums and its step.
void SoftGrainIntegrator::continueSums()
{
	if (assemblySteps == 0) return; // it has not run
	if (longestDt_ == 0) longestDt_ = scene->dt;
	softgrain::Continuation state;
	state.lastStep = lastStep;
	state.steps = assemblySteps;
	state.bondRate = bondRate;
	const bool complete = restoreSums({ workSums, rigidWorkSums }, state.sums);
	assembly_->continueFrom(state);
	if (!complete)
		throw std::runtime_error(
			"the sums of energies were saved with " + std::to_string(workSums.size()) +
			" and " + std::to_string(rigidWorkSums.size()) +
			" figures, by another version of softgrain? Those that cannot be read "
			"begin at 0 if you go on");
}

void SoftGrainIntegrator::saveContinuation()
{
	const auto state = assembly_->continuation();
	lastStep = state.lastStep;
	assemblySteps = state.steps;
	bondRate = state.bondRate;
	const EnergyLists sums = sumsOf(state.sums);
	workSums = sums.soft;
	rigidWorkSums = sums.rigid;
}

int SoftGrainIntegrator::threads() const
{
#ifdef YADE_OPENMP
	return ompThreads > 0 ? std::min(ompThreads, omp_get_max_threads()) : omp_get_max_threads();
#else
	return 1;
#endif
}

/// Once: grains stay pressed.
void SoftGrainIntegrator::warnOfPressure()
{
	if (warnedOfPressure_ || assemblySteps % pressureInterval != 0) return;
	const std::string message = highPressure(*scene, *assembly_);
	if (message.empty()) return;
	warnedOfPressure_ = true;
	LOG_WARN("step " << scene->iter << ": " << message);
}

/// Once, and not of what has overlapped from the start: a cell does not give way where bodies are
/// moved apart, and what of an overlap only a larger cell would end grows while forces and residual
/// look fine.
void SoftGrainIntegrator::warnOfOverlapsInCell()
{
	if (!scene->isPeriodic || warnedOfOverlaps_) return;
	// radii: what is moved apart keeps 1e-4, and a tenth stops the run
	constexpr Real small = 1e-3, large = 0.01;
	const Real deepest = rigidContacts_.deepestOverlap();
	hadSmallOverlaps_ = hadSmallOverlaps_ || deepest < small;
	if (!hadSmallOverlaps_ || deepest < large) return;
	warnedOfOverlaps_ = true;
	LOG_WARN("step " << scene->iter << ": rigid bodies overlap by " << deepest
			 << " of a radius in a periodic cell, which does not give way to that: the "
			    "packing becomes too dense while its forces look right. Hint: reduce "
			    "O.dt to a quarter (user guide, 'Overlaps')");
}

/// The balance of energies of rigid bodies is that of all contacts they have had, and of their
/// flight between them.
bool SoftGrainIntegrator::tracksRigidBodies() const
{
	return scene->trackEnergy && rigidContacts_.hasLaw();
}

softgrain::StepSettings SoftGrainIntegrator::settings()
{
	softgrain::StepSettings s;
	s.dt = scene->dt;
	s.solver.tolerance = tolerance;
	s.solver.maxSweeps = maxSweeps;
	s.solver.overlapRelaxation = overlapRelaxation;
	if (assembly_->grains() > 0)
		s.solver.overlapSpeed = overlapSpeed * assembly_->slowestWave();
	s.trackEnergy = scene->trackEnergy;
	s.trackRigidBodies = tracksRigidBodies();
	s.rigidMotion = rigidMotion;
	s.sleep = sleep && comingVelGrad(*scene).isZero(0);
	s.threads = threads();
	s.clock = &clock_;
	return s;
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
	droppedMomentum += report.dropped.momentum;
	droppedEnergy += report.dropped.energy;
	lostBonds += report.work.lostBonds;
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

void SoftGrainIntegrator::publishEnergy()
{
	const EnergyLists lists = energiesOf(assembly_->energy(), tracksRigidBodies());
	energyBooks_.publish(lists, *scene->energy);
	energies = lists.soft;
	rigidEnergies = lists.rigid;
}

py::dict SoftGrainIntegrator::energyDict() const
{
	if (!Omega::instance().getScene()->trackEnergy)
		throw std::runtime_error("energy: O.trackEnergy = False, so that energies are not "
					 "known; admissible: True, before the steps that count");
	return namedEnergies(ownScene_.isGone() ? EnergyLists()
						: EnergyLists { energies, rigidEnergies });
}

py::dict SoftGrainIntegrator::ratesDict() const
{
	std::map<int, int> grainsAt;
	const auto assembly = lastAssembly_.lock();
	for (int g = 0; assembly && g < assembly->grains(); ++g)
		++grainsAt[assembly->rate(g)];
	py::dict d;
	for (const auto& [rate, count] : grainsAt)
		d[rate] = count;
	return d;
}

py::dict SoftGrainIntegrator::contactProblem() const
{
	const auto assembly = lastAssembly_.lock();
	return softgrain::toDict(assembly ? assembly->contactProblem()
					  : softgrain::ContactProblemArrays());
}

} // namespace yade
