#include "step/Activity.hpp"
#include "Numbers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace softgrain {

template <int dim> void Activity<dim>::followNewGrains()
{
	for (int g = static_cast<int>(resting_.size()); g < grains_.count(); ++g) {
		const auto& parameters = grains_.setOf(g).parameters(grains_.indexInSet(g));
		damped_ = damped_ || parameters.damping.acts();
		resting_.push_back(-1);
		jolt_.push_back(0);
		hadLoad_.push_back(0);
	}
}

template <int dim> void Activity<dim>::wake(int g)
{
	if (!grains_.isAsleep(g)) return;
	grains_.setOf(g).wake(grains_.indexInSet(g));
	resting_[g] = -1;
}

template <int dim> void Activity<dim>::jolt(int g, double speed, double kick)
{
	wake(g);
	if (kick > 0) joltBy(g, massOf(g) * speed / kick);
}

template <int dim> void Activity<dim>::joltBy(int g, double force)
{
	jolt_[g] += force;
	anyJolt_ = true;
}

template <int dim> double Activity<dim>::massOf(int g) const
{
	const GrainParameters<dim>& grain = parametersOf(g);
	const double volume = grains_.setOf(g).reference().volume * std::pow(grain.radius, dim);
	return grain.constants.density * volume;
}

template <int dim> std::vector<double> Activity<dim>::sleepNumbers(int g) const
{
	if (!grains_.isAsleep(g)) return {};
	const BodyLoad<dim>& load = grains_.loads()[g];
	return numbersOf(resting_[g], load.acceleration, load.angular);
}

template <int dim> void Activity<dim>::restoreSleep(int g, const std::vector<double>& numbers)
{
	if (numbers.empty()) return;
	requireSize("load and pairs", numbers, 1 + dim + dim * dim);
	BodyLoad<dim>& load = grains_.loads()[g];
	NumbersInTurn(numbers).take(resting_[g], load.acceleration, load.angular);
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
	return list.second >= 0 && !sleepBoth(list) && list.atRest[side] && !list.rest.changed &&
	       !feelsJolt(list, side);
}

/// Whether the other grain is awake and pushed otherwise by more than the sleeper bears: what of
/// that reaches it shows at the end of a step only, and is lost until then.
template <int dim> bool Activity<dim>::feelsJolt(const ContactList<dim>& list, int side) const
{
	if (!anyJolt_) return false;
	const int other = list.grain(1 - side);
	return jolt_[other] > 0 && !bears(list.grain(side), jolt_[other], grains_.loads()[other]);
}

/// Whether a sleeper bears a change of the forces on it. One that has no load of its own might bear
/// all of what loads the grain beside it: of that it bears no more than it would of its own.
template <int dim> bool Activity<dim>::bears(int g, double force, const BodyLoad<dim>& beside) const
{
	const BodyLoad<dim>& own = grains_.loads()[g];
	const bool isLoaded = !own.acceleration.isZero(0);
	return grains_.setOf(g).bears(grains_.indexInSet(g), force, isLoaded ? own : beside);
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
	if (!grains_.asleep().empty() || !noneRests) {
		const Changes changes = changesOf(lists, sleep);
		for (int g : changes.grains)
			wake(g);
		if (changes.ofPairs || !changes.grains.empty()) endRestOf(lists, kick);
		grains_.renewLists();
	}
	if (anyJolt_) std::fill(jolt_.begin(), jolt_.end(), 0.);
	anyJolt_ = false;
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

template <int dim>
double Activity<dim>::wakeStrained(const std::vector<ContactList<dim>*>& lists,
				   const std::vector<ContactList<dim>*>& sleeping, double kick)
{
	double held = 0; // N
	if (besideAwake_.empty()) return held;
	std::vector<double> change(grains_.count(), 0); // N
	const BodyLoad<dim> none;
	std::vector<const BodyLoad<dim>*> beside(grains_.count(), &none);
	auto addChanges = [&](const ContactList<dim>& list, double ofKick) {
		if (list.contacts.empty() || list.second < 0) return 0.;
		const ForceAtRest<dim> now = list.meanForce(ofKick);
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
			const BodyLoad<dim>& other = grains_.loads()[list.grain(1 - side)];
			if (!other.acceleration.isZero(0)) beside[g] = &other;
		}
		return sum;
	};
	for (const ContactList<dim>* list : lists)
		held += addChanges(*list, kick);
	for (const ContactList<dim>* list : sleeping) // neighbours that woke and sleep again
		addChanges(*list, list->rest.kick);
	for (int g : besideAwake_)
		if (!bears(g, change[g], *beside[g])) wake(g);
	return held * kick;
}

template class Activity<2>;
template class Activity<3>;

} // namespace softgrain
