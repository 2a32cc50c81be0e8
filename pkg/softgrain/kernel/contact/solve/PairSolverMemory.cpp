// What of the memory of a pair is asked for before it is worked on
// (doc/decisions/0029-memory.md).
#include "Fetch.hpp"
#include "contact/solve/PairSolver.hpp"

#include <algorithm>
#include <limits>

namespace softgrain {

template <int dim> void PairSolver<dim>::findStretch(BodySide<dim>& side, bool ofFirst) const
{
	side.firstRead = std::numeric_limits<int>::max();
	side.endOfRead = 0;
	for (const Constraint& c : constraints_) {
		auto note = [&](int node, double = 1) {
			side.firstRead = std::min(side.firstRead, node);
			side.endOfRead = std::max(side.endOfRead, node + 1);
		};
		if (c.onFirst == ofFirst)
			forOwnNodes<dim>(c, c.node, note);
		else
			note(c.partner[0]);
	}
}

template <int dim> void PairSolver<dim>::fetchConstraints() const
{
	fetchBytes(constraints_.begin(), constraints_.end());
}

template <int dim> void PairSolver<dim>::fetchBodies() const
{
	for (const ContactBody<dim>* body : { first_, second_ }) {
		if (!body) continue;
		fetchBytes(&body->pointSpacing, &body->pointSpacing + 1);
		fetchBytes(&body->delassus, &body->velocityBefore);
	}
}

/// Of nodes that feel the contacts from farther off than this only time is lost.
template <int dim> void PairSolver<dim>::fetchVelocities() const
{
	constexpr int nodesAside = 8;
	for (const BodySide<dim>* side : { &firstSide_, &secondSide_ }) {
		if (!side->velocity) continue;
		fetchBytes(side->velocity + std::max(side->firstRead - nodesAside, 0),
			   side->velocity + side->endOfRead + nodesAside);
	}
}

template <int dim> void PairSolver<dim>::fetchResults() const
{
	fetchBytes(list_->contacts.data(), list_->contacts.data() + list_->contacts.size());
	fetchBytes(&list_->impulse, &list_->impulse + 1);
	for (const BodySide<dim>* side : { &firstSide_, &secondSide_ }) {
		if (!side->body) continue;
		for (const auto* field : { &side->body->position, &side->body->impulse })
			fetchBytes(field->data() + side->firstRead,
				   field->data() + side->endOfRead);
	}
}

template void PairSolver<2>::findStretch(BodySide<2>&, bool) const;
template void PairSolver<2>::fetchConstraints() const;
template void PairSolver<2>::fetchBodies() const;
template void PairSolver<2>::fetchVelocities() const;
template void PairSolver<2>::fetchResults() const;
template void PairSolver<3>::findStretch(BodySide<3>&, bool) const;
template void PairSolver<3>::fetchConstraints() const;
template void PairSolver<3>::fetchBodies() const;
template void PairSolver<3>::fetchVelocities() const;
template void PairSolver<3>::fetchResults() const;

} // namespace softgrain
