#include "step/System.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace softgrain {

template <int dim> void System<dim>::add(std::unique_ptr<GrainSet<dim>> set)
{
	const GrainTemplate<dim>& reference = set->reference();
	for (int k = 0; k < set->grains(); ++k) {
		place_.push_back({ static_cast<int>(sets_.size()), k });
		damped_ |= set->parameters(k).damping.acts();
		const double radius = set->parameters(k).radius;
		ContactBody<dim> body;
		body.mesh = &reference.contactMesh;
		body.nodeRadius = radius * reference.contactRadius;
		body.pointSpacing = radius * reference.pointSpacing();
		body.overlap = &reference.overlap;
		body.inradius = radius * reference.inradius;
		set->contactPositions(k, body.position);
		body.velocity.assign(reference.contactNodes(), Vec<dim>::Zero());
		body.impulse = body.velocity;
		lastPosition_.push_back(body.position);
		bodies_.push_back(std::move(body));
		if (reference.recipe.contact == ContactGeometry::nodes)
			gridSpacing_ =
				std::max(gridSpacing_, radius * reference.recipe.nodeSpacing *
							       reference.pointSpacing());
	}
	loads_.resize(place_.size());
	resting_.resize(place_.size(), -1);
	surface_.resize(place_.size());
	sets_.push_back(std::move(set));
	for (int g = static_cast<int>(rate_.size()); g < grains(); ++g) {
		rate_.push_back(1);
		undeformedTimeStep_ = std::min(undeformedTimeStep_, timeStepOf(g, 1, 1));
	}
	ratesChosen_ = false;
	listGrains();
	forcesFresh_ = false;
}

/// Lists of active, rigid and sleeping grains as the sets say.
template <int dim> void System<dim>::listGrains()
{
	long changes = 0;
	for (const auto& set : sets_)
		changes += set->changesOfActivity();
	if (listedChanges_ == changes && listed_.size() == place_.size()) return;
	listedChanges_ = changes;
	listed_.resize(place_.size());
	for (auto* list : { &active_, &asleep_, &awake_ })
		list->clear();
	for (int g = 0; g < grains(); ++g) {
		listed_[g] = isAsleep(g) ? asleep : isRigid(g) ? rigid : active;
		if (listed_[g] == active) active_.push_back(g);
		(listed_[g] == asleep ? asleep_ : awake_).push_back(g);
	}
	measureSleepers();
	for (const auto& set : sets_)
		set->arrangeGrains();
}

/// Grains that are touched, or spin too fast, are woken before the solve. Rigid ones that do not
/// move and that nothing drives sleep.
template <int dim>
void System<dim>::chooseRigidGrains(const std::vector<char>& touched, const StepSettings& settings)
{
	for (int g : awake_) {
		GrainSet<dim>& set = setOf(g);
		const int k = indexInSet(g);
		const bool rigid = settings.rigidMotion && !touched[g] && set.mayMoveRigidly(k);
		if (rigid && !set.isRigid(k)) set.beginRigidMotion(k);
		if (!rigid && set.isRigid(k)) {
			body(g); // the next surface is compared with the present one
			set.endRigidMotion(k);
		}
		if (rigid && settings.sleep && set.isMotionless(k) && loads_[g].isZero()) {
			set.fallAsleep(k);
			bodies_[g].velocities = {};
			resting_[g] = 0;
		}
	}
	listGrains();
}

/// Grid nodes in contact become the contact nodes of their grains.
template <int dim> void System<dim>::useGridNodes(const std::vector<ContactList<dim>*>& lists)
{
	std::vector<std::vector<char>> used(grains());
	auto use = [&](int g, int node) {
		used[g].resize(bodies_[g].gridNode.size(), 0);
		used[g][node] = 1;
	};
	for (const ContactList<dim>* list : lists)
		for (const Contact<dim>& contact : list->contacts) {
			use(list->first, contact.key.node);
			if (contact.partners > 0) use(list->second, contact.partner[0]);
		}
	for (int g = 0; g < grains(); ++g)
		if (!used[g].empty())
			setOf(g).useContactNodes(indexInSet(g),
						 pointShares(bodies_[g].gridNode, used[g]));
}

namespace {

/// From so many sets on a thread has enough to do with whole ones.
constexpr int setsPerThread = 4;

template <int dim> std::string whatStopped(const GrainSet<dim>& set, int g)
{
	std::string what =
		"the material point is inverted (J <= 0 or not finite) or has left its grain";
	if (set.condition() == Condition::planeStress && set.parameters(g).constants.poisson < 0)
		what += ", or so compressed that in plane stress with poisson < 0 no thickness is "
			"free of stress";
	return what;
}

} // namespace

/// Threads share the grains of a set or, if there are many sets or none has more than a block, the
/// sets. (Never several threads within another region, even if that has a single thread: they are
/// made anew each time.)
template <int dim> void System<dim>::updateForces(int threads)
{
	listGrains();
	threads = threadsFor(static_cast<long>(active_.size()), threads);
	const int sets = static_cast<int>(sets_.size());
	const bool allSmall = std::all_of(sets_.begin(), sets_.end(), [](const auto& set) {
		return set->grains() <= laneWidth;
	});
	const bool shareSets = allSmall || sets >= setsPerThread * threads;
	const ForceSchedule schedule { shareSets ? 1 : threads, continuation_.steps,
				       continuation_.lastStep };
	auto updateSet = [&](int i) {
		return static_cast<long>(sets_[i]->updateForces(schedule)) *
		       sets_[i]->reference().points();
	};
	long points = 0;
	if (shareSets) {
#pragma omp parallel for schedule(dynamic) num_threads(threads) reduction(+ : points)
		for (int i = 0; i < sets; ++i)
			points += updateSet(i);
	} else
		for (int i = 0; i < sets; ++i)
			points += updateSet(i);
	updatedPoints_ += points;
	for (int g : active_) {
		const int point = setOf(g).report(indexInSet(g)).invertedPoint;
		if (point >= 0) throw StepError(g, point, whatStopped(setOf(g), indexInSet(g)));
	}
	forcesFresh_ = true;
}

/// (With the length of this step alone, a step that follows the deformation would pump energy into
/// the vibration it follows.)
template <int dim> double System<dim>::kickTime(double dt) const
{
	return continuation_.lastStep > 0 ? 0.5 * (continuation_.lastStep + dt) : dt;
}

/// Velocities without contact, of the nodes and of the contact nodes; stops if one is not finite.
template <int dim>
void System<dim>::predictVelocities(const std::vector<char>& touched, const StepSettings& settings)
{
	const double kick = kickTime(settings.dt);
	finite_.resize(grains());
	forEachOf(awake_, settings.threads, [&](int g, GrainSet<dim>& set, int k) {
		set.predictVelocities(k, kick, loads_[g]);
		finite_[g] = set.hasFiniteVelocities(k);
		if (touched[g]) gatherContacts(g, settings.trackEnergy || rebounds_);
	});
	stopAtInfinite();
}

template <int dim> void System<dim>::stopAtInfinite() const
{
	for (int g : awake_)
		if (!finite_[g]) throw StepError(g, -1, "a nodal velocity is not finite");
}

template <int dim> void System<dim>::gatherContacts(int g, bool trackEnergy)
{
	GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	ContactBody<dim>& body = bodies_[g];
	const ContactMobility<dim> mobility = set.contactMobility(k);
	body.delassus = mobility.table;
	body.surfaceMobility = mobility.surface;
	body.delassusScale = mobility.scale;
	set.contactVelocities(k, body.velocity);
	if (trackEnergy) set.contactVelocitiesBefore(k, body.velocityBefore);
	body.prepareSolve();
}

/// Before anything moves, if the solve has led to what is no number: velocities were finite before.
template <int dim>
void System<dim>::checkImpulses(const SolverReport& solved, const std::vector<char>& touched)
{
	if (std::isfinite(solved.residual)) return;
	for (int g : awake_)
		finite_[g] = !touched[g] || bodies_[g].hasFiniteVelocities();
	stopAtInfinite();
	throw std::runtime_error("a velocity of a rigid body in contact is not finite. Hint: look "
				 "at its State and at what acts on it");
}

/// The new velocities of a grain, with the impulses of its contacts.
template <int dim>
void System<dim>::correctVelocities(int g, const std::vector<char>& touched,
				    const StepSettings& settings)
{
	GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	if (touched[g]) set.applyContactImpulses(k, bodies_[g].impulse);
	if (settings.trackEnergy) works_[g].kinetic = set.kineticEnergy(k);
}

/// Before the new velocities take the place of those that the works are of.
template <int dim> void System<dim>::measureWorks(int g)
{
	GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	ContactWork::Halves loads, damping;
	if (!loads_[g].isZero())
		set.addLoadWork(k, lastKick_, loads_[g], loads.before, loads.after);
	set.addDampingLoss(k, lastKick_, damping.before, damping.after);
	works_[g].loads = loads;
	works_[g].damping = damping;
}

template <int dim> void System<dim>::balanceEnergy(const ContactWork& work, double dropped)
{
	energy_ = continuation_.sums;
	energy_.kinetic = energy_.elastic = 0;
	for (int g = 0; g < grains(); ++g)
		energy_.elastic += setOf(g).report(indexInSet(g)).elasticEnergy;
	ContactWork::Halves loads, damping;
	for (int g : awake_) { // one after the other, whoever computed it
		energy_.kinetic += works_[g].kinetic;
		loads += works_[g].loads;
		damping += works_[g].damping;
	}
	auto book = [this](double EnergyBalance::* sum, const ContactWork::Halves& halves) {
		energy_.*sum += halves.before; // the first half is done when t_n is reached
		continuation_.sums.*sum += halves.before + halves.after;
	};
	book(&EnergyBalance::impact, work.impact);
	book(&EnergyBalance::friction, work.friction);
	book(&EnergyBalance::planes, work.planes);
	book(&EnergyBalance::cell, work.cell);
	book(&EnergyBalance::cohesion, work.cohesion);
	book(&EnergyBalance::loads, loads);
	book(&EnergyBalance::damping, damping);
	book(&EnergyBalance::sleep, { dropped, 0 });
}

/// Into the order of the sweeps, which is part of the result: it must not depend on who found which
/// contact when. Returns by grain whether there are contacts on it.
template <int dim>
std::vector<char> System<dim>::sortLists(std::vector<ContactList<dim>*>& lists,
					 StepReport& report) const
{
	std::stable_sort(lists.begin(), lists.end(),
			 [](const ContactList<dim>* a, const ContactList<dim>* b) {
				 return a->sweepOrder() < b->sweepOrder();
			 });
	std::vector<char> touched(grains(), 0);
	for (ContactList<dim>* list : lists) {
		report.deepest = std::max(report.deepest, list->deepest);
		if (list->rigid) {
			const RigidPartner<dim>& partner = partners_[list->rigid->partner];
			list->rigid->moves = partner.moves();
			list->rigid->hasVelocity = partner.hasVelocity();
		}
		if (list->contacts.empty()) continue;
		touched[list->first] = 1;
		if (list->second >= 0) touched[list->second] = 1;
	}

	for (const RigidContact<dim>& contact : rigidContacts_)
		if (partners_[contact.first].moves() || partners_[contact.second].moves())
			report.deepest = std::max(report.deepest, -contact.gap / contact.size);
	return touched;
}

/// Which grains are computed, move rigidly or sleep in this step; leaves out the lists of sleepers.
template <int dim>
void System<dim>::chooseInactiveGrains(std::vector<ContactList<dim>*>& lists,
				       const std::vector<char>& touched,
				       const StepSettings& settings, StepReport& report)
{
	wakeGrains(lists, report.kick, settings.sleep);
	chooseRigidGrains(touched, settings);
	bondsAsleep_ = std::any_of(lists.begin(), lists.end(), [](const ContactList<dim>* list) {
		return list->isAsleep() && list->interface && list->interface->law.hasBond();
	});
	std::erase_if(lists,
		      [](ContactList<dim>* list) { return list->rest.kept = list->isAsleep(); });
	findRestedGrains(lists, touched, settings);
	report.activeGrains = static_cast<int>(active_.size());
	report.sleepingGrains = static_cast<int>(asleep_.size());
}

/// To t_{n+1}. What is done to a grain is done in one go where nothing has to be known of others in
/// between: each pass over all grains would fetch their nodes from memory again.
template <int dim>
void System<dim>::move(const std::vector<ContactList<dim>*>& lists,
		       const std::vector<char>& touched, const StepSettings& settings,
		       StepReport& report)
{
	if (settings.trackEnergy) works_.resize(grains());
	auto correct = [&](int g, GrainSet<dim>&, int) { correctVelocities(g, touched, settings); };
	auto advance = [&](int g, GrainSet<dim>& set, int k) {
		if (settings.trackEnergy) measureWorks(g);
		set.move(k, settings.dt);
		followMotion(g, settings.dt);
		settings.moved(g);
	};
	const bool together = std::any_of(sets_.begin(), sets_.end(),
					  [](const auto& set) { return set->preparesMove(); });
	if (!together && rested_.empty()) {
		forEachOf(awake_, settings.threads, [&](int g, GrainSet<dim>& set, int k) {
			correct(g, set, k);
			advance(g, set, k);
		});
		return;
	}
	forEachOf(awake_, settings.threads, correct);
	fallAsleep(lists, report);
	for (const auto& set : sets_)
		set->prepareMove(settings.threads);
	forEachOf(awake_, settings.threads, advance);
}

template <int dim> void System<dim>::endStep(double dt)
{
	listGrains();
	continuation_.lastStep = dt;
	++continuation_.steps;
	forcesFresh_ = false;
}

template <int dim>
StepReport System<dim>::step(const StepSettings& settings, std::vector<ContactList<dim>*> lists)
{
	solver_.forget(); // the step may fail before it plans anew
	StepReport report;
	PhaseClock silent;
	PhaseClock& clock = settings.clock ? *settings.clock : silent;
	if (!forcesFresh_) updateForces(settings.threads);
	report.kick = lastKick_ = kickTime(settings.dt);

	const std::vector<char> touched = sortLists(lists, report);
	clock.end("sortLists");
	chooseInactiveGrains(lists, touched, settings, report);
	clock.end("chooseInactiveGrains");
	solver_.plan(lists, grains(), &partners_, &rigidContacts_); // while lists are in the caches
	clock.end("plan");
	if (gridSpacing_ > 0) useGridNodes(lists);
	beginInterfaces(lists, report.kick, settings.dt);
	predictVelocities(touched, settings);
	measureBonds(lists);
	clock.end("predictVelocities");
	if (settings.trackRigidBodies) free_ = partners_;
	solver_.prepare(bodies_, settings.dt, settings.solver, settings.threads);
	clock.end("prepare");
	report.solver = solver_.solve();
	solver_.separateRigidBodies(settings.dt);
	clock.end("solve");
	checkImpulses(report.solver, touched);
	move(lists, touched, settings, report);
	clock.end("move");
	if (settings.trackEnergy) {
		balanceEnergy(workOfContacts(), report.droppedEnergy);
		if (settings.trackRigidBodies) balanceRigidBodies();
		clock.end("balanceEnergy");
	}
	endStep(settings.dt);
	report.work.points = std::exchange(updatedPoints_, 0);
	report.work.visits = report.solver.visits;
	return report;
}

template class System<2>;
template class System<3>;

} // namespace softgrain
