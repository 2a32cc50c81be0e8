#include "SoftGrainIntegrator.hpp"
#include "PeriodicCell.hpp"
#include "Require.hpp"
#include "SceneAssembly.hpp"
#include "SoftContact.hpp"
#include "SoftGrain.hpp"
#include "SoftMat.hpp"

#include <sstream>
#include <typeinfo>

namespace yade {

YADE_PLUGIN((SoftGrainIntegrator));

using softgrain::require;
using softgrain::Rotation;
using softgrain::Vec3;

namespace {

/// Relative rounding of the critical time step: how much a grain stiffens comes from the root of a
/// difference of large numbers, 1e-8 in an undeformed grain.
constexpr double timeStepRounding = 1e-6;

/// How far a shift may be from whole periods, over the radius.
constexpr double wrapTolerance = 1e-6;

} // namespace

void SoftGrainIntegrator::postLoad(SoftGrainIntegrator&)
{
	require(timeStepFraction > 0 && timeStepFraction <= 1, "timeStepFraction", timeStepFraction,
		"(0, 1]");
	require(tolerance > 0, "tolerance", tolerance, "(0, inf)");
	require(maxSweeps >= 1, "maxSweeps", maxSweeps, "1, 2, ...");
	require(overlapRelaxation >= 0 && overlapRelaxation <= 1, "overlapRelaxation",
		overlapRelaxation, "[0, 1]");
	require(overlapSpeed >= 0, "overlapSpeed", overlapSpeed, "[0, inf)");
	require(interfaceRange >= 0 && math::isfinite(interfaceRange), "interfaceRange",
		interfaceRange, "[0, inf) m");
	require(maxOverlap > 0, "maxOverlap", maxOverlap, "(0, inf)");
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
			<< timeStepFraction << "), or refine the grain (smaller zeta).";
		lastError = message.str();
		throw std::runtime_error(lastError);
	} catch (const std::exception& e) {
		lastError = "SoftGrainIntegrator, step " + std::to_string(scene->iter) + ": " +
			    e.what();
		throw std::runtime_error(lastError);
	}
}

/// One step. Whatever may be wrong is found before anything is changed.
void SoftGrainIntegrator::advance()
{
	clock_.start(TimingInfo::enabled);
	nonsmooth_ = listRigidContacts();
	assembly_ = assembleScene(*scene);
	if (!assembly_ && !nonsmooth_) return;
	if (!assembly_) {
		if (!withoutGrains_)
			withoutGrains_ = softgrain::GrainAssembly::createWithoutGrains();
		assembly_ = withoutGrains_;
	}
	checkEngines();
	checkCell(*scene, *assembly_);
	if (loaded_) continueSavedRun();
	assembly_->setMultirate(multirate);
	assembly_->setInterfaceRange(interfaceRange);
	clock_.end("assembleScene");
	const auto wrapped = applyUserMotions();
	clock_.end("applyUserMotions");
	assembly_->updateForces(threads());
	clock_.end("updateForces");
	chooseTimeStep();
	clock_.end("chooseTimeStep");
	const auto interactions = softInteractions();
	renewContacts(interactions, wrapped);
	checkRigidBodies(interactions);
	checkInterfaces(interactions);
	stopOnOverlap(interactions);
	moveImages(interactions);
	clock_.end("softInteractions");
	applyLoads();
	describeRigidBodies(interactions);
	clock_.end("applyLoads");

	std::vector<softgrain::PairContacts*> pairs;
	for (const Interaction* I : interactions)
		pairs.push_back(static_cast<SoftGeom&>(*I->geom).pair.get());
	const auto report = assembly_->step(settings(), pairs, partners_, rigidContacts_);

	publishForces(interactions, report.kick);
	publishRigidContacts();
	moveApart();
	clock_.end("publishForces");
	publishMotions();
	clock_.end("publishMotions");
	publishReport(report);
	saveContinuation();
	clock_.end("publishReport");
	if (scene->trackEnergy) {
		publishEnergy();
		clock_.end("publishEnergy");
	}
	callColliderIfNeeded();
	clock_.end("callColliderIfNeeded");
	publishTimes();
}

/// A run that was loaded goes on with the sums and the step that were saved.
void SoftGrainIntegrator::continueSavedRun()
{
	loaded_ = false;
	if (workSums.size() != 8) return;
	softgrain::Continuation state;
	if (rigidWorkSums.size() == 5) {
		softgrain::RigidBalance& rigid = state.sums.rigid;
		rigid.friction = rigidWorkSums[0];
		rigid.impact = rigidWorkSums[1];
		rigid.walls = rigidWorkSums[2];
		rigid.cell = rigidWorkSums[3];
		rigid.loads = rigidWorkSums[4];
	}
	state.lastStep = lastStep;
	state.steps = assemblySteps;
	state.sums.friction = workSums[0];
	state.sums.impact = workSums[1];
	state.sums.planes = workSums[2];
	state.sums.loads = workSums[3];
	state.sums.damping = workSums[4];
	state.sums.sleep = workSums[5];
	state.sums.cell = workSums[6];
	state.sums.cohesion = workSums[7];
	state.bondRate = bondRate;
	assembly_->continueFrom(state);
}

namespace {

bool isActiveTimeStepper(Engine& engine)
{
	const auto* stepper = dynamic_cast<TimeStepper*>(&engine);
	return stepper && stepper->active && !stepper->dead;
}

} // namespace

void SoftGrainIntegrator::checkEngines() const
{
	bool seenThis = false, seenNewton = false;
	for (const auto& engine : scene->engines) {
		if (engine.get() == this)
			seenThis = true;
		else if (YADE_PTR_DYN_CAST<SoftGrainIntegrator>(engine))
			throw std::runtime_error(
				"O.engines holds two SoftGrainIntegrators; each moves all soft "
				"grains: leave one");
		else if (seenThis && YADE_PTR_DYN_CAST<NewtonIntegrator>(engine))
			seenNewton = true;
		else if (seenThis && isActiveTimeStepper(*engine))
			throw std::runtime_error(
				engine->getClassName() +
				" stands after SoftGrainIntegrator in O.engines and would change "
				"O.dt between contact and motion; put it before");
	}
	if (seenNewton) return;
	throw std::runtime_error(
		"there is no NewtonIntegrator after it in O.engines, which carries "
		"State along. "
		"See sg.engines()");
}

int SoftGrainIntegrator::threads() const
{
#ifdef YADE_OPENMP
	return ompThreads > 0 ? std::min(ompThreads, omp_get_max_threads()) : omp_get_max_threads();
#else
	return 1;
#endif
}

bool SoftGrainIntegrator::hasTimeStepper() const
{
	return std::any_of(scene->engines.begin(), scene->engines.end(),
			   [](const auto& engine) { return isActiveTimeStepper(*engine); });
}

/// Changes dtSet seldom: each change costs a little of the integrator's conservation of energy.
void SoftGrainIntegrator::followDeformation(Real undeformed)
{
	const Real limit = timeStepFraction * criticalDt;
	if (dtSet == 0 || (dtSet != scene->dt && !hasTimeStepper()))
		dtSet = std::min(timeStepFraction * undeformed, criticalDt);
	if (dtSet > limit * (1 + timeStepRounding) || dtSet < 0.7 * limit) dtSet = 0.9 * limit;
}

/// O.dt follows the deformation as long as it is the value set here (or YADE's default, or what sg
/// set for the undeformed scene before the first step); a value of the user's is only checked.
void SoftGrainIntegrator::chooseTimeStep()
{
	if (assembly_->grains() == 0) {
		if (scene->dt == defaultTimeStep())
			throw std::runtime_error(
				"O.dt is not set, and contact dynamics of rigid bodies alone has "
				"no "
				"critical time step: assign O.dt such that no body moves further "
				"than 0.05 of its radius in a step");
		return;
	}
	const Real undeformed = assembly_->criticalTimeStep();
	criticalDt = assembly_->presentCriticalTimeStep();
	const Real own = dtSet > 0 ? dtSet : timeStepFraction * undeformed;
	const bool automatic = scene->dt == dtSet || scene->dt == defaultTimeStep() ||
			       std::abs(scene->dt - own) <= 1e-9 * own;
	if (hasTimeStepper()) {
		const Real ofRigidBodies = scene->dt;
		followDeformation(undeformed);
		scene->dt = std::min(dtSet, ofRigidBodies);
	} else if (automatic) {
		followDeformation(undeformed);
		scene->dt = dtSet;
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

namespace {

/// Up to the rounding of Newton's integrator, which adds vel dt to pos and turns ori: the usual
/// case, told apart at little cost. False where a value is not finite.
bool isAsWritten(const State& state, const softgrain::GrainMotion& written, Real radius)
{
	return state.vel == written.velocity && state.angVel == written.angularVelocity &&
	       (state.pos - written.position).squaredNorm() <= 1e-18 * radius * radius &&
	       (state.ori.coeffs() - written.orientation.coeffs()).squaredNorm() <= 1e-19;
}

} // namespace

/// Changes of State since this engine wrote it are the user's: they act as rigid motions. Returns
/// the ids of the grains that were shifted by whole periods.
std::set<int> SoftGrainIntegrator::applyUserMotions()
{
	std::set<int> wrapped;
	for (int g = 0; g < assembly_->grains(); ++g) {
		const Body& body = *(*scene->bodies)[assembly_->idOf(g)];
		const State& state = *body.state;
		const SoftGrain& grain = static_cast<SoftGrain&>(*body.shape);
		const softgrain::GrainMotion& written = grain.written;
		const Real radius = grain.radius;
		if (isAsWritten(state, written, radius)) continue;
		for (const Vector3r& v : { state.pos, state.vel, state.angVel })
			if (!v.allFinite())
				throw std::runtime_error(
					"soft grain #" + std::to_string(assembly_->idOf(g)) +
					": its State (pos, vel, angVel) holds a value "
					"that is not finite; assign a finite one");
		const Vec3 shift = state.pos - written.position;
		const Rotation turn = state.ori * written.orientation.conjugate();
		Vec3 velocity = state.vel - written.velocity;
		const Vec3 spin = state.angVel - written.angularVelocity;
		const bool moved = shift.norm() > 1e-9 * radius + 1e-14 * state.pos.norm();
		if (moved && followWrap(*scene, body, shift, wrapTolerance * radius)) {
			wrapped.insert(body.getId());
			velocity += newtonIntegrator().prevVelGrad * shift; // its image has it
		}
		const bool turned = turn.vec().norm() > 1e-9;
		const bool pushed = velocity.norm() > 1e-12 * state.vel.norm();
		const bool spun = spin.norm() > 1e-9 * state.angVel.norm() &&
				  spin.norm() * radius > 1e-12 * state.vel.norm();
		if (moved || turned || pushed || spun)
			assembly_->moveRigidly(g, turned ? turn : Rotation(Rotation::Identity()),
					       moved ? shift : Vec3(Vec3::Zero()),
					       pushed ? velocity : Vec3(Vec3::Zero()),
					       spun ? spin : Vec3(Vec3::Zero()));
	}
	return wrapped;
}

const NewtonIntegrator& SoftGrainIntegrator::newtonIntegrator() const
{
	if (const NewtonIntegrator* newton = newtonIntegratorOf(*scene)) return *newton;
	throw std::runtime_error("there is no NewtonIntegrator in O.engines");
}

void SoftGrainIntegrator::applyLoads()
{
	scene->forces.sync();
	const NewtonIntegrator& newton = newtonIntegrator();
	const CellFlow flow = cellFlow(*scene, newton);
	const Real dt = scene->dt, kick = assembly_->kickTime(dt);
	for (int g = 0; g < assembly_->grains(); ++g) {
		const int id = assembly_->idOf(g);
		const Vector3r force = scene->forces.getForce(id),
			       torque = scene->forces.getTorque(id);
		Vec3 angular = Vec3::Zero();
		Vec3 acceleration = newton.gravity / materialOf(*scene, id).massScaling;
		if (!force.isZero(0) || !torque.isZero(0)) {
			const auto motion = assembly_->motion(g);
			acceleration += force / motion.mass;
			angular = torque / motion.inertia;
		}
		if (!flow.isZero()) {
			const State& state = *(*scene->bodies)[id]->state;
			acceleration += flow.added(state.pos, state.vel, dt) / kick;
			angular += flow.spinChange / kick;
		}
		assembly_->setLoad(g, acceleration, angular);
	}
}

namespace {

/// Functors for a shape are called for those derived from it too, as a Cylinder is from Sphere.
bool isTouched(const Shape& shape)
{
	const auto& type = typeid(shape);
	return type == typeid(SoftGrain) || type == typeid(Wall) || type == typeid(Sphere) ||
	       type == typeid(Facet) || type == typeid(Box);
}

[[noreturn]] void refusePair(const Body& grain, const Body& other)
{
	const string shape = other.shape->getClassName();
	throw std::runtime_error(
		"soft grain #" + std::to_string(grain.getId()) + " comes near body #" +
		std::to_string(other.getId()) + " of shape " + shape +
		(isTouched(*other.shape)
			 ? ", for which the InteractionLoop has no Ig2 functor: add "
			   "Ig2_SoftGrain_SoftGrain_SoftGeom, Ig2_Wall_SoftGrain_SoftGeom, "
			   "Ig2_Sphere_SoftGrain_SoftGeom ..., or see sg.engines()"
			 : ". Soft grains touch SoftGrain, Wall, Sphere, Facet and Box only"));
}

} // namespace

/// All real contacts of soft grains; refuses pairs for which there is no contact treatment.
std::vector<Interaction*> SoftGrainIntegrator::softInteractions() const
{
	std::vector<Interaction*> found;
	if (assembly_->grains() == 0) return found;
	for (const auto& I : *scene->interactions) {
		const auto &b1 = (*scene->bodies)[I->getId1()], &b2 = (*scene->bodies)[I->getId2()];
		if (!b1 || !b2) continue;
		if (I->isReal()) {
			if (!dynamic_cast<SoftGeom*>(I->geom.get())) continue;
			if (!isTouched(*b1->shape)) refusePair(*b2, *b1);
			if (!isTouched(*b2->shape)) refusePair(*b1, *b2);
			found.push_back(I.get());
			continue;
		}
		const bool soft1 = bool(YADE_PTR_DYN_CAST<SoftGrain>(b1->shape)),
			   soft2 = bool(YADE_PTR_DYN_CAST<SoftGrain>(b2->shape));
		if (!soft1 && !soft2) continue;
		const Body &grain = soft1 ? *b1 : *b2, &other = soft1 ? *b2 : *b1;
		if (!I->functorCache.geomExists || !isTouched(*other.shape))
			refusePair(grain, other);
	}
	// the container's order depends on threads and history; sums of forces must not
	std::sort(found.begin(), found.end(), [](const Interaction* a, const Interaction* b) {
		return std::minmax(a->getId1(), a->getId2()) <
		       std::minmax(b->getId1(), b->getId2());
	});
	return found;
}

/// Grains added, erased or changed since the InteractionLoop have other indices now, and contacts
/// found there name the old ones; those of wrapped grains have the place of another image.
void SoftGrainIntegrator::renewContacts(const std::vector<Interaction*>& interactions,
					const std::set<int>& wrapped) const
{
	for (Interaction* I : interactions) {
		const bool present = static_cast<SoftGeom&>(*I->geom).assembly == assembly_;
		if (present && !wrapped.count(I->getId1()) && !wrapped.count(I->getId2())) continue;
		const auto& b1 = (*scene->bodies)[I->getId1()];
		const auto& b2 = (*scene->bodies)[I->getId2()];
		const shared_ptr<Interaction>& shared =
			scene->interactions->find(I->getId1(), I->getId2());
		I->functorCache.geom->go(b1->shape, b2->shape, *b1->state, *b2->state,
					 imageShift(*scene, *I), true, shared);
		I->functorCache.constLaw->go(I->geom, I->phys, I);
	}
}

/// Engines since the InteractionLoop may have changed the flow of the cell.
void SoftGrainIntegrator::moveImages(const std::vector<Interaction*>& interactions) const
{
	if (!scene->isPeriodic) return;
	for (const Interaction* I : interactions) {
		softgrain::PairContacts& pair = *static_cast<SoftGeom&>(*I->geom).pair;
		const bool firstIsBody1 = assembly_->idOf(pair.firstGrain()) == I->getId1();
		pair.setImageVelocity(imageOf(*scene, *I, firstIsBody1).velocity);
	}
}

void SoftGrainIntegrator::checkInterfaces(const std::vector<Interaction*>& interactions) const
{
	for (const Interaction* I : interactions)
		try {
			static_cast<SoftGeom&>(*I->geom).pair->checkInterface();
		} catch (const std::invalid_argument& e) {
			throw std::runtime_error("interaction of bodies #" +
						 std::to_string(I->getId1()) + " and #" +
						 std::to_string(I->getId2()) + ": " + e.what());
		}
}

void SoftGrainIntegrator::stopOnOverlap(const std::vector<Interaction*>& interactions) const
{
	for (const Interaction* I : interactions) {
		const Real deepest = static_cast<SoftGeom&>(*I->geom).pair->deepest();
		if (deepest <= maxOverlap) continue;
		std::ostringstream message;
		message << "bodies #" << I->getId1() << " and #" << I->getId2() << " overlap by "
			<< deepest << " point spacings, more than maxOverlap = " << maxOverlap
			<< ". Hint: start from less overlap (sg.soften(overlap='shrink')), load "
			   "more slowly, or reduce tolerance";
		throw std::runtime_error(message.str());
	}
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

Real criticalTimeStep(Scene& scene)
{
	const auto assembly = assembleScene(scene);
	return assembly ? assembly->criticalTimeStep() : 0;
}

} // namespace yade
