// Interface laws in the step: what they need before the solve, and what their bonds ask of the time
// step.
#include "contact/Pressure.hpp"
#include "step/System.hpp"

#include <algorithm>
#include <map>

namespace softgrain {

template <int dim>
void System<dim>::beginInterfaces(const std::vector<ContactList<dim>*>& lists, double kick,
				  double dt)
{
	rebounds_ = false;
	for (ContactList<dim>* list : lists) {
		if (!list->interface) continue;
		list->interface->begin(kick, dt);
		rebounds_ = rebounds_ || list->interface->law.restitution > 0;
	}
}

/// max_s sum_s' |W_ss'| a_s': no velocity that unit tractions on the outline give in unit time is
/// larger.
template <int dim> double System<dim>::areaMobility(int g) const
{
	const ContactBody<dim>& body = bodies_[g];
	const SparseRows<double>& W = *body.delassus;
	const auto area = body.nodeAreas();
	double largest = 0;
	for (int s = 0; s < body.nodes(); ++s) {
		double sum = 0;
		for (int e = W.begin(s); e < W.end(s); ++e)
			sum += std::abs(W.value[e]) * area[W.column[e]].norm();
		largest = std::max(largest, sum);
	}
	return body.delassusScale * largest;
}

/// What tractions on the contacts of a pair do to its rigid body, as above.
template <int dim> double System<dim>::rigidAreaMobility(const ContactList<dim>& list) const
{
	const ContactBody<dim>& body = bodies_[list.first];
	const RigidPartner<dim>& partner = partners_[list.rigid->partner];
	const auto area = contactAreas<dim>(body, nullptr, list.contacts);
	double sum = 0;
	for (std::size_t k = 0; k < area.size(); ++k)
		if (list.contacts[k].key.side == 0) {
			const Vec<dim> arm = body.contactPoint(list.contacts[k].key.node) -
					     (partner.centre + list.image.shift);
			sum += area[k].area * partner.mobilityAt(arm).trace();
		}
	return sum;
}

/// With bonds of the stiffness K alone the squared frequencies are eigenvalues of W A K, and no
/// larger than its largest sum of a row; they add to those of the grains at most (Weyl).
/// (A free rigid body couples all its contacts.) Sleeping bonds count as when they fell asleep.
template <int dim> void System<dim>::measureBonds(const std::vector<ContactList<dim>*>& lists)
{
	if (!bondsAsleep_) continuation_.bondRate = 0;
	std::map<int, double> mobility, partnerMobility;
	for (const ContactList<dim>* list : lists)
		if (list->rigid && list->interface && list->interface->law.hasBond())
			partnerMobility[list->rigid->partner] += rigidAreaMobility(*list);
	auto mobilityOf = [&](int g) {
		const auto [entry, isNew] = mobility.emplace(g, 0);
		if (isNew) entry->second = areaMobility(g);
		return entry->second;
	};
	for (const ContactList<dim>* list : lists) {
		if (!list->interface || !list->interface->law.hasBond()) continue;
		if (list->contacts.empty()) continue;
		double W = mobilityOf(list->first);
		if (list->second >= 0) W += mobilityOf(list->second);
		if (list->rigid) W += partnerMobility[list->rigid->partner];
		continuation_.bondRate =
			std::max(continuation_.bondRate, list->interface->law.stiffness() * W);
	}
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void System<dim>::beginInterfaces(const std::vector<ContactList<dim>*>&, double,  \
						   double);                                        \
	template void System<dim>::measureBonds(const std::vector<ContactList<dim>*>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
