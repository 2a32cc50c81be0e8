// O.dt of soft grains: what SoftGrainIntegrator keeps it at as they deform.
#include "Require.hpp"
#include "checks/Engines.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "scene/HostTimeStep.hpp"
#include "scene/SceneAssembly.hpp"

#include <limits>
#include <sstream>

namespace yade {

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

/// From this share of the limit on measuring is so frequent that O.dt leaves it, where it has taken
/// more than `dearMeasuring` of what steps took, and so many computations of points (some tenths of
/// a second): balls that touch are measured all the time.
constexpr double leftTimeStep = 0.98, dearMeasuring = 0.25, dearPoints = 1e7;

/// Below this share of that of the undeformed grains the critical step is worth a warning: a run
/// that goes on so hardly ends. A disk under twice its young has a tenth, without folds.
constexpr double collapsedStep = 0.01;

/// Below this share a run does not end at all: the steps of a point that collapses shorten faster
/// than it does.
constexpr double lostStep = 1e-6;

/// Relative difference up to which O.dt is the value that sg set before the first step, which is
/// computed anew here.
constexpr double sameTimeStep = 1e-9;

/// Names the point that is crushed most.
string messageOfLostStep(const softgrain::GrainAssembly& grains, Real criticalDt)
{
	Real smallest = std::numeric_limits<Real>::infinity();
	int crushed = 0;
	std::size_t point = 0;
	for (int g = 0; g < grains.grains(); ++g) {
		const auto F = grains.points(g).F;
		for (std::size_t p = 0; p < F.size(); ++p) {
			const Real J = F[p].determinant();
			if (!(J < smallest)) continue;
			smallest = J;
			crushed = g;
			point = p;
		}
	}
	std::ostringstream message;
	message << "soft grain #" << grains.idOf(crushed) << ", material point " << point
		<< ": its volume has collapsed to " << smallest
		<< " of what it was, and the critical time step with it, to " << criticalDt
		<< " s, so that the run does not get on. Hint: load more slowly, or less, refine "
		   "the grain (smaller zeta), or make it with nodeSpacing = 2; a grain that "
		   "several walls close in on with friction locks between them (user guide, "
		   "'Friction')";
	return message.str();
}

} // namespace

void SoftGrainIntegrator::followDeformation(Real undeformed, bool hasStepper)
{
	if (dtSet == 0 || (dtSet != scene->dt && !hasStepper))
		dtSet = std::min(timeStepFraction * undeformed, criticalDt);
	const Real besideSpheres = longestBesideSpheres();
	auto longest = [&] { return std::min(timeStepFraction * criticalDt, besideSpheres); };
	const bool tooShort = dtSet < lowestTimeStep * longest();
	const bool isRaised = tooShort && stepsToRaise == 0;
	if (isRaised)
		measureCriticalStep(std::numeric_limits<Real>::infinity());
	else if (stepsToRaise > 0)
		stepsToRaise = tooShort ? stepsToRaise - 1 : stepsBeforeRaise;
	const Real limit = longest();
	const bool isDear = dtSet > leftTimeStep * limit &&
			    pointsMeasured > std::max(dearPoints, dearMeasuring * pointsUpdated);
	if (!isRaised && !isDear && dtSet <= limit * (1 + timeStepRounding)) return;
	if (!isRaised) stepsToRaise = stepsBeforeRaise;
	const bool near = pointsMeasured <= worthMeasuring * pointsUpdated;
	dtSet = (near ? nearTimeStep : roomyTimeStep) * limit;
}

/// For rigid spheres beside those that turned soft: the step of the script, or what is usual for
/// the spheres that are left. They go on as before. (The force that turned the last of them was
/// found for their step, acts for the one at hand, and is gone in the next.)
Real SoftGrainIntegrator::longestBesideSpheres() const
{
	// of utils.PWaveTimeStep(), with which a column of stiff spheres on a soft grain stands
	constexpr Real usualShare = 0.3;
	if (dtOfSpheres < 0) return std::numeric_limits<Real>::infinity();
	if (softenedIn_ == scene->iter) return scene->dt;
	return std::max(dtOfSpheres, usualShare * rigidTimeStep(*scene));
}

/// (To measure grains takes time: what matters is whether a step is stable.)
void SoftGrainIntegrator::measureCriticalStep(Real enough)
{
	criticalDt = assembly_->presentCriticalTimeStep(enough, threads());
	pointsMeasured += assembly_->takeMeasuredPoints();
}

/// Once: where rigid bodies touch by a stiffness that the step of the soft grains is too long for.
/// (It becomes longer where stiff grains go, or the first soft ones come. Bodies come, and
/// materials become stiffer without a word: all are looked at where their number has changed, and
/// now and then.)
void SoftGrainIntegrator::warnOfStiffSpheres()
{
	constexpr long stepsBetweenLooks = 100;
	const auto bodies = scene->bodies->size();
	const bool isKnown = scene->dt <= longestDt_ && bodies == bodiesLookedAt_ &&
			     scene->iter % stepsBetweenLooks != 0;
	if (warnedOfStiffness_ || isKnown) return;
	longestDt_ = std::max(longestDt_, scene->dt);
	bodiesLookedAt_ = bodies;
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

/// Where grains fold or all but invert, or bonds are stiff, a step may become so short that nothing
/// moves on: warned of once, and stopped where it is the grains and cannot be survived.
void SoftGrainIntegrator::checkCollapsedStep(Real undeformed)
{
	if (criticalDt >= collapsedStep * undeformed) return;
	// squares of frequencies add: more than half of them are the bonds'
	const bool byBonds = 0.5 * criticalDt * criticalDt * bondRate > 1;
	if (criticalDt < lostStep * undeformed && !byBonds)
		throw std::runtime_error(messageOfLostStep(*assembly_, criticalDt));
	if (warnedOfCollapse_) return;
	warnedOfCollapse_ = true;
	LOG_WARN("step "
		 << scene->iter << ": the critical time step of the soft grains is " << criticalDt
		 << " s, less than a hundredth of that of the undeformed ones, " << undeformed
		 << " s: "
		 << (byBonds ? "bonds are that stiff, or hold bodies that light. Hint: a lower "
			       "bondStiffness, or heavier rigid bodies"
			     : "a grain is all but crushed or folds somewhere, and the run may "
			       "not get on. Hint: load more slowly, or, under pressures near "
			       "young and above, make grains with nodeSpacing = 2 (user guide, "
			       "'High pressure')"));
}

/// Where a material was made stiffer the last step may have been much longer than is critical now;
/// half of it would count in the kick.
void SoftGrainIntegrator::limitKick()
{
	assembly_->limitKick(std::numeric_limits<double>::infinity());
	const Real kick = assembly_->kickTime(scene->dt);
	if (kick <= criticalDt) return;
	measureCriticalStep(kick);
	if (kick > criticalDt) assembly_->limitKick(scene->dt);
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
	checkCollapsedStep(undeformed);
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
	limitKick();
}

Real criticalTimeStep(Scene& scene)
{
	const auto assembly = assembleScene(scene);
	return assembly ? assembly->criticalTimeStep() : 0;
}

} // namespace yade
