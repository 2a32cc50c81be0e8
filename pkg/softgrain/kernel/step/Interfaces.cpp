#include "step/Interfaces.hpp"
#include "contact/Pressure.hpp"

#include <algorithm>
#include <map>

namespace softgrain {

template <int dim>
void Interfaces<dim>::begin(const std::vector<ContactList<dim>*>& lists, double kick, double dt)
{
	rebound_ = false;
	for (ContactList<dim>* list : lists) {
		if (!list->interface) continue;
		list->interface->begin(kick, dt);
		rebound_ = rebound_ || list->interface->law.restitution > 0;
	}
}

namespace {

template <int dim> bool hasBond(const ContactList<dim>& list)
{
	return list.interface && list.interface->law.hasBond();
}

/// max_s sum_s' |W_ss'| a_s': no velocity that unit tractions on the outline give in unit time is
/// larger.
template <int dim> double areaMobility(const ContactBody<dim>& body)
{
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
template <int dim>
double rigidAreaMobility(const ContactList<dim>& list, const ContactBody<dim>& body,
			 const RigidPartner<dim>& partner)
{
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

} // namespace

template <int dim> void Interfaces<dim>::noteSleepers(const std::vector<ContactList<dim>*>& lists)
{
	bondsAsleep_ = std::any_of(lists.begin(), lists.end(), [](const ContactList<dim>* list) {
		return list->isKeptForSleepers() && hasBond(*list);
	});
}

/// With bonds of the stiffness K alone the squared frequencies are eigenvalues of W A K, and no
/// larger than its largest sum of a row; they add to those of the grains at most (Weyl).
/// (A free rigid body couples all its contacts.)
template <int dim>
void Interfaces<dim>::measureBonds(const std::vector<ContactList<dim>*>& lists,
				   const std::vector<ContactBody<dim>>& bodies,
				   const std::vector<RigidPartner<dim>>& partners)
{
	if (!bondsAsleep_) bondRate_ = 0;
	std::map<int, double> mobility, partnerMobility;
	for (const ContactList<dim>* list : lists)
		if (list->rigid && hasBond(*list)) {
			const int partner = list->rigid->partner;
			partnerMobility[partner] +=
				rigidAreaMobility(*list, bodies[list->first], partners[partner]);
		}
	auto mobilityOf = [&](int g) {
		const auto [entry, isNew] = mobility.emplace(g, 0);
		if (isNew) entry->second = areaMobility(bodies[g]);
		return entry->second;
	};
	for (const ContactList<dim>* list : lists) {
		if (!hasBond(*list) || list->contacts.empty()) continue;
		double W = mobilityOf(list->first);
		if (list->second >= 0) W += mobilityOf(list->second);
		if (list->rigid) W += partnerMobility[list->rigid->partner];
		bondRate_ = std::max(bondRate_, list->interface->law.stiffness() * W);
	}
}

template class Interfaces<2>;
template class Interfaces<3>;

} // namespace softgrain
