// Which grains came to rest, and how they fall asleep (doc/decisions/0014-inactive-grains.md).
#include "step/Activity.hpp"

#include <cmath>

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
		if (list.second >= 0) list.atRest[side].emplace() = list.meanForce(kick);
	}
	if (!any) return;
	list.rest = {};
	if (sleepBoth(list)) list.rest = { kick, list.placeOfSecond() };
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void Activity<dim>::findRested(const std::vector<ContactList<dim>*>&,             \
						const std::vector<char>&, const StepSettings&,     \
						long);                                             \
	template DroppedMotion Activity<dim>::fallAsleep(const std::vector<ContactList<dim>*>&,    \
							 double);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
