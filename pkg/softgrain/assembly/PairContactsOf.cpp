#include "assembly/PairContactsOf.hpp"
#include "Numbers.hpp"
#include "Require.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace softgrain {

template <int dim> bool PairContactsOf<dim>::isInUse() const
{
	return !list.contacts.empty() || list.deepest > 0 ||
	       (list.interface && !list.interface->vanished.empty());
}

template <int dim> void PairContactsOf<dim>::addMemory(MemoryPieces& memory) const
{
	memory.add(*this);
	if (list.isAsleep()) return;
	memory.add(list.contacts);
	memory.add(list.candidates.nodes);
}

template <int dim> void PairContactsOf<dim>::setFriction(double coefficient)
{
	if (coefficient != list.friction) list.rest.changed = true;
	list.friction = coefficient;
}

template <int dim> void PairContactsOf<dim>::setInterface(const std::optional<InterfaceLaw>& law)
{
	const bool had = list.interface && !lawUnknown_;
	const bool same = law ? had && *law == list.interface->law : !list.interface;
	if (same) return;
	if (!lawUnknown_) list.rest.changed = true;
	lawUnknown_ = false;
	if (!law) {
		list.interface.reset();
		return;
	}
	if (!list.interface) list.interface.emplace();
	list.interface->law = *law;
	list.interface->resize(list.contacts.size());
}

template <int dim> void PairContactsOf<dim>::checkInterface() const
{
	if (!unreadable_.empty())
		throw std::invalid_argument(unreadable_ + ": by another version of softgrain?");
	if (!list.interface) {
		require(list.friction >= 0 && std::isfinite(list.friction), "friction",
			list.friction, "[0, inf)");
		return;
	}
	const InterfaceLaw& law = list.interface->law;
	law.validate(list.friction);
	require(law.restitution == 0 || list.second < 0, "restitution", law.restitution,
		"0 between two soft grains");
	require(law.range() <= system_->surfaces().interfaceRange(), "range of the interface",
		law.range(), "[0, SoftGrainIntegrator.interfaceRange] m");
	if (!system_->body(list.first).isSurface())
		throw std::invalid_argument(
			"interface laws need soft grains with contact = 'surface'");
}

template <int dim> int PairContactsOf<dim>::bondTouching()
{
	if (!list.interface || !(lawUnknown_ || list.interface->law.hasBond())) return 0;
	std::set<std::size_t> places;
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Contact<dim>& c = list.contacts[k];
		const double dr = system_->body(list.second >= 0 && c.key.body() == 1 ? list.second
										      : list.first)
					  .pointSpacing;
		if (!touches<dim>(c.impulse, c.gap, dr)) continue;
		if (const auto place = list.placeOfBond(k)) places.insert(*place);
	}
	for (const std::size_t k : places)
		list.interface->bondNow(k, list.contacts[k].gap);
	if (!places.empty()) list.rest.changed = true;
	return static_cast<int>(places.size());
}

template <int dim> void PairContactsOf<dim>::restoreInterface(const std::vector<double>& saved)
{
	if (saved.empty()) return;
	list.interface.emplace();
	lawUnknown_ = true;
	if (!list.interface->restore(saved))
		noteUnreadable("its interface was saved with", saved.size());
	list.interface->resize(list.contacts.size());
}

template <int dim> void PairContactsOf<dim>::swapGrains()
{
	using Entry = std::pair<Contact<dim>, ContactHistory<dim>>;
	std::vector<Entry> entries;
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		entries.push_back({ asSeenFromSecond(list.contacts[k]), {} });
		if (list.interface) entries.back().second = list.interface->history[k];
	}
	std::sort(entries.begin(), entries.end(),
		  [](const Entry& a, const Entry& b) { return a.first.key < b.first.key; });
	for (std::size_t k = 0; k < entries.size(); ++k) {
		list.contacts[k] = entries[k].first;
		if (list.interface) list.interface->history[k] = entries[k].second;
	}
	list.impulse.normal *= -1;
	list.impulse.shear *= -1;
	std::swap(list.atRest[0], list.atRest[1]);
	for (auto& atRest : list.atRest)
		if (atRest) atRest->force *= -1;
	if (list.second >= 0) std::swap(list.first, list.second);
	seeImageFromSecond();
}

/// What lay beside the first grain, and the image of the second, now lies beside the second and the
/// image of the first, one shift of images farther back.
template <int dim> void PairContactsOf<dim>::seeImageFromSecond()
{
	std::vector<double>& place = list.rest.placeOfSecond;
	if (place.size() != dim) return; // no image
	const Vec<dim> shift = Eigen::Map<const Vec<dim>>(place.data());
	list.impulse.point -= shift;
	for (auto& atRest : list.atRest)
		if (atRest) atRest->point -= shift;
	for (double& component : place)
		component = -component;
}

template <int dim> SumOfImpulses PairContactsOf<dim>::impulse() const
{
	SumOfImpulses sum;
	sum.contacts = static_cast<int>(list.contacts.size());
	if (sum.contacts == 0) return sum;
	sum.active = list.impulse.active;
	sum.normal = toSpace<dim>(list.impulse.normal);
	sum.shear = toSpace<dim>(list.impulse.shear);
	sum.point = toSpace<dim>(list.impulse.point, z_);
	sum.moment = angularToSpace<dim>(list.impulse.moment);
	sum.direction = toSpace<dim>(list.direction());
	return sum;
}

template <int dim> std::vector<ContactRecord> PairContactsOf<dim>::records() const
{
	std::vector<ContactRecord> result;
	for (const Contact<dim>& c : list.contacts) {
		result.push_back({ c.key, toSpace<dim>(pointOf(c), z_), toSpace<dim>(c.normal),
				   toSpace<dim>(c.impulse), c.gap });
		if constexpr (dim == 3) result.back().twist = c.twist;
	}
	if (!list.interface) return result;
	for (std::size_t k = 0; k < result.size(); ++k) {
		const ContactHistory<dim>& h = list.interface->history[k];
		result[k].pull = toSpace<dim>(h.pull);
		result[k].bond = h.bond;
		if (h.bond != Bond::none) result[k].damage = list.interface->damage(k);
	}
	return result;
}

template <int dim> std::vector<ContactPressure> PairContactsOf<dim>::pressures() const
{
	if (list.contacts.empty()) return {};
	std::vector<Contact<dim>> forces;
	if (list.interface) {
		forces = list.contacts;
		for (std::size_t k = 0; k < forces.size(); ++k)
			forces[k].impulse += list.interface->history[k].pull;
	}
	return contactPressures<dim>(system_->body(list.first),
				     list.second < 0 ? nullptr : &system_->body(list.second),
				     list.interface ? forces : list.contacts, kick());
}

template <int dim> void PairContactsOf<dim>::restore(const std::vector<ContactRecord>& saved)
{
	list.contacts.clear();
	if (list.interface) list.interface->beginSearch();
	for (const ContactRecord& record : saved) {
		Contact<dim> c;
		c.key = record.key;
		c.impulse = toKernel<dim>(record.impulse);
		c.normal = toKernel<dim>(record.normal);
		c.setTwist(record.twist);
		list.contacts.push_back(c);
	}
}

template <int dim> std::vector<double> PairContactsOf<dim>::rest() const
{
	if (list.rest.changed || !list.isKeptForSleepers()) return {};
	const PairImpulse<dim>& sum = list.impulse;
	std::vector<double> numbers =
		numbersOf(list.rest.kick, list.friction, sum.active, list.rest.placeOfSecond.size(),
			  sum.normal, sum.shear, sum.point, sum.moment,
			  (list.interface ? list.interface->law : InterfaceLaw()).numbers());
	for (const auto& kept : list.atRest) {
		const ForceAtRest<dim> force = kept ? *kept : ForceAtRest<dim> {};
		append(numbers, kept.has_value(), force.force, force.point);
	}
	append(numbers, list.rest.placeOfSecond);
	return numbers;
}

template <int dim> void PairContactsOf<dim>::restoreRest(const std::vector<double>& saved)
{
	if (saved.empty()) return;
	PairImpulse<dim>& sum = list.impulse;
	InterfaceLaw::Numbers law;
	const long scalars = 4, forces = 2 * (1 + 2 * dim);
	const long size = static_cast<long>(saved.size());
	const long numbers =
		scalars + 3 * dim + spins<dim> + static_cast<long>(law.size()) + forces;
	if (size < numbers || static_cast<double>(size - numbers) != saved[3]) {
		noteUnreadable("it was saved asleep with", saved.size());
		return;
	}
	NumbersInTurn in(saved);
	const double kick = in.next<double>();
	in.take(list.friction, sum.active);
	in.next<double>(); // the size looked at above
	in.take(sum.normal, sum.shear, sum.point, sum.moment, law);
	if (list.interface) { // what it rests with, to be compared with the one to come
		list.interface->law = InterfaceLaw::fromNumbers(law);
		lawUnknown_ = false;
	}
	for (auto& atRest : list.atRest) {
		ForceAtRest<dim> force;
		const bool has = in.next<bool>();
		in.take(force.force, force.point);
		if (has) atRest.emplace() = force;
	}
	list.rest = { kick, in.rest(), false, false };
}

template <int dim>
void PairContactsOf<dim>::noteUnreadable(const std::string& what, std::size_t figures)
{
	unreadable_ = what + " " + std::to_string(figures) + " figures";
}

template <int dim> Contact<dim> PairContactsOf<dim>::asSeenFromSecond(Contact<dim> c) const
{
	const ContactBody<dim>& body = system_->body(std::max(list.first, 0));
	if (body.isSurface() && !c.key.isOfEdges()) {
		c.key.side ^= 1;
		return c;
	}
	c.impulse = -c.impulse;
	c.normal = -c.normal;
	if (!body.isOnGrid()) std::swap(c.key.node, c.key.other);
	return c;
}

template <int dim> Vec<dim> PairContactsOf<dim>::pointOnGrid(const Contact<dim>& c) const
{
	for (const GridNode<dim>& node : system_->body(list.first).gridNode)
		if (node.name() == c.key.other) return node.centre;
	return list.impulse.point;
}

template <int dim> Vec<dim> PairContactsOf<dim>::pointOf(const Contact<dim>& c) const
{
	const bool onFirst = c.key.body() == 0;
	if (onFirst && system_->body(list.first).isOnGrid()) return pointOnGrid(c);
	Vec<dim> place = Vec<dim>::Zero();
	const auto touched = [&](int body) {
		c.forOwnNodes([&](int node, double w) {
			place += w * system_->body(body).touchedPoint(node, c.normal, c.gap);
		});
		return place;
	};
	if (onFirst) return touched(list.first);
	if (!list.rigid) return touched(list.second) + list.image.shift;
	for (int i = 0; i < c.partners; ++i)
		place += c.weight[i] * system_->body(list.first).position[c.partner[i]];
	return place;
}

template class PairContactsOf<2>;
template class PairContactsOf<3>;

} // namespace softgrain
