#include "contact/HandOn.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// The velocity of what a list is on, at a place.
template <int dim>
Vec<dim> velocityAt(const Vec<dim>& x, const ContactList<dim>& list, const RigidPartner<dim>& body)
{
	return body.velocityAt(x - (body.centre + list.image.shift)) + list.image.velocity;
}

/// Whether two surfaces move as if they were one at a place: parts of a clump, or prescribed
/// motions that agree.
template <int dim>
bool moveAlike(const ContactList<dim>& a, const ContactList<dim>& b, const Vec<dim>& x,
	       const std::vector<RigidPartner<dim>>& partners)
{
	constexpr double rounding = 1e-6;
	const RigidPartner<dim>&first = partners[a.rigid->partner],
	      &second = partners[b.rigid->partner];
	if (a.rigid->partner != b.rigid->partner && (first.moves() || second.moves())) return false;
	const Vec<dim> u = velocityAt(x, a, first), v = velocityAt(x, b, second);
	return (u - v).norm() <= rounding * std::max(u.norm(), v.norm());
}

/// The history of a contact that appeared where one vanished; nullptr if none did.
template <int dim>
ContactHistory<dim>* heirIn(ContactList<dim>& list, const VanishedContact<dim>& vanished)
{
	const double alongFloor = std::sqrt(0.5); // 45 degrees
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& contact = list.contacts[k];
		if (contact.key.side == 0 && contact.key.node == vanished.node &&
		    list.interface->history[k].isNew &&
		    contact.normal.dot(vanished.normal) > alongFloor)
			return &list.interface->history[k];
	}
	return nullptr;
}

} // namespace

template <int dim>
long handOnHistories(const std::vector<ContactList<dim>*>& lists,
		     const std::vector<ContactBody<dim>>& bodies,
		     const std::vector<RigidPartner<dim>>& partners)
{
	long bonded = 0;
	const auto byGrain = [](const ContactList<dim>* a, const ContactList<dim>* b) {
		return a->first < b->first;
	};
	auto handOn = [&](const ContactList<dim>& from, const VanishedContact<dim>& vanished) {
		const Vec<dim>& x = bodies[from.first].contactPoint(vanished.node);
		const auto [begin, end] =
			std::equal_range(lists.begin(), lists.end(), &from, byGrain);
		for (auto to = begin; to != end; ++to) {
			if (*to == &from || !(*to)->rigid || !(*to)->interface) continue;
			if (!((*to)->interface->law == from.interface->law)) continue;
			ContactHistory<dim>* heir = heirIn(**to, vanished);
			if (!heir || !moveAlike(from, **to, x, partners)) continue;
			*heir = vanished.history;
			heir->isNew = false;
			bonded += heir->bond == Bond::whole;
			return;
		}
	};
	for (const ContactList<dim>* list : lists) {
		if (!list->rigid || !list->interface) continue;
		for (const VanishedContact<dim>& vanished : list->interface->vanished)
			handOn(*list, vanished);
	}
	for (ContactList<dim>* list : lists)
		if (list->interface) list->interface->vanished.clear();
	return bonded;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template long handOnHistories<dim>(const std::vector<ContactList<dim>*>&,                  \
					   const std::vector<ContactBody<dim>>&,                   \
					   const std::vector<RigidPartner<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
