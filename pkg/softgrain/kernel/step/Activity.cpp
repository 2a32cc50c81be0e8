#include "step/Activity.hpp"

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

/// Of the loads of an island in the step in which it falls asleep, what may be left over.
constexpr double unborneShare = 1e-2;

} // namespace

template <int dim> void Activity<dim>::followNewGrains()
{
	for (int g = static_cast<int>(resting_.size()); g < grains_.count(); ++g) {
		const auto& parameters = grains_.setOf(g).parameters(grains_.indexInSet(g));
		damped_ = damped_ || parameters.damping.acts();
		resting_.push_back(-1);
	}
}

template <int dim> void Activity<dim>::wake(int g)
{
	if (!grains_.isAsleep(g)) return;
	grains_.setOf(g).wake(grains_.indexInSet(g));
	resting_[g] = -1;
}

template <int dim> std::vector<double> Activity<dim>::sleepNumbers(int g) const
{
	if (!grains_.isAsleep(g)) return {};
	const BodyLoad<dim>& load = grains_.loads()[g];
	std::vector<double> numbers { static_cast<double>(resting_[g]) };
	numbers.insert(numbers.end(), load.acceleration.data(), load.acceleration.data() + dim);
	numbers.insert(numbers.end(), load.angular.data(), load.angular.data() + dim * dim);
	return numbers;
}

template <int dim> void Activity<dim>::restoreSleep(int g, const std::vector<double>& numbers)
{
	if (numbers.empty()) return;
	requireSize("load and pairs", numbers, 1 + dim + dim * dim);
	resting_[g] = static_cast<int>(numbers[0]);
	grains_.loads()[g] = { Eigen::Map<const Vec<dim>>(&numbers[1]),
			       Eigen::Map<const Mat<dim>>(&numbers[1 + dim]) };
}

template <int dim> bool Activity<dim>::isSearchDue(ContactList<dim>& list) const
{
	if (list.isAsleep()) {
		if (!liesStill(list))
			list.rest.changed = true;
		else if (list.rest.found)
			return false;
	}
	list.rest.found = true;
	return true;
}

/// Whether the bodies of a sleeping pair are still where they were.
template <int dim> bool Activity<dim>::liesStill(const ContactList<dim>& list) const
{
	if (!grains_.isAsleep(list.first)) return false;
	const bool still = list.second >= 0
				   ? grains_.isAsleep(list.second) && list.image.velocity.isZero(0)
				   : list.hasStillSupport();
	return still && list.placeOfSecond() == list.rest.placeOfSecond;
}

/// Of pairs and grains that sleep, or did: what was woken by hand, what something came within reach
/// of, what lost its contacts or got new ones.
template <int dim>
std::vector<int> Activity<dim>::changedGrains(const std::vector<ContactList<dim>*>& lists,
					      bool sleep) const
{
	std::vector<int> changed, resting(grains_.count(), 0);
	for (const ContactList<dim>* list : lists) {
		const bool still = list->isAsleep() && liesStill(*list);
		if (!still && list->contacts.empty()) continue;
		for (int g : { list->first, list->second }) {
			if (g < 0) continue;
			if (still)
				++resting[g];
			else if (grains_.isListedAsleep(g) || list->rest.kick > 0)
				changed.push_back(g);
		}
	}
	for (int g : grains_.asleep())
		if (!sleep || resting[g] != resting_[g]) changed.push_back(g);
	return changed;
}

/// (Impulses become those of a step with this kick.)
template <int dim>
void Activity<dim>::wakeChanged(const std::vector<ContactList<dim>*>& lists, double kick,
				bool sleep)
{
	const bool noneRests = std::none_of(lists.begin(), lists.end(),
					    [](const auto* list) { return list->rest.kick > 0; });
	if (grains_.asleep().empty() && noneRests) return;
	const std::vector<int> changed = changedGrains(lists, sleep);
	if (changed.empty()) return;

	Islands islands(grains_.count());
	for (const ContactList<dim>* list : lists)
		if (list->isAsleep() && list->second >= 0) islands.join(list->first, list->second);
	std::vector<char> wakes(grains_.count(), 0); // by island
	for (int g : changed)
		wakes[islands.of(g)] = 1;
	for (int g : grains_.asleep())
		if (wakes[islands.of(g)]) wake(g);
	for (ContactList<dim>* list : lists) {
		const bool rests = list->isAsleep() && !wakes[islands.of(list->first)];
		if (rests || list->rest.kick == 0) continue;
		for (Contact<dim>& contact : list->contacts)
			contact.impulse *= kick / list->rest.kick;
		list->rest = {};
	}
	grains_.renewLists();
}

template <int dim>
void Activity<dim>::chooseRigidGrains(const std::vector<char>& touched,
				      const StepSettings& settings)
{
	for (int g : grains_.awake()) {
		GrainSet<dim>& set = grains_.setOf(g);
		const int k = grains_.indexInSet(g);
		const bool rigid = settings.rigidMotion && !touched[g] && set.mayMoveRigidly(k);
		if (rigid && !set.isRigid(k)) set.beginRigidMotion(k);
		if (!rigid && set.isRigid(k)) {
			surfaces_.body(g); // the next surface is compared with the present one
			set.endRigidMotion(k);
		}
		if (rigid && settings.sleep && set.isMotionless(k) && grains_.loads()[g].isZero()) {
			set.fallAsleep(k);
			surfaces_.bodies()[g].velocities = {};
			resting_[g] = 0;
		}
	}
	grains_.renewLists();
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
Islands Activity<dim>::islandsInContact(const std::vector<ContactList<dim>*>& lists) const
{
	Islands islands(grains_.count());
	for (const ContactList<dim>* list : lists)
		if (!list->contacts.empty() && list->second >= 0)
			islands.join(list->first, list->second);
	return islands;
}

/// Whether any grain has been calm for long; the periods for which each active one has been.
template <int dim>
bool Activity<dim>::mayComeToRest(const StepSettings& settings, std::vector<double>& periods)
{
	bool any = false;
	for (int g : grains_.active()) {
		periods[g] = grains_.setOf(g).watchRest(grains_.indexInSet(g),
							watchInterval * settings.dt);
		any = any || periods[g] >= calmPeriods;
	}
	return any;
}

template <int dim>
void Activity<dim>::findRested(const std::vector<ContactList<dim>*>& lists,
			       const std::vector<char>& touched, const StepSettings& settings,
			       long step)
{
	rested_.clear();
	if (!settings.sleep || !damped_ || step % watchInterval != 0) return;
	std::vector<double> periods(grains_.count(), 0);
	if (!mayComeToRest(settings, periods)) return;

	Islands islands = islandsInContact(lists);
	std::vector<IslandAtRest> found(grains_.count());
	for (const ContactList<dim>* list : lists)
		if (!list->image.velocity.isZero(0))
			found[islands.of(list->first)].disturbed = true;
	for (int g : grains_.active())
		++found[islands.of(g)].grains;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty() || list->second >= 0) continue;
		IslandAtRest& island = found[islands.of(list->first)];
		(list->hasStillSupport() ? island.supported : island.disturbed) = true;
	}
	for (IslandAtRest& island : found)
		if (island.grains > 0)
			island.calmPeriods = calmPeriods * std::pow(island.grains, 1. / dim);
	for (int g : grains_.active()) {
		IslandAtRest& island = found[islands.of(g)];
		if (periods[g] < island.calmPeriods) island.disturbed = true;
	}
	for (int g : grains_.active()) {
		const IslandAtRest& island = found[islands.of(g)];
		if (touched[g] && island.supported && !island.disturbed) rested_.push_back(g);
	}
}

/// Islands in which something has begun to act, while nothing moves yet, stay awake: what bore them
/// may have gone before this step. So do those whose loads nothing bears: beside the energy of
/// grains that are squeezed hard a weight is small, and what slides under it would stop on its way.
template <int dim>
void Activity<dim>::keepBalanced(const std::vector<ContactList<dim>*>& lists, double kick)
{
	Islands islands = islandsInContact(lists);
	std::vector<char> staysAwake(grains_.count(), 0); // by island
	std::vector<WholeImpulses> whole(grains_.count());
	for (int g : rested_) {
		GrainSet<dim>& set = grains_.setOf(g);
		const int k = grains_.indexInSet(g), island = islands.of(g);
		const BodyLoad<dim>& load = grains_.loads()[g];
		if (!set.isBalanced(k, kick) || set.isDriven(k, load)) staysAwake[island] = 1;
		const WholeImpulses own = set.wholeImpulses(k, kick, load);
		whole[island].sum += own.sum;
		whole[island].load += own.load;
	}
	std::erase_if(rested_, [&](int g) {
		const WholeImpulses& all = whole[islands.of(g)];
		const bool isBorne = all.load == 0 || all.sum <= unborneShare * all.load;
		return staysAwake[islands.of(g)] || !isBorne;
	});
}

template <int dim>
DroppedMotion Activity<dim>::fallAsleep(const std::vector<ContactList<dim>*>& lists, double kick)
{
	DroppedMotion dropped;
	if (rested_.empty()) return dropped;
	keepBalanced(lists, kick);
	for (int g : rested_) {
		GrainSet<dim>& set = grains_.setOf(g);
		const int k = grains_.indexInSet(g);
		dropped.energy += set.kineticEnergy(k);
		dropped.momentum += set.fallAsleep(k).norm();
		resting_[g] = 0;
	}
	for (ContactList<dim>* list : lists) {
		if (list->contacts.empty() || !grains_.isAsleep(list->first)) continue;
		list->rest = { kick, list->placeOfSecond() };
		++resting_[list->first];
		if (list->second >= 0) ++resting_[list->second];
	}
	return dropped;
}

template class Activity<2>;
template class Activity<3>;

} // namespace softgrain
