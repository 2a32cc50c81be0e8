// Grains at rest: whole islands, connected by contacts within reach, fall asleep and wake together,
// so that no contact lies between a grain that is solved and one that is not
// (doc/decisions/0014-inactive-grains.md).
//
// Falling asleep is an impulse on every node, at t_n after the contacts were solved, that brings it
// to rest: positions, internal forces and contact impulses stay those of t_n, and the work of that
// impulse is what is booked as dropped.
#include "step/System.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace softgrain {

namespace {

/// For how many periods of its slowest vibration a grain that rests alone must be calm; an island's
/// own vibrations are slower by the number of grains across.
constexpr double calmPeriods = 4;

/// Steps from one look at the grains to the next, to spend less on looking than on grains; a period
/// has some tens of steps.
constexpr int watchInterval = 8;

} // namespace

template <int dim> void System<dim>::setLoad(int g, const BodyLoad<dim>& load)
{
	if (loads_[g] == load) return;
	loads_[g] = load;
	wake(g);
}

template <int dim> void System<dim>::wake(int g)
{
	if (!isAsleep(g)) return;
	setOf(g).wake(indexInSet(g));
	resting_[g] = -1;
}

template <int dim> std::vector<double> System<dim>::sleepNumbers(int g) const
{
	if (!isAsleep(g)) return {};
	const BodyLoad<dim>& load = loads_[g];
	std::vector<double> numbers { static_cast<double>(resting_[g]) };
	numbers.insert(numbers.end(), load.acceleration.data(), load.acceleration.data() + dim);
	numbers.insert(numbers.end(), load.angular.data(), load.angular.data() + dim * dim);
	return numbers;
}

template <int dim> void System<dim>::restoreSleep(int g, const std::vector<double>& numbers)
{
	if (numbers.empty()) return;
	requireSize("load and pairs", numbers, 1 + dim + dim * dim);
	resting_[g] = static_cast<int>(numbers[0]);
	loads_[g] = { Eigen::Map<const Vec<dim>>(&numbers[1]),
		      Eigen::Map<const Mat<dim>>(&numbers[1 + dim]) };
}

template <int dim> void System<dim>::measureSleepers()
{
	sleepersTimeStep_ = std::numeric_limits<double>::infinity();
	for (int g : asleep_)
		sleepersTimeStep_ = std::min(sleepersTimeStep_, presentTimeStepOf(g));
}

/// Whether the bodies of a sleeping pair are still where they were.
template <int dim> bool System<dim>::liesStill(const ContactList<dim>& list) const
{
	if (!isAsleep(list.first)) return false;
	const bool still = list.second >= 0 ? isAsleep(list.second) && list.image.velocity.isZero(0)
					    : list.hasStillSupport();
	return still && list.placeOfSecond() == list.rest.placeOfSecond;
}

/// Wakes islands in which something changed: a grain was woken by hand, something came within
/// reach, a pair lost its contacts or is new. Impulses become those of a step with this kick.
template <int dim>
void System<dim>::wakeGrains(const std::vector<ContactList<dim>*>& lists, double kick, bool sleep)
{
	const bool noneRests = std::none_of(lists.begin(), lists.end(),
					    [](const auto* list) { return list->rest.kick > 0; });
	if (asleep_.empty() && noneRests) return;
	std::vector<int> changed, resting(grains(), 0);
	for (const ContactList<dim>* list : lists) {
		const bool still = list->isAsleep() && liesStill(*list);
		if (!still && list->contacts.empty()) continue;
		for (int g : { list->first, list->second }) {
			if (g < 0) continue;
			if (still)
				++resting[g];
			else if (listed_[g] == asleep || list->rest.kick > 0)
				changed.push_back(g);
		}
	}
	for (int g : asleep_)
		if (!sleep || resting[g] != resting_[g]) changed.push_back(g);
	if (changed.empty()) return;

	Islands islands(grains());
	for (const ContactList<dim>* list : lists)
		if (list->isAsleep() && list->second >= 0) islands.join(list->first, list->second);
	std::vector<char> wakes(grains(), 0); // by island
	for (int g : changed)
		wakes[islands.of(g)] = 1;
	for (int g : asleep_)
		if (wakes[islands.of(g)]) wake(g);
	for (ContactList<dim>* list : lists) {
		const bool rests = list->isAsleep() && !wakes[islands.of(list->first)];
		if (rests || list->rest.kick == 0) continue;
		for (Contact<dim>& contact : list->contacts)
			contact.impulse *= kick / list->rest.kick;
		list->rest = {};
	}
	listGrains();
}

namespace {

/// What decides whether an island may sleep.
struct IslandAtRest {
	int grains = 0;
	double calmPeriods = 0; ///< for which each of them must be calm
	/// By a plane or a rigid body that is held, which takes what momentum is left.
	bool supported = false;
	/// By a plane, a rigid body or an image that moves or may be moved, or a grain that is not
	/// calm.
	bool disturbed = false;
};

} // namespace

template <int dim>
Islands System<dim>::islandsInContact(const std::vector<ContactList<dim>*>& lists) const
{
	Islands islands(grains());
	for (const ContactList<dim>* list : lists)
		if (!list->contacts.empty() && list->second >= 0)
			islands.join(list->first, list->second);
	return islands;
}

/// Makes the list of those that will fall asleep at the end of the step, if forces balance then.
template <int dim>
void System<dim>::findRestedGrains(const std::vector<ContactList<dim>*>& lists,
				   const std::vector<char>& touched, const StepSettings& settings)
{
	rested_.clear();
	const bool isDue = continuation_.steps % watchInterval == 0;
	if (!settings.sleep || !damped_ || !isDue) return;
	std::vector<double> periods(grains(), 0); // for which a grain has been calm
	bool none = true;
	for (int g : active_) {
		periods[g] = setOf(g).watchRest(indexInSet(g), watchInterval * settings.dt);
		none = none && periods[g] < calmPeriods;
	}
	if (none) return;

	Islands islands = islandsInContact(lists);
	std::vector<IslandAtRest> found(grains());
	for (const ContactList<dim>* list : lists)
		if (!list->image.velocity.isZero(0))
			found[islands.of(list->first)].disturbed = true;
	for (int g : active_)
		++found[islands.of(g)].grains;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty() || list->second >= 0) continue;
		IslandAtRest& island = found[islands.of(list->first)];
		(list->hasStillSupport() ? island.supported : island.disturbed) = true;
	}
	for (IslandAtRest& island : found)
		if (island.grains > 0)
			island.calmPeriods = calmPeriods * std::pow(island.grains, 1. / dim);
	for (int g : active_) {
		IslandAtRest& island = found[islands.of(g)];
		if (periods[g] < island.calmPeriods) island.disturbed = true;
	}
	for (int g : active_) {
		const IslandAtRest& island = found[islands.of(g)];
		if (touched[g] && island.supported && !island.disturbed) rested_.push_back(g);
	}
}

/// The velocities after the step are zero in grains that fall asleep; outside of here they remain
/// what was solved, and where the solver knows them to be (contactProblem).
template <int dim> ContactWork System<dim>::workOfContacts()
{
	std::vector<std::vector<Vec<dim>>> solved;
	for (int g : rested_) {
		std::vector<Vec<dim>>& velocity = bodies_[g].velocity;
		solved.push_back(velocity);
		velocity.assign(velocity.size(), Vec<dim>::Zero());
	}
	const ContactWork work = solver_.work();
	for (std::size_t i = 0; i < rested_.size(); ++i)
		std::copy(solved[i].begin(), solved[i].end(), bodies_[rested_[i]].velocity.begin());
	return work;
}

/// Islands in which something has begun to act, while nothing moves yet, stay awake: what bore them
/// may have gone before this step.
template <int dim>
void System<dim>::keepBalanced(const std::vector<ContactList<dim>*>& lists, double kick)
{
	Islands islands = islandsInContact(lists);
	std::vector<char> isDriven(grains(), 0); // by island
	for (int g : rested_)
		if (!setOf(g).isBalanced(indexInSet(g), kick)) isDriven[islands.of(g)] = 1;
	std::erase_if(rested_, [&](int g) { return isDriven[islands.of(g)]; });
}

template <int dim>
void System<dim>::fallAsleep(const std::vector<ContactList<dim>*>& lists, StepReport& report)
{
	if (rested_.empty()) return;
	keepBalanced(lists, report.kick);
	for (int g : rested_) {
		GrainSet<dim>& set = setOf(g);
		const int k = indexInSet(g);
		report.droppedEnergy += set.kineticEnergy(k);
		report.droppedMomentum += set.fallAsleep(k).norm();
		if (!works_.empty()) works_[g].kinetic = 0;
		resting_[g] = 0;
	}
	for (ContactList<dim>* list : lists) {
		if (list->contacts.empty() || !isAsleep(list->first)) continue;
		list->rest = { report.kick, list->placeOfSecond() };
		++resting_[list->first];
		if (list->second >= 0) ++resting_[list->second];
	}
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void System<dim>::setLoad(int, const BodyLoad<dim>&);                             \
	template void System<dim>::wake(int);                                                      \
	template std::vector<double> System<dim>::sleepNumbers(int) const;                         \
	template void System<dim>::restoreSleep(int, const std::vector<double>&);                  \
	template void System<dim>::measureSleepers();                                              \
	template bool System<dim>::liesStill(const ContactList<dim>&) const;                       \
	template void System<dim>::wakeGrains(const std::vector<ContactList<dim>*>&, double,       \
					      bool);                                               \
	template void System<dim>::findRestedGrains(const std::vector<ContactList<dim>*>&,         \
						    const std::vector<char>&,                      \
						    const StepSettings&);                          \
	template Islands System<dim>::islandsInContact(const std::vector<ContactList<dim>*>&)      \
		const;                                                                             \
	template void System<dim>::keepBalanced(const std::vector<ContactList<dim>*>&, double);    \
	template ContactWork System<dim>::workOfContacts();                                        \
	template void System<dim>::fallAsleep(const std::vector<ContactList<dim>*>&, StepReport&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
