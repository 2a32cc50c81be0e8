#include "SoftGrainIntegrator.hpp"
#include "Engines.hpp"
#include "HighPressure.hpp"
#include "HostChecks.hpp"
#include "PeriodicCell.hpp"
#include "PushedWalls.hpp"
#include "PythonContactProblem.hpp"
#include "Require.hpp"
#include "RigidTimeStep.hpp"
#include "SceneAssembly.hpp"
#include "SoftBodies.hpp"
#include "Timing.hpp"

#include <limits>
#include <map>
#include <sstream>

namespace yade {

YADE_PLUGIN((SoftGrainIntegrator));

CREATE_LOGGER(SoftGrainIntegrator);

using softgrain::require;

namespace {

/// Relative rounding of the critical time step: how much a grain stiffens comes from the root of a
/// difference of large numbers, 1e-8 in an undeformed grain.
constexpr double timeStepRounding = 1e-6;

/// Up to how far O.dt is kept below its fraction of the critical step, over that fraction: it
/// changes seldom, since each change costs a little of the integrator's conservation of energy.
constexpr double lowestTimeStep = 0.7;

/// Steps in a row in which O.dt must have been shorter than that before it is raised, once it has
/// been lowered: some periods of a grain. Raised and lowered with each swing of a vibration, it
/// would feed that (doc/decisions/0003-time-step.md).
constexpr int stepsBeforeRaise = 1000;

/// Where O.dt is put anew, over that fraction. The nearer, the sooner the critical step falls below
/// it, and grains have to be measured: the first as long as that takes at most `worthMeasuring` of
/// the computations of forces that steps take, else the second (doc/decisions/0003-time-step.md,
/// with what else was tried).
constexpr double nearTimeStep = 0.99, roomyTimeStep = 0.9, worthMeasuring = 0.05;

/// Relative difference up to which O.dt is the value that sg set before the first step, which is
/// computed anew here.
constexpr double sameTimeStep = 1e-9;

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
	try {
		lastError = "";
		advance();
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
		lastError = message.str();
		throw std::runtime_error(lastError);
	} catch (const std::exception& e) {
		lastError = "SoftGrainIntegrator, step " + std::to_string(scene->iter) + ": " +
			    e.what();
		throw std::runtime_error(lastError);
	}
}

/// The assembly of the scene, in a scene of rigid bodies alone one without grains; false if there
/// is nothing to do.
bool SoftGrainIntegrator::assemble()
{
	rigidContacts_.list(*scene);
	const auto last = assembly_;
	const bool hadGrains = last && last->grains() > 0; // one more step tells that they are gone
	assembly_ = assembleScene(*scene, threads());
	if (!assembly_ && !rigidContacts_.hasLaw() && !hadGrains) {
		assembly_ = last; // sums go on from it
		return false;
	}
	if (!assembly_) {
		if (!withoutGrains_)
			withoutGrains_ = softgrain::GrainAssembly::createWithoutGrains();
		assembly_ = withoutGrains_;
	}
	// grains of the last assembly hand its sums on, but there may be none left, or none before
	if (last && last != assembly_) assembly_->continueFrom(last->continuation());
	checkEngineOrder(*scene, *this);
	SoftBodies(*scene, *assembly_).requireCarried(*newtonIntegratorOf(*scene));
	checkCell(*scene, *assembly_);
	const int unbounded = assembly_->host.unbounded;
	if (unbounded >= 0) checkBounds(*scene, unbounded);
	if (loaded_) continueSavedRun();
	assembly_->setMultirate(multirate);
	if (assembly_->setInterfaceRange(interfaceRange)) scene->doSort = true;
	return true;
}

/// One step. Whatever may be wrong is found before a grain moves, but for motions by hand, which
/// count once.
void SoftGrainIntegrator::advance()
{
	clock_.start(TimingInfo::enabled);
	postLoad(*this); // YADE keeps a value that was refused
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
	interactions.moveImages();
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
	if (bodies.needCollider(threads())) scene->doSort = true;
	clock_.end("callColliderIfNeeded");
	keepBooks(report);
	warnOfPressure();
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

/// A run that was loaded goes on with the sums and the step that were saved.
void SoftGrainIntegrator::continueSavedRun()
{
	loaded_ = false;
	if (assemblySteps == 0) return; // it has not run
	longestDt_ = scene->dt;
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

void SoftGrainIntegrator::followDeformation(Real undeformed, bool hasStepper)
{
	if (dtSet == 0 || (dtSet != scene->dt && !hasStepper))
		dtSet = std::min(timeStepFraction * undeformed, criticalDt);
	const bool tooShort = dtSet < lowestTimeStep * timeStepFraction * criticalDt;
	const bool isRaised = tooShort && stepsToRaise == 0;
	if (isRaised)
		measureCriticalStep(std::numeric_limits<Real>::infinity());
	else if (stepsToRaise > 0)
		stepsToRaise = tooShort ? stepsToRaise - 1 : stepsBeforeRaise;
	const Real limit = timeStepFraction * criticalDt;
	if (!isRaised && dtSet <= limit * (1 + timeStepRounding)) return;
	if (!isRaised) stepsToRaise = stepsBeforeRaise;
	const bool near = pointsMeasured <= worthMeasuring * pointsUpdated;
	dtSet = (near ? nearTimeStep : roomyTimeStep) * limit;
}

/// (To measure grains takes time: what matters is whether a step is stable.)
void SoftGrainIntegrator::measureCriticalStep(Real enough)
{
	criticalDt = assembly_->presentCriticalTimeStep(enough, threads());
	pointsMeasured += assembly_->takeMeasuredPoints();
}

/// Once: where rigid bodies touch by a stiffness that the step of the soft grains is too long for.
/// (It becomes longer where stiff grains go, or the first soft ones come.)
void SoftGrainIntegrator::warnOfStiffSpheres()
{
	if (warnedOfStiffness_ || scene->dt <= longestDt_) return;
	longestDt_ = scene->dt;
	const Real admissible = rigidTimeStep(*scene);
	if (scene->dt <= admissible) return;
	warnedOfStiffness_ = true;
	LOG_WARN("O.dt = " << scene->dt
			   << " s follows from the soft grains, but the stiffest rigid sphere asks "
			      "for less than "
			   << admissible
			   << " s, as utils.PWaveTimeStep() has it: where it touches another rigid "
			      "body both may fly apart. Assign O.dt, give it a lower young, or use "
			      "sg.engines(rigid='nonsmooth')");
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

/// O.dt follows the deformation as long as it is the value set here (or YADE's default, or what sg
/// set for the undeformed scene before the first step); a value of the user's is only checked.
void SoftGrainIntegrator::chooseTimeStep()
{
	if (assembly_->grains() == 0) {
		if (rigidContacts_.hasLaw() && scene->dt == defaultTimeStep())
			throw std::runtime_error(
				"O.dt is not set, and contact dynamics of rigid bodies alone has "
				"no critical time step: assign O.dt such that no body moves "
				"further than 0.05 of its radius in a step");
		require(scene->dt > 0 && math::isfinite(scene->dt), "O.dt", scene->dt,
			"(0, inf) s");
		return;
	}
	const Real undeformed = assembly_->criticalTimeStep();
	const Real own = dtSet > 0 ? dtSet : timeStepFraction * undeformed;
	const bool automatic = scene->dt == dtSet || scene->dt == defaultTimeStep() ||
			       std::abs(scene->dt - own) <= sameTimeStep * own;
	const bool hasStepper = hasTimeStepper(*scene);
	measureCriticalStep(automatic || hasStepper ? own / timeStepFraction : scene->dt);
	if (hasStepper) {
		const Real ofRigidBodies = scene->dt;
		followDeformation(undeformed, hasStepper);
		scene->dt = std::min(dtSet, ofRigidBodies);
	} else if (automatic) {
		followDeformation(undeformed, hasStepper);
		scene->dt = dtSet;
		warnOfStiffSpheres();
	} else if (!(scene->dt <= criticalDt * (1 + timeStepRounding) && scene->dt > 0)) {
		std::ostringstream message;
		message.precision(8); // tells numbers apart that differ by more than rounding
		message << "O.dt = " << scene->dt << " s is outside the admissible range (0, "
			<< criticalDt
			<< "] s for the soft grains as deformed and bonded now; assign a smaller "
			   "O.dt or call "
			   "sg.set_time_step()";
		throw std::runtime_error(message.str());
	}
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
	if (!lists.rigid.empty()) rigidEnergies = lists.rigid;
}

py::dict SoftGrainIntegrator::energyDict() const
{
	if (!Omega::instance().getScene()->trackEnergy)
		throw std::runtime_error("energy: O.trackEnergy = False, so that energies are not "
					 "known; admissible: True, before the steps that count");
	return namedEnergies({ energies, rigidEnergies });
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

Real criticalTimeStep(Scene& scene)
{
	const auto assembly = assembleScene(scene);
	return assembly ? assembly->criticalTimeStep() : 0;
}

} // namespace yade
