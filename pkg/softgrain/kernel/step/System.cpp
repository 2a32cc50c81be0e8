#include "step/System.hpp"
#include "contact/HandOn.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace softgrain {

template <int dim> void System<dim>::add(std::unique_ptr<GrainSet<dim>> set)
{
	grains_.add(std::move(set));
	surfaces_.followNewGrains();
	timeSteps_.followNewGrains();
	activity_.followNewGrains();
	solver_.forget(); // it looks at bodies that may have moved in memory
	forcesFresh_ = false;
}

template <int dim> double System<dim>::presentCriticalTimeStep(double enough, int threads)
{
	return timeSteps_.present(enough, interfaces_.bondRate(), threads);
}

template <int dim> void System<dim>::setMultirate(bool on)
{
	if (timeSteps_.setMultirate(on)) forcesFresh_ = false;
}

template <int dim> Continuation System<dim>::continuation() const
{
	return { energies_.sums(), lastStep_, steps_, interfaces_.bondRate() };
}

template <int dim> void System<dim>::continueFrom(const Continuation& c)
{
	energies_.continueFrom(c.sums);
	lastStep_ = c.lastStep;
	steps_ = c.steps;
	interfaces_.continueFrom(c.bondRate);
}

template <int dim> void System<dim>::updateSurfaces(int threads)
{
	surfaces_.updateAll(threads);
	forcesFresh_ = false;
}

template <int dim> bool System<dim>::search(ContactList<dim>& list, double dt) const
{
	return activity_.isSearchDue(list) && surfaces_.search(list, dt);
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
	grains_.renewLists();
	threads = threadsFor(static_cast<long>(grains_.active().size()), threads);
	const auto& sets = grains_.sets();
	const int count = static_cast<int>(sets.size());
	const bool allSmall = std::all_of(sets.begin(), sets.end(), [](const auto& set) {
		return set->grains() <= laneWidth;
	});
	const bool shareSets = allSmall || count >= setsPerThread * threads;
	const ForceSchedule schedule { shareSets ? 1 : threads, steps_, lastStep_ };
	auto updateSet = [&](int i) {
		return static_cast<long>(sets[i]->updateForces(schedule)) *
		       sets[i]->reference().points();
	};
	long points = 0;
	if (shareSets) {
#pragma omp parallel for schedule(dynamic) num_threads(threads) reduction(+ : points)
		for (int i = 0; i < count; ++i)
			points += updateSet(i);
	} else
		for (int i = 0; i < count; ++i)
			points += updateSet(i);
	updatedPoints_ += points;
	for (int g : grains_.active()) {
		const int point = setOf(g).report(indexInSet(g)).invertedPoint;
		if (point >= 0) throw StepError(g, point, whatStopped(setOf(g), indexInSet(g)));
	}
	forcesFresh_ = true;
}

/// (With the length of this step alone, a step that follows the deformation would pump energy into
/// the vibration it follows. Where a material has become much stiffer, the last step was longer
/// than its forces bear.)
template <int dim> double System<dim>::kickTime(double dt) const
{
	return lastStep_ > 0 ? std::min(0.5 * (lastStep_ + dt), longestKick_) : dt;
}

/// Velocities without contact, of the nodes and of the contact nodes; stops if one is not finite.
template <int dim>
void System<dim>::predictVelocities(const std::vector<char>& touched, const StepSettings& settings)
{
	const double kick = kickTime(settings.dt);
	const bool tracksBefore = settings.trackEnergy || interfaces_.rebound();
	finite_.resize(grains());
	grains_.forEachOf(grains_.awake(), settings.threads, [&](int g, GrainSet<dim>& set, int k) {
		set.predictVelocities(k, kick, grains_.loads()[g]);
		finite_[g] = set.hasFiniteVelocities(k);
		if (touched[g]) gatherContacts(g, tracksBefore);
	});
	if (!activity_.besideAwake().empty())
		grains_.forEachOf(activity_.besideAwake(), settings.threads,
				  [&](int g, auto&&...) { gatherContactsAtRest(g, tracksBefore); });
	stopAtInfinite();
}

template <int dim> void System<dim>::stopAtInfinite() const
{
	for (int g : grains_.awake())
		if (!finite_[g]) throw StepError(g, -1, "a nodal velocity is not finite");
}

template <int dim> void System<dim>::gatherContacts(int g, bool trackEnergy)
{
	GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	ContactBody<dim>& body = surfaces_.bodies()[g];
	const ContactMobility<dim> mobility = set.contactMobility(k);
	body.delassus = mobility.table;
	body.surfaceMobility = mobility.surface;
	body.delassusScale = mobility.scale;
	set.contactVelocities(k, body.velocity);
	if (trackEnergy) set.contactVelocitiesBefore(k, body.velocityBefore);
	body.prepareSolve();
}

/// Of a grain that sleeps beside one that is awake: it is held where it is, whatever pushes it.
template <int dim> void System<dim>::gatherContactsAtRest(int g, bool trackEnergy)
{
	gatherContacts(g, trackEnergy);
	ContactBody<dim>& body = surfaces_.bodies()[g];
	body.delassusScale = 0;
	std::fill(body.velocity.begin(), body.velocity.end(), Vec<dim>::Zero());
	std::fill(body.velocityBefore.begin(), body.velocityBefore.end(), Vec<dim>::Zero());
}

/// Before anything moves, if the solve has led to what is no number: velocities were finite before.
template <int dim>
void System<dim>::checkImpulses(const SolverReport& solved, const std::vector<char>& touched)
{
	if (std::isfinite(solved.residual)) return;
	for (int g : grains_.awake())
		finite_[g] = !touched[g] || surfaces_.bodies()[g].hasFiniteVelocities();
	stopAtInfinite();
	throw std::runtime_error("a velocity of a rigid body in contact is not finite. Hint: look "
				 "at its State and at what acts on it");
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
	activity_.wakeChanged(lists, report.kick, settings.sleep);
	activity_.chooseRigidGrains(touched, settings);
	interfaces_.noteSleepers(lists);
	sleeping_.clear();
	std::erase_if(lists, [this](ContactList<dim>* list) {
		list->rest.kept = list->isAsleep();
		if (list->rest.kept) sleeping_.push_back(list);
		return list->rest.kept;
	});
	activity_.noteSleepersBesideAwake(lists);
	activity_.findRested(lists, touched, settings, steps_);
	report.activeGrains = static_cast<int>(grains_.active().size());
	report.sleepingGrains = static_cast<int>(grains_.asleep().size());
}

/// To t_{n+1}. What is done to a grain is done in one go where nothing has to be known of others in
/// between: each pass over all grains would fetch their nodes from memory again.
template <int dim>
void System<dim>::move(const std::vector<ContactList<dim>*>& lists,
		       const std::vector<char>& touched, const StepSettings& settings,
		       StepReport& report)
{
	if (settings.trackEnergy) energies_.beginMove();
	auto correctVelocities = [&](int g, GrainSet<dim>& set, int k) {
		if (touched[g]) set.applyContactImpulses(k, surfaces_.bodies()[g].impulse);
		if (settings.trackEnergy) energies_.noteKineticEnergy(g);
	};
	// before the new velocities take the place of the old ones
	auto measureWorks = [&](int g, GrainSet<dim>&, int) {
		energies_.measureWorks(g, report.kick);
	};
	auto advance = [&](int g, GrainSet<dim>& set, int k) {
		set.move(k, settings.dt);
		surfaces_.followMotion(g, settings.dt);
		settings.moved(g);
	};
	const auto& sets = grains_.sets();
	const bool together = std::any_of(sets.begin(), sets.end(),
					  [](const auto& set) { return set->preparesMove(); });
	if (!together && activity_.rested().empty()) {
		grains_.forEachOf(grains_.awake(), settings.threads,
				  [&](int g, GrainSet<dim>& set, int k) {
					  correctVelocities(g, set, k);
					  if (settings.trackEnergy) measureWorks(g, set, k);
					  advance(g, set, k);
				  });
		return;
	}
	grains_.forEachOf(grains_.awake(), settings.threads, correctVelocities);
	report.dropped = activity_.fallAsleep(lists, report.kick);
	if (settings.trackEnergy) {
		for (int g : activity_.rested())
			energies_.noteRest(g);
		grains_.forEachOf(grains_.awake(), settings.threads, measureWorks);
	}
	for (const auto& set : sets)
		set->prepareMove(settings.threads);
	grains_.forEachOf(grains_.awake(), settings.threads, advance);
}

/// The velocities after the step are zero in grains that fall asleep; outside of here they remain
/// what was solved, and where the solver knows them to be (contactProblem).
template <int dim> ContactWork System<dim>::workOfContacts()
{
	std::vector<ContactBody<dim>>& bodies = surfaces_.bodies();
	const std::vector<int>& rested = activity_.rested();
	std::vector<std::vector<Vec<dim>>> solved;
	for (int g : rested) {
		std::vector<Vec<dim>>& velocity = bodies[g].velocity;
		solved.push_back(velocity);
		velocity.assign(velocity.size(), Vec<dim>::Zero());
	}
	const ContactWork work = solver_.work();
	for (std::size_t i = 0; i < rested.size(); ++i)
		std::copy(solved[i].begin(), solved[i].end(), bodies[rested[i]].velocity.begin());
	return work;
}

template <int dim>
void System<dim>::balanceEnergy(const StepSettings& settings, const StepReport& report)
{
	energies_.balanceGrains(workOfContacts(), report.dropped.energy);
	if (settings.trackRigidBodies) energies_.balanceRigidBodies(solver_.rigidWork(), partners_);
}

template <int dim> void System<dim>::endStep(double dt, double kick)
{
	grains_.renewLists();
	lastStep_ = dt;
	lastKick_ = kick;
	++steps_;
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
	report.kick = kickTime(settings.dt);

	const std::vector<char> touched = sortLists(lists, report);
	report.work.handedOnBonds = handOnHistories(lists, surfaces_.bodies(), partners_);
	timeSteps_.followContacts(lists, steps_);
	clock.end("sortLists");
	chooseInactiveGrains(lists, touched, settings, report);
	clock.end("chooseInactiveGrains");
	solver_.plan(lists, grains(), &partners_, &rigidContacts_); // while lists are in the caches
	clock.end("plan");
	if (surfaces_.haveCommonGrid()) surfaces_.useGridNodes(lists);
	interfaces_.begin(lists, report.kick, settings.dt);
	predictVelocities(touched, settings);
	interfaces_.measureBonds(lists, surfaces_.bodies(), partners_);
	clock.end("predictVelocities");
	solver_.prepare(surfaces_.bodies(), settings.dt, settings.solver, settings.threads);
	clock.end("prepare");
	report.solver = solver_.solve();
	solver_.separateRigidBodies(settings.dt);
	clock.end("solve");
	checkImpulses(report.solver, touched);
	move(lists, touched, settings, report);
	report.dropped.momentum += activity_.wakeStrained(lists, sleeping_, report.kick);
	clock.end("move");
	if (settings.trackEnergy) {
		balanceEnergy(settings, report);
		clock.end("balanceEnergy");
	}
	endStep(settings.dt, report.kick);
	report.work.points = std::exchange(updatedPoints_, 0);
	report.work.visits = report.solver.visits;
	return report;
}

template class System<2>;
template class System<3>;

} // namespace softgrain
