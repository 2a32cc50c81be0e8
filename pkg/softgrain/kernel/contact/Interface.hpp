// An interface law at work in a pair: what its contacts remember, and the tractions that act on
// them.
//
// Tractions are known at t_n: they act as impulses p = kick * area * traction on the nodes (-w_i p
// on the partners), applied once before the sweeps, which then solve for the reactions r' alone,
//     0 <= u_n + b  _|_  r'_n >= 0,     |r'_t| <= mu r'_n.
// The force of the contact is r' + p. Where nodes of both outlines are contacts, each side stands
// for half of the area.
#pragma once

#include "Vector.hpp"
#include "contact/InterfaceLaw.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace softgrain {

/// Gaps below it, in dr, count as closed: contact dynamics leaves touching nodes that near.
inline constexpr double touchingGap = 0.01;

template <int dim> struct Contact;

/// Whether a contact with this reaction touches, as far as bonds are concerned.
template <int dim> bool touches(const Vec<dim>& reaction, double gap, double pointSpacing)
{
	return !reaction.isZero(0) || gap <= touchingGap * pointSpacing;
}

enum class Bond : int { none, whole, broken };

/// What a contact with an interface law remembers.
template <int dim> struct ContactHistory {
	Vec<dim> pull = Vec<dim>::Zero(); ///< p of the last step on the node, N s
	Vec<dim> slip = Vec<dim>::Zero(); ///< s since the bond formed, m
	double start = 0;                 ///< g_0: gap at which the bond formed, m
	double largest = 0;               ///< L, m
	Bond bond = Bond::none;
	bool slid = false; ///< in the last step in which it carried force
	bool isNew = true; ///< no step has been made with it yet
};

/// A contact of the first body with a rigid one that a search did not find again.
template <int dim> struct VanishedContact {
	int node;
	Vec<dim> normal;
	ContactHistory<dim> history;
};

/// The part of an outline that a contact stands for.
struct ContactArea {
	double area = 0;   ///< m (3D: m^2)
	double spread = 0; ///< from its smallest gap to its largest, m
};

/// What the law needs to know of a contact at t_n.
template <int dim> struct InterfacePlace {
	Vec<dim> normal; ///< to the body on which p acts
	double gap;      ///< m
	ContactArea part;
};

/// What became of a contact in the step.
template <int dim> struct ContactOutcome {
	Vec<dim> normal;     ///< to the body of the node
	Vec<dim> reaction;   ///< r', N s
	Vec<dim> velocity;   ///< u after the step, m/s
	double spin;         ///< 3D: of the other body about the normal, 1/s
	double gap;          ///< at t_n, m
	double pointSpacing; ///< dr of the node's grain, m
	bool ofEnd = false;  ///< of a rigid body, which stands for no area: no bond acts there
};

template <int dim> class PairInterface {
public:
	InterfaceLaw law;
	std::vector<ContactHistory<dim>> history; ///< one for each contact of the pair

	/// For the step at hand: time over which impulses act, length, s.
	void begin(double kick, double dt)
	{
		kick_ = kick;
		dt_ = dt;
	}
	/// p of contact k; breaks the bond if it is due.
	const Vec<dim>& pullOn(std::size_t k, const InterfacePlace<dim>& place);
	/// Bias of contact k if it closes in this step and has a restitution; `before` is u_n half
	/// a step before t_n, `closed` whether it carried force in the last step.
	double biasOf(double bias, double gap, double before, bool closed) const;
	/// mu of contact k, with mu_s = `friction`.
	double frictionOf(std::size_t k, double friction) const
	{
		return history[k].slid && law.hasDynamicFriction() ? law.dynamicFriction : friction;
	}
	/// The same of all contacts.
	std::vector<double> frictions(double friction) const;
	/// What the law asks of the contacts in the step at hand: apply(c, p) hands its impulses
	/// on; if the other body is rigid, so that there may be a restitution, approach(c) is u
	/// half a step before t_n.
	template <class Constraints, class Apply, class Approach>
	void engage(Constraints& constraints, const std::vector<Contact<dim>>& contacts,
		    const std::vector<ContactArea>& areas, bool onRigid, Apply&& apply,
		    Approach&& approach);
	/// Keeps what became of contact k, with mu_s = `friction`; returns its whole impulse, r' +
	/// p.
	Vec<dim> remember(std::size_t k, const ContactOutcome<dim>& outcome, double friction);
	/// Whether a contact that is nowhere bonded bonds as it touches.
	bool bondsAtTouch(const ContactOutcome<dim>& outcome) const;
	/// Bonds contact k if it never was; `outcome` is its own.
	void bondOnce(std::size_t k, const ContactOutcome<dim>& outcome);
	/// Whether a bond holds.
	bool isBonded() const
	{
		return std::any_of(history.begin(), history.end(),
				   [](const auto& h) { return h.bond == Bond::whole; });
	}
	/// Contact k is bonded from now on.
	void bondNow(std::size_t k, double gap);
	/// Share of the stiffness of the bond of contact k that is gone.
	double damage(std::size_t k) const;

	/// Before contacts are searched anew, and after that, for each that is there again: its
	/// number then and now.
	void beginSearch();
	void carry(std::size_t from, std::size_t to);
	/// Of the contacts before the search, those that were not carried and have a history.
	void noteVanished(const std::vector<Contact<dim>>& last);
	/// Those noted since the last step.
	std::vector<VanishedContact<dim>> vanished;
	/// Sizes the history for the contacts found.
	void resize(std::size_t contacts) { history.resize(contacts); }
	/// Bonds that were whole when their contact vanished, since this was last asked.
	long takeLostBonds() { return std::exchange(lost_, 0); }

	/// History as numbers, and back; false, and nothing done, if they are none.
	std::vector<double> numbers() const;
	bool restore(const std::vector<double>& numbers);

private:
	std::vector<ContactHistory<dim>> last_; ///< before the search
	double kick_ = 0, dt_ = 0;
	long lost_ = 0;
};

template <int dim>
template <class Constraints, class Apply, class Approach>
void PairInterface<dim>::engage(Constraints& constraints, const std::vector<Contact<dim>>& contacts,
				const std::vector<ContactArea>& areas, bool onRigid, Apply&& apply,
				Approach&& approach)
{
	const bool rebounds = onRigid && law.restitution > 0;
	for (std::size_t k = 0; k < constraints.size(); ++k) {
		auto& c = constraints[k];
		const double gap = contacts[k].gap;
		const Vec<dim>& p = pullOn(k, { c.normal, gap, areas[k] });
		if (!p.isZero(0)) apply(c, p);
		if (!rebounds) continue;
		c.bias = biasOf(c.bias, gap, approach(c).dot(c.normal), !c.impulse.isZero(0));
	}
}

} // namespace softgrain
