#include "contact/search/Search.hpp"
#include "contact/search/CornerSearch.hpp"
#include "contact/search/PlaceOnOutline.hpp"
#include "contact/search/RigidSearch.hpp"
#include "contact/search/SmoothSearch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>

namespace softgrain {

namespace {

template <int dim>
void disksAgainstDisks(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		       double reach, ContactList<dim>& list)
{
	const double touch = first.nodeRadius + second.nodeRadius;
	// the boxes hold the disks of their own body; the centres looked for lie one more radius
	// out
	const auto others = second.nodesIn(first.box.grown(reach + second.nodeRadius));
	if (others.empty()) return;
	const auto nodes = first.nodesIn(second.box.grown(reach + first.nodeRadius));
	list.tested += static_cast<int>(nodes.size());
	for (int s : nodes)
		for (int t : others) {
			const Vec<dim> apart = first.position[s] - second.position[t];
			if (apart.squaredNorm() >= (touch + reach) * (touch + reach)) continue;
			Contact<dim> contact;
			contact.key = { 0, s, t };
			contact.partners = 1;
			contact.partner[0] = t;
			contact.weight[0] = 1;
			contact.normal = apart.normalized();
			contact.gap = apart.norm() - touch;
			list.noteOverlap(contact.gap, meanSpacing(first, second));
			list.contacts.push_back(contact);
		}
}

/// ContactGeometry::surface: nodes of each of two bodies against the outline of the other.
template <int dim>
void nodesAgainstOutlines(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
			  double reach, ContactList<dim>& list)
{
	const bool corners = first.mesh->hasCorners() || second.mesh->hasCorners();
	const bool irregular = first.mesh->irregular || second.mesh->irregular;
	if (corners || irregular)
		findContactsAtCorners(first, second, reach, list);
	else
		findContactsOfSmoothOutlines(first, second, reach, list);
}

/// Nodes of the common grid that get mass from both bodies. The normal is that of the difference of
/// their mass gradients; the gap compares the centres of what each of them gives.
template <int dim>
void nodesOnCommonGrid(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		       double reach, ContactList<dim>& list)
{
	list.tested += static_cast<int>(first.gridNode.size());
	auto other = second.gridNode.begin();
	for (auto node = first.gridNode.begin(); node != first.gridNode.end(); ++node) {
		while (other != second.gridNode.end() && other->index < node->index)
			++other;
		if (other == second.gridNode.end()) return;
		if (other->index != node->index) continue;
		Contact<dim> contact;
		contact.normal = (other->gradient - node->gradient).normalized();
		contact.gap = (node->centre - other->centre).dot(contact.normal) -
			      gridContactDistance * first.gridSpacing;
		if (contact.gap >= reach) continue;
		list.noteOverlap(contact.gap, meanSpacing(first, second));
		contact.key = { 0, static_cast<int>(node - first.gridNode.begin()), node->name() };
		contact.partners = 1;
		contact.partner[0] = static_cast<int>(other - second.gridNode.begin());
		contact.weight[0] = 1;
		list.contacts.push_back(contact);
	}
}

/// The same with a wall, which stands for a mirror image of the body: half the contact distance.
template <int dim>
void nodesOnCommonGrid(const ContactOutline<dim>& body, double reach, ContactList<dim>& list)
{
	list.tested += static_cast<int>(body.gridNode.size());
	for (std::size_t J = 0; J < body.gridNode.size(); ++J) {
		const GridNode<dim>& node = body.gridNode[J];
		Vec<dim> x;
		for (int a = 0; a < dim; ++a)
			x[a] = node.index[a] * body.gridSpacing;
		if ((x - list.plane.point).dot(list.plane.normal) >= body.gridSpacing) continue;
		Contact<dim> contact;
		contact.normal = list.plane.normal;
		contact.gap = (node.centre - list.plane.point).dot(contact.normal) -
			      0.5 * gridContactDistance * body.gridSpacing;
		if (contact.gap >= reach) continue;
		list.noteOverlap(contact.gap, body.pointSpacing);
		contact.key = { 0, static_cast<int>(J), node.name() };
		list.contacts.push_back(contact);
	}
}

/// Empties the list; returns the contacts it had. They stay valid until the next search of this
/// thread: memory goes round among the lists, none is asked for in every step.
template <int dim> const std::vector<Contact<dim>>& beginSearch(ContactList<dim>& list)
{
	thread_local std::vector<Contact<dim>> last;
	last.swap(list.contacts);
	list.clearContacts();
	list.tested = 0;
	return last;
}

/// Grid nodes have no lasting number in a body, but a name in the grid.
template <int dim>
void carryImpulsesByName(const std::vector<Contact<dim>>& last, ContactList<dim>& list)
{
	std::vector<Contact<dim>>& present = list.contacts;
	if (list.interface) list.interface->resize(present.size()); // refused, and to be read
	std::map<int, Vec<dim>> known;
	for (const Contact<dim>& contact : last)
		known.emplace(contact.key.other, contact.impulse);
	for (Contact<dim>& contact : present) {
		const auto old = known.find(contact.key.other);
		if (old != known.end()) contact.impulse = old->second;
	}
}

/// Calls with the numbers, then and now, of the contacts that are still there (both lists are
/// sorted by key).
template <int dim, class Visit>
void forEachStillThere(const std::vector<Contact<dim>>& last,
		       const std::vector<Contact<dim>>& present, Visit&& visit)
{
	std::size_t old = 0;
	for (std::size_t k = 0; k < present.size(); ++k) {
		const ContactKey& key = present[k].key;
		while (old < last.size() && last[old].key < key)
			++old;
		if (old < last.size() && last[old].key == key) visit(old++, k);
	}
}

/// A vector turned as the normal of its contact has turned. (Normals far from each other are those
/// of two places.)
Vec<2> turnedWith(const Vec<2>& last, const Vec<2>& normal, const Vec<2>& r)
{
	const double c = last.dot(normal), s = cross(last, normal);
	if (last == normal || !(c > 0)) return r;
	return { c * r[0] - s * r[1], s * r[0] + c * r[1] };
}
Vec<3> turnedWith(const Vec<3>& last, const Vec<3>& normal, const Vec<3>& r)
{
	const double c = last.dot(normal);
	if (last == normal || !(c > 0)) return r;
	const Vec<3> axis = last.cross(normal);
	return c * r + axis.cross(r) + axis.dot(r) / (1 + c) * axis;
}

/// The impulse of a contact as its normal has turned since, and in 3D about it.
Vec<2> turnedImpulse(const Contact<2>& last, const Vec<2>& normal)
{
	return turnedWith(last.normal, normal, last.impulse);
}
Vec<3> turnedImpulse(const Contact<3>& last, const Vec<3>& normal)
{
	Vec<3> r = last.impulse;
	if (last.twist != 0) r = Eigen::AngleAxisd(last.twist, last.normal) * r;
	return turnedWith(last.normal, normal, r);
}

/// Impulses of the last step, and the history of an interface, go to the contacts that are still
/// there. Where contacts turn, impulses turn with them: sweeps that begin with those of before
/// would follow, and not quite reach, what bears a load, always on the same side. So does the slip
/// of bonds: what is not along the surface any more would be lost, a little in each step.
template <int dim> void carryOver(const std::vector<Contact<dim>>& last, ContactList<dim>& list)
{
	forEachStillThere<dim>(last, list.contacts, [&](std::size_t from, std::size_t to) {
		Contact<dim>& contact = list.contacts[to];
		contact.impulse = turnedImpulse(last[from], contact.normal);
	});
	if (!list.interface) return;
	list.interface->resize(list.contacts.size());
	forEachStillThere<dim>(last, list.contacts, [&](std::size_t from, std::size_t to) {
		list.interface->carry(from, to);
		Vec<dim>& slip = list.interface->history[to].slip;
		slip = turnedWith(last[from].normal, list.contacts[to].normal, slip);
	});
	if (list.rigid) list.interface->noteVanished(last);
}

/// A grain inside another, or two of a size on one another: no node near an outline may tell.
template <int dim> bool nested(const ContactOutline<dim>& first, const ContactOutline<dim>& second)
{
	const auto holds = [](const auto& a, const auto& b) {
		const Vec<dim> centre = b.box.centre();
		return a.holds(centre, b.innerRadius()) && (!b.hasFacets() || b.encloses(centre));
	};
	return holds(first, second) || holds(second, first);
}

/// Whether a place is in the polygon of the nodes, and deeper than the outline may be dented over a
/// facet.
template <int dim> bool enclosesDeep(const ContactOutline<dim>& body, const Vec<dim>& x)
{
	if (!body.encloses(x)) return false;
	const auto place = nearestPlace(x, body, facetsIn(body, body.box), anyFacet);
	return place.squaredDistance > body.bulge() * body.bulge();
}

/// The same where the centre of a box may lie outside its grain, known that no node is near an
/// outline; two on one another share their box.
template <int dim>
bool nestedIrregular(const ContactOutline<dim>& first, const ContactOutline<dim>& second)
{
	const double near = 0.2 * std::min(first.inradius, second.inradius);
	return enclosesDeep(first, second.position[0]) || enclosesDeep(second, first.position[0]) ||
	       ((first.box.low - second.box.low).norm() < near &&
		(first.box.high - second.box.high).norm() < near);
}

} // namespace

template <int dim>
void findContacts(const ContactOutline<dim>& first, const ContactOutline<dim>& second, double reach,
		  ContactList<dim>& list)
{
	auto& last = beginSearch(list);
	const double margin =
		first.isSurface() ? std::max(reach, contactDepth(first, second)) : reach;
	if (!first.box.grown(margin).overlaps(second.box)) return;
	const bool irregular = first.mesh->irregular || second.mesh->irregular;
	if (!irregular && nested(first, second))
		list.deepest = std::numeric_limits<double>::infinity();
	if (first.isOnGrid()) {
		nodesOnCommonGrid(first, second, reach, list);
		carryImpulsesByName(last, list);
		return;
	}
	if (first.isSurface())
		nodesAgainstOutlines(first, second, reach, list);
	else
		disksAgainstDisks(first, second, reach, list);
	if (irregular && list.contacts.empty() && nestedIrregular(first, second))
		list.deepest = std::numeric_limits<double>::infinity();
	carryOver(last, list);
}

template <int dim>
void findContacts(const ContactOutline<dim>& body, double reach, ContactList<dim>& list)
{
	auto& last = beginSearch(list);
	if (list.rigid) {
		findRigidContacts(body, reach, list);
		carryOver(last, list);
		return;
	}
	if (body.isOnGrid()) {
		nodesOnCommonGrid(body, reach, list);
		carryImpulsesByName(last, list);
		return;
	}
	const Vec<dim> halfBox = 0.5 * (body.box.high - body.box.low);
	const double boxGap = (body.box.centre() - list.plane.point).dot(list.plane.normal) -
			      halfBox.dot(list.plane.normal.cwiseAbs());
	if (boxGap >= reach) return;
	list.tested = body.nodes();
	for (int s = 0; s < body.nodes(); ++s) {
		Contact<dim> contact;
		contact.gap = (body.position[s] - list.plane.point).dot(list.plane.normal) -
			      body.nodeRadius;
		if (contact.gap >= reach) continue;
		list.noteOverlap(contact.gap, body.pointSpacing);
		contact.key = { 0, s, -1 };
		contact.normal = list.plane.normal;
		list.contacts.push_back(contact);
	}
	carryOver(last, list);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void findContacts<dim>(const ContactOutline<dim>&, const ContactOutline<dim>&,    \
					double, ContactList<dim>&);                                \
	template void findContacts<dim>(const ContactOutline<dim>&, double, ContactList<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
