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
	if (list.isAsleep() && sleepBoth(list)) {
		if (!liesStill(list))
			list.rest.changed = true;
		else if (list.rest.found)
			return false;
	}
	list.rest.found = true;
	return true;
}

/// Both grains of a pair, or the only one.
template <int dim> bool Activity<dim>::sleepBoth(const ContactList<dim>& list) const
{
	return grains_.isAsleep(list.first) && (list.second < 0 || grains_.isAsleep(list.second));
}

/// Whether the bodies of a sleeping pair are still where they were.
template <int dim> bool Activity<dim>::liesStill(const ContactList<dim>& list) const
{
	const bool still =
		list.second >= 0 ? list.image.velocity.isZero(0) : list.hasStillSupport();
	return sleepBoth(list) && still && list.placeOfSecond() == list.rest.placeOfSecond;
}

/// Whether the grain on a side of the pair, which sleeps, touched the other one when it fell
/// asleep, and that is awake now.
template <int dim>
bool Activity<dim>::isHeldBesideAwake(const ContactList<dim>& list, int side) const
{
	return list.second >= 0 && !sleepBoth(list) && list.atRest[side] && !list.rest.changed;
}

/// Of grains that sleep: what something came within reach of, what lost its contacts or got new
/// ones, what lies on something that moved.
template <int dim>
auto Activity<dim>::changesOf(const std::vector<ContactList<dim>*>& lists, bool sleep) const
	-> Changes
{
	Changes changes;
	std::vector<int> resting(grains_.count(), 0);
	for (const ContactList<dim>* list : lists) {
		const bool still = list->isAsleep() && liesStill(*list);
		changes.ofPairs = changes.ofPairs || (!still && list->isKeptForSleepers());
		if (!still && list->contacts.empty()) continue;
		for (int side : { 0, 1 }) {
			const int g = list->grain(side);
			if (g < 0 || !grains_.isAsleep(g)) continue;
			if (still || isHeldBesideAwake(*list, side))
				++resting[g];
			else
				changes.grains.push_back(g);
		}
	}
	for (int g : grains_.asleep())
		if (!sleep || resting[g] != resting_[g]) changes.grains.push_back(g);
	return changes;
}

template <int dim>
void Activity<dim>::wakeChanged(const std::vector<ContactList<dim>*>& lists, double kick,
				bool sleep)
{
	const bool noneRests = std::none_of(lists.begin(), lists.end(), [](const auto* list) {
		return list->isKeptForSleepers();
	});
	if (grains_.asleep().empty() && noneRests) return;
	const Changes changes = changesOf(lists, sleep);
	for (int g : changes.grains)
		wake(g);
	if (changes.ofPairs || !changes.grains.empty()) endRestOf(lists, kick);
	grains_.renewLists();
}

/// Of pairs of which a grain is awake now: impulses become those of a step with this kick, and what
/// they did to it is of no use any more.
template <int dim>
void Activity<dim>::endRestOf(const std::vector<ContactList<dim>*>& lists, double kick)
{
	for (ContactList<dim>* list : lists) {
		for (int side : { 0, 1 })
			if (list->atRest[side] && !grains_.isAsleep(list->grain(side)))
				list->atRest[side].reset();
		if (list->rest.kick == 0 || (list->isAsleep() && sleepBoth(*list))) continue;
		for (Contact<dim>& contact : list->contacts)
			contact.impulse *= kick / list->rest.kick;
		list->rest = {};
	}
}

template <int dim>
void Activity<dim>::noteSleepersBesideAwake(const std::vector<ContactList<dim>*>& lists)
{
	besideAwake_.clear();
	if (grains_.asleep().empty()) return;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty() || list->second < 0) continue;
		for (int g : { list->first, list->second })
			if (grains_.isListedAsleep(g)) besideAwake_.push_back(g);
	}
	std::sort(besideAwake_.begin(), besideAwake_.end());
	besideAwake_.erase(std::unique(besideAwake_.begin(), besideAwake_.end()),
			   besideAwake_.end());
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

/// What decides whether grains of an island may sleep.
struct IslandAtRest {
	int grains = 0;
	double calmPeriods = 0; ///< for which each of them must be calm
	/// By a plane, a rigid body that is held or a sleeper, which take what momentum is left.
	bool supported = false;
	/// By a plane, a rigid body or an image that moves or may be moved.
	bool disturbed = false;
};

} // namespace

/// Of grains that are awake.
template <int dim>
Islands Activity<dim>::islandsInContact(const std::vector<ContactList<dim>*>& lists) const
{
	Islands islands(grains_.count());
	for (const ContactList<dim>* list : lists)
		if (!list->contacts.empty() && list->second >= 0 &&
		    !grains_.isListedAsleep(list->first) && !grains_.isListedAsleep(list->second))
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
			for (int g : { list->first, list->second })
				if (g >= 0) found[islands.of(g)].disturbed = true;
	for (int g : grains_.active())
		++found[islands.of(g)].grains;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty()) continue;
		if (list->second < 0) {
			IslandAtRest& island = found[islands.of(list->first)];
			(list->hasStillSupport() ? island.supported : island.disturbed) = true;
		} else if (grains_.isListedAsleep(list->first))
			found[islands.of(list->second)].supported = true;
		else if (grains_.isListedAsleep(list->second))
			found[islands.of(list->first)].supported = true;
	}
	for (IslandAtRest& island : found)
		if (island.grains > 0)
			island.calmPeriods = calmPeriods * std::pow(island.grains, 1. / dim);
	for (int g : grains_.active()) {
		const IslandAtRest& island = found[islands.of(g)];
		if (touched[g] && island.supported && !island.disturbed &&
		    periods[g] >= island.calmPeriods)
			rested_.push_back(g);
	}
}

/// Grains that touch none but those who rest, and sleepers.
template <int dim> void Activity<dim>::keepAmongRested(const std::vector<ContactList<dim>*>& lists)
{
	if (rested_.empty()) return;
	std::vector<char> rests(grains_.count(), 0);
	for (int g : rested_)
		rests[g] = 1;
	auto isRestless = [&](int g) { return !rests[g] && !grains_.isListedAsleep(g); };
	std::vector<char> amongRested = rests;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty() || list->second < 0) continue;
		if (isRestless(list->first)) amongRested[list->second] = 0;
		if (isRestless(list->second)) amongRested[list->first] = 0;
	}
	std::erase_if(rested_, [&](int g) { return !amongRested[g]; });
}

/// Grains on which something has begun to act, while nothing moves yet, stay awake: what bore them
/// may have gone before this step. So do those whose loads nothing bears: beside the energy of
/// grains that are squeezed hard a weight is small, and what slides under it would stop on its way.
template <int dim>
void Activity<dim>::keepBalanced(const std::vector<ContactList<dim>*>& lists, double kick)
{
	std::erase_if(rested_, [&](int g) {
		GrainSet<dim>& set = grains_.setOf(g);
		const int k = grains_.indexInSet(g);
		return !set.isBalanced(k, kick) || set.isDriven(k, grains_.loads()[g]);
	});
	keepAmongRested(lists);
	Islands islands = islandsInContact(lists);
	std::vector<WholeImpulses> whole(grains_.count());
	for (int g : rested_) {
		const WholeImpulses own = grains_.setOf(g).wholeImpulses(grains_.indexInSet(g),
									 kick, grains_.loads()[g]);
		whole[islands.of(g)].sum += own.sum;
		whole[islands.of(g)].load += own.load;
	}
	std::erase_if(rested_, [&](int g) {
		const WholeImpulses& all = whole[islands.of(g)];
		return all.load > 0 && all.sum > unborneShare * all.load;
	});
}

template <int dim>
DroppedMotion Activity<dim>::fallAsleep(const std::vector<ContactList<dim>*>& lists, double kick)
{
	DroppedMotion dropped;
	if (rested_.empty()) return dropped;
	keepBalanced(lists, kick);
	std::vector<char> fellAsleep(grains_.count(), 0);
	for (int g : rested_) {
		GrainSet<dim>& set = grains_.setOf(g);
		const int k = grains_.indexInSet(g);
		dropped.energy += set.kineticEnergy(k);
		dropped.momentum += set.fallAsleep(k).norm();
		resting_[g] = 0;
		fellAsleep[g] = 1;
	}
	for (ContactList<dim>* list : lists)
		if (!list->contacts.empty()) noteRest(*list, kick, fellAsleep);
	return dropped;
}

namespace {

template <int dim> ForceAtRest<dim> forceOf(const ContactList<dim>& list, double kick)
{
	return { (list.impulse.normal + list.impulse.shear) / kick, list.impulse.point };
}

} // namespace

/// What a pair is kept with of which a grain fell asleep.
template <int dim>
void Activity<dim>::noteRest(ContactList<dim>& list, double kick,
			     const std::vector<char>& fellAsleep)
{
	bool any = false;
	for (int side : { 0, 1 }) {
		const int g = list.grain(side);
		if (g < 0 || !fellAsleep[g]) continue;
		any = true;
		++resting_[g];
		if (list.second >= 0) list.atRest[side].emplace() = forceOf(list, kick);
	}
	if (!any) return;
	list.rest = {};
	if (sleepBoth(list)) list.rest = { kick, list.placeOfSecond() };
}

template <int dim>
double Activity<dim>::wakeStrained(const std::vector<ContactList<dim>*>& lists,
				   const std::vector<ContactList<dim>*>& sleeping, double kick)
{
	double held = 0; // N
	if (besideAwake_.empty()) return held;
	std::vector<double> change(grains_.count(), 0); // N
	auto addChanges = [&](const ContactList<dim>& list, double ofKick) {
		if (list.contacts.empty() || list.second < 0) return 0.;
		const ForceAtRest<dim> now = forceOf(list, ofKick);
		double sum = 0;
		for (int side : { 0, 1 }) {
			const int g = list.grain(side);
			if (!list.atRest[side] || !grains_.isListedAsleep(g)) continue;
			const ForceAtRest<dim>& then = *list.atRest[side];
			const double more = (now.force - then.force).norm();
			const double lever = (now.point - then.point).norm() /
					     surfaces_.bodies()[g].outerRadius();
			change[g] += more + lever * then.force.norm();
			sum += more;
		}
		return sum;
	};
	for (const ContactList<dim>* list : lists)
		held += addChanges(*list, kick);
	for (const ContactList<dim>* list : sleeping) // neighbours that woke and sleep again
		addChanges(*list, list->rest.kick);
	for (int g : besideAwake_)
		if (!grains_.setOf(g).bears(grains_.indexInSet(g), change[g], grains_.loads()[g]))
			wake(g);
	return held * kick;
}

template class Activity<2>;
template class Activity<3>;

} // namespace softgrain
