#include "contact/solve/PlannedPairs.hpp"
#include "Fetch.hpp"
#include "Threads.hpp"

#include <algorithm>

namespace softgrain {

namespace {

/// More pairs are not kept in the caches from sweep to sweep.
constexpr int pairsInCache = 4000;

/// While one pair is worked on, those that come so many and twice so many after it are asked for:
/// by `prepare` always, by sweeps where pairs do not stay in the caches
/// (doc/decisions/0029-memory.md).
constexpr int pairsAhead = 2;

/// With fewer pairs a colour than this, threads would wait longer than they work.
constexpr int pairsPerThread = 8;

/// A pair of grains has so many times the work of a contact of two rigid bodies.
constexpr int rigidContactsPerPair = 16;

} // namespace

template <int dim>
void PlannedPairs<dim>::plan(const std::vector<ContactList<dim>*>& lists, int grains,
			     std::vector<RigidPartner<dim>>* partners,
			     std::vector<RigidContact<dim>>* rigidContacts)
{
	lists_.clear();
	bodiesOf_.clear();
	listed_.clear();
	partners_ = partners;
	contactsOfRigid_ = rigidContacts;
	for (ContactList<dim>* list : lists) {
		if (list->contacts.empty()) continue;
		lists_.push_back(list);
		bodiesOf_.push_back(
			{ list->first, list->sharedSecond(grains), rigidContactsPerPair });
		listed_.push_back(
			{ list->rigid ? Kind::grainOnRigid : Kind::grains, list->contacts.size() });
	}
	if (rigidContacts)
		for (const RigidContact<dim>& c : *rigidContacts) {
			const bool both =
				(*partners)[c.first].moves() && (*partners)[c.second].moves();
			const int first = (*partners)[c.first].moves() ? c.first : c.second;
			bodiesOf_.push_back({ grains + first, both ? grains + c.second : -1 });
			listed_.push_back({ Kind::rigid, 1 });
		}
	count_ = static_cast<int>(bodiesOf_.size());
	const int bodies = grains + (partners ? static_cast<int>(partners->size()) : 0);
	if (bodies != plannedBodies_ || bodiesOf_ != planned_) {
		plan_ = planSweeps(bodiesOf_, bodies);
		planned_ = bodiesOf_;
		plannedBodies_ = bodies;
	}
	makeRoom();
}

template <int dim> void PlannedPairs<dim>::makeRoom()
{
	slot_.clear();
	constraintsBegin_.clear();
	std::size_t constraints = 0;
	int used[3] = { 0, 0, 0 };
	for (int k = 0, task = 0; k < count_; ++k) {
		while (k == plan_.taskEnd[task])
			++task;
		const Listed& pair = listed_[plan_.pairs[k]];
		slot_.push_back({ pair.kind, used[static_cast<int>(pair.kind)]++, task });
		constraintsBegin_.push_back(constraints);
		if (pair.kind == Kind::grains) constraints += pair.contacts;
	}
	constraintsBegin_.push_back(constraints);
	auto holdAtLeast = [](auto& kept, std::size_t count) {
		if (kept.size() < count) kept.resize(count);
	};
	holdAtLeast(pairs_, used[0]);
	holdAtLeast(rigidPairs_, used[1]);
	holdAtLeast(rigidContacts_, used[2]);
	holdAtLeast(constraints_, constraints);
}

template <int dim>
void PlannedPairs<dim>::prepare(std::vector<ContactBody<dim>>& bodies, double dt,
				const SolverSettings& settings, int threads)
{
	const int listed = static_cast<int>(lists_.size());
	const int work = listed + (count_ - listed) / rigidContactsPerPair;
	threads_ = threadsFor(work / std::max(plan_.colours(), 1), threads, pairsPerThread);
	if (partners_)
		for (RigidPartner<dim>& partner : *partners_)
			partner.noteFree();
	if (dim == 3) noteNodesInContact(bodies);
	forEach(SweepOrder::forwards, [&](int k) {
		fetchForPrepare(k);
		const int pair = plan_.pairs[k];
		if (auto* solver = rigid(k))
			solver->prepare((*contactsOfRigid_)[pair - listed], *partners_, dt);
		else if (auto* solver = grainOnRigid(k))
			solver->prepare(bodies, *lists_[pair], *partners_, dt, settings);
		else
			grains(k)->prepare(bodies, *lists_[pair], dt, settings,
					   &constraints_[constraintsBegin_[k]]);
	});
}

template <int dim>
void PlannedPairs<dim>::noteNodesInContact(std::vector<ContactBody<dim>>& bodies) const
{
	forEach(SweepOrder::forwards, [&](int k) {
		if (rigid(k)) return;
		const ContactList<dim>& list = *lists_[plan_.pairs[k]];
		ContactBody<dim>* first = &bodies[list.first];
		ContactBody<dim>* second = list.second < 0 ? nullptr : &bodies[list.second];
		for (const Contact<dim>& c : list.contacts) {
			const bool onFirst = c.key.body() == 0;
			if (ContactBody<dim>* own = onFirst ? first : second)
				c.forOwnNodes([&](int node, double) { own->noteContactAt(node); });
			if (ContactBody<dim>* other = onFirst ? second : first)
				for (int i = 0; i < c.partners; ++i)
					other->noteContactAt(c.partner[i]);
		}
	});
}

template <int dim> bool PlannedPairs<dim>::stayInCache() const { return count_ <= pairsInCache; }

template <int dim> void PlannedPairs<dim>::fetch(int k, void (PairSolver<dim>::*what)() const) const
{
	if (k < 0 || k >= count_) return;
	if (const auto* pair = grains(k)) (pair->*what)();
}

template <int dim> void PlannedPairs<dim>::fetchForSweep(int k, SweepOrder order) const
{
	if (stayInCache()) return;
	const int ahead = order == SweepOrder::forwards ? pairsAhead : -pairsAhead;
	fetch(k + 2 * ahead, &PairSolver<dim>::fetchConstraints);
	fetch(k + ahead, &PairSolver<dim>::fetchVelocities);
}

template <int dim> void PlannedPairs<dim>::fetchForFinish(int k) const
{
	const int ahead = stayInCache() ? 1 : pairsAhead; // from a near cache it comes soon
	fetch(k + ahead, &PairSolver<dim>::fetchResults);
}

template <int dim> void PlannedPairs<dim>::fetchForPrepare(int k) const
{
	auto listOf = [this](int pair) -> const ContactList<dim>* {
		return pair < count_ && grains(pair) ? lists_[plan_.pairs[pair]] : nullptr;
	};
	const int next = k + pairsAhead;
	if (const auto* list = listOf(next + pairsAhead)) fetchBytes(list, list + 1);
	if (const auto* list = listOf(next))
		fetchBytes(list->contacts.data(), list->contacts.data() + list->contacts.size());
	if (next < count_)
		fetchBytes(constraints_.data() + constraintsBegin_[next],
			   constraints_.data() + constraintsBegin_[next + 1]);
	// a pair of another task may be changed by another thread while it is looked at
	if (threads_ > 1 && next < count_ && slot_[next].task != slot_[k].task) return;
	fetch(next, &PairSolver<dim>::fetchBodies);
	fetch(next, &PairSolver<dim>::fetchVelocities);
}

template <int dim> bool PlannedPairs<dim>::movesRigidBodies(int k) const
{
	if (const auto* contact = rigid(k)) return contact->movesBodies();
	const auto* pair = grainOnRigid(k);
	return pair && pair->movesPartner();
}

template <int dim> void PlannedPairs<dim>::addHeldMotion(int k, HeldMotion<dim>& motion) const
{
	with(k, [&](const auto& pair) { pair.addHeldMotion(motion); });
}

template class PlannedPairs<2>;
template class PlannedPairs<3>;

} // namespace softgrain
