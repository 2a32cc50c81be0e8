// The contacts of a pair in a system of either dimension.
#pragma once

#include "Require.hpp"
#include "assembly/PairContacts.hpp"
#include "step/System.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace softgrain {

template <int dim> class PairContactsOf : public PairContacts {
public:
	PairContactsOf(const System<dim>& system, double z)
		: system_(&system)
		, z_(z)
	{
	}
	bool isInUse() const override
	{
		return !list.contacts.empty() || list.deepest > 0 ||
		       (list.interface && !list.interface->vanished.empty());
	}
	bool isKept() const override { return list.isAsleep() && list.rest.kept; }
	double deepest() const override { return list.deepest; }
	void addMemory(MemoryPieces& memory) const override
	{
		memory.add(*this);
		if (list.isAsleep()) return;
		memory.add(list.contacts);
		memory.add(list.candidates.nodes);
	}
	void setFriction(double coefficient) override
	{
		if (coefficient != list.friction) list.rest.changed = true;
		list.friction = coefficient;
	}
	void setInterface(const std::optional<InterfaceLaw>& law) override
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
	void checkInterface() const override
	{
		if (!unreadable_.empty())
			throw std::invalid_argument(unreadable_ +
						    ": by another version of softgrain?");
		if (!list.interface) {
			require(list.friction >= 0 && std::isfinite(list.friction), "friction",
				list.friction, "[0, inf)");
			return;
		}
		const InterfaceLaw& law = list.interface->law;
		law.validate(list.friction);
		require(law.restitution == 0 || list.second < 0, "restitution", law.restitution,
			"0 between two soft grains");
		require(law.range() <= system_->surfaces().interfaceRange(),
			"range of the interface", law.range(),
			"[0, SoftGrainIntegrator.interfaceRange] m");
		if (!system_->body(list.first).isSurface())
			throw std::invalid_argument(
				"interface laws need soft grains with contact = 'surface'");
	}
	int bondTouching() override
	{
		if (!list.interface || !(lawUnknown_ || list.interface->law.hasBond())) return 0;
		std::set<std::size_t> places;
		for (std::size_t k = 0; k < list.contacts.size(); ++k) {
			const Contact<dim>& c = list.contacts[k];
			const double dr =
				system_->body(list.second >= 0 && c.key.body() == 1 ? list.second
										    : list.first)
					.pointSpacing;
			if (c.gap > touchingGap * dr && c.impulse.isZero(0)) continue;
			if (const auto place = list.placeOfBond(k)) places.insert(*place);
		}
		for (const std::size_t k : places)
			list.interface->bondNow(k, list.contacts[k].gap);
		if (!places.empty()) list.rest.changed = true;
		return static_cast<int>(places.size());
	}
	std::vector<double> interfaceHistory() const override
	{
		return list.interface ? list.interface->numbers() : std::vector<double>();
	}
	void restoreInterface(const std::vector<double>& saved) override
	{
		if (saved.empty()) return;
		list.interface.emplace();
		lawUnknown_ = true;
		if (!list.interface->restore(saved))
			noteUnreadable("its interface was saved", saved);
		list.interface->resize(list.contacts.size());
	}

	void setImageVelocity(const Vec3& velocity) override
	{
		list.image.velocity = toKernel<dim>(velocity);
	}
	void setPlaneVelocity(const Vec3& velocity) override
	{
		list.plane.velocity = toKernel<dim>(velocity);
	}

	bool hasRigidBody() const override { return list.rigid.has_value(); }
	void setPartner(int partner) override { list.rigid->partner = partner; }

	bool isOfTwoGrains() const override { return list.second >= 0; }
	int firstGrain() const override { return list.first; }
	void swapGrains() override
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
	}
	SumOfImpulses impulse() const override
	{
		SumOfImpulses sum;
		sum.contacts = static_cast<int>(list.contacts.size());
		if (sum.contacts == 0) return sum;
		sum.active = list.impulse.active;
		sum.normal = toSpace<dim>(list.impulse.normal);
		sum.shear = toSpace<dim>(list.impulse.shear);
		sum.point = toSpace<dim>(list.impulse.point, z_);
		sum.moment = angularToSpace<dim>(list.impulse.moment);
		sum.direction = toSpace<dim>(direction());
		return sum;
	}

	std::vector<ContactRecord> records() const override
	{
		std::vector<ContactRecord> result;
		for (const Contact<dim>& c : list.contacts) {
			result.push_back({ c.key, toSpace<dim>(pointOf(c), z_),
					   toSpace<dim>(c.normal), toSpace<dim>(c.impulse),
					   c.gap });
			if constexpr (dim == 3) result.back().twist = c.twist;
		}
		if (!list.interface) return result;
		for (std::size_t k = 0; k < result.size(); ++k) {
			const ContactHistory<dim>& h = list.interface->history[k];
			result[k].pull = toSpace<dim>(h.pull);
			result[k].bond = h.bond;
			if (h.bond != Bond::none) result[k].damage = damageOf(h);
		}
		return result;
	}

	std::vector<ContactPressure> pressures() const override
	{
		if (list.contacts.empty()) return {};
		std::vector<Contact<dim>> forces;
		if (list.interface) {
			forces = list.contacts;
			for (std::size_t k = 0; k < forces.size(); ++k)
				forces[k].impulse += list.interface->history[k].pull;
		}
		return contactPressures<dim>(system_->body(list.first),
					     list.second < 0 ? nullptr
							     : &system_->body(list.second),
					     list.interface ? forces : list.contacts, kick());
	}
	double kick() const override
	{
		return list.isAsleep() ? list.rest.kick : system_->lastKick();
	}

	void restore(const std::vector<ContactRecord>& saved) override
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

	OverlapAccount account() const override { return list.account; }
	void restoreAccount(const OverlapAccount& saved) override { list.account = saved; }

	std::vector<double> rest() const override
	{
		if (list.rest.changed || !list.isKeptForSleepers()) return {};
		const PairImpulse<dim>& sum = list.impulse;
		std::vector<double> numbers { list.rest.kick, list.friction,
					      static_cast<double>(sum.active),
					      static_cast<double>(list.rest.placeOfSecond.size()) };
		auto append = [&](const auto& part) {
			numbers.insert(numbers.end(), part.begin(), part.end());
		};
		append(sum.normal);
		append(sum.shear);
		append(sum.point);
		append(sum.moment);
		append((list.interface ? list.interface->law : InterfaceLaw()).numbers());
		for (const auto& force : list.atRest) {
			numbers.push_back(force.has_value());
			append(force ? force->force : Vec<dim>::Zero().eval());
			append(force ? force->point : Vec<dim>::Zero().eval());
		}
		append(list.rest.placeOfSecond);
		return numbers;
	}
	void restoreRest(const std::vector<double>& saved) override
	{
		if (saved.empty()) return;
		PairImpulse<dim>& sum = list.impulse;
		InterfaceLaw::Numbers law;
		const long scalars = 4, spins = sum.moment.size(), forces = 2 * (1 + 2 * dim);
		const long size = static_cast<long>(saved.size());
		const long numbers =
			scalars + 3 * dim + spins + static_cast<long>(law.size()) + forces;
		if (size < numbers || static_cast<double>(size - numbers) != saved[3]) {
			noteUnreadable("it was saved asleep", saved);
			return;
		}
		list.friction = saved[1];
		sum.active = static_cast<int>(saved[2]);
		auto from = saved.begin() + scalars;
		auto take = [&](auto& part) {
			std::copy_n(from, part.size(), part.begin());
			from += part.size();
		};
		take(sum.normal);
		take(sum.shear);
		take(sum.point);
		take(sum.moment);
		take(law);
		if (list.interface) { // what it rests with, to be compared with the one to come
			list.interface->law = InterfaceLaw::fromNumbers(law);
			lawUnknown_ = false;
		}
		for (auto& atRest : list.atRest) {
			ForceAtRest<dim> force;
			const bool has = *from++ != 0;
			take(force.force);
			take(force.point);
			if (has) atRest.emplace() = force;
		}
		list.rest = { saved[0], { from, saved.end() }, false, false };
	}

	ContactList<dim> list;

private:
	/// Key and impulse. (All grains have contact of one kind; after loading it is not known yet
	/// which are of this pair.)
	Contact<dim> asSeenFromSecond(Contact<dim> c) const
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
	/// For later: searches run in parallel, where nothing may be thrown.
	void noteUnreadable(const std::string& what, const std::vector<double>& saved)
	{
		unreadable_ = what + " with " + std::to_string(saved.size()) + " figures";
	}
	/// Where contacts only push, that is the direction of the sum; where others pull, they must
	/// not cancel.
	Vec<dim> direction() const
	{
		if (!list.interface) return list.impulse.normal.stableNormalized();
		Vec<dim> sum = Vec<dim>::Zero();
		for (std::size_t k = 0; k < list.contacts.size(); ++k) {
			const Contact<dim>& c = list.contacts[k];
			const Vec<dim> r = c.impulse + list.interface->history[k].pull;
			sum += (c.key.body() == 0 ? 1 : -1) * std::abs(r.dot(c.normal)) * c.normal;
		}
		return sum.stableNormalized();
	}

	/// Nodes of the common grid have other numbers once the grain has moved, and some get
	/// nothing any more: of these the mean contact point is told.
	Vec<dim> pointOnGrid(const Contact<dim>& c) const
	{
		for (const GridNode<dim>& node : system_->body(list.first).gridNode)
			if (node.name() == c.key.other) return node.centre;
		return list.impulse.point;
	}

	/// A rigid body has no nodes: there it is the place that bears it.
	Vec<dim> pointOf(const Contact<dim>& c) const
	{
		const bool onFirst = c.key.body() == 0;
		if (onFirst && system_->body(list.first).isOnGrid()) return pointOnGrid(c);
		Vec<dim> place = Vec<dim>::Zero();
		const auto touched = [&](int body) {
			c.forOwnNodes([&](int node, double w) {
				place +=
					w * system_->body(body).touchedPoint(node, c.normal, c.gap);
			});
			return place;
		};
		if (onFirst) return touched(list.first);
		if (!list.rigid) return touched(list.second) + list.image.shift;
		for (int i = 0; i < c.partners; ++i)
			place += c.weight[i] * system_->body(list.first).position[c.partner[i]];
		return place;
	}

	/// Share of the stiffness that is gone.
	double damageOf(const ContactHistory<dim>& h) const
	{
		const InterfaceLaw& law = list.interface->law;
		if (h.bond == Bond::broken || !law.hasBond()) return 1;
		return 1 - law.secantStiffness(h.largest) / law.stiffness();
	}

	const System<dim>* system_;
	double z_;
	bool lawUnknown_ = false; ///< history was restored, the law is still to come
	std::string unreadable_;  ///< what cannot be restored
};

static_assert((sizeof(PairContactsOf<2>) + 63) / 64 * 64 == PairContacts::size2D);

} // namespace softgrain
