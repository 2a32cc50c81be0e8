#include "contact/RigidSearch.hpp"
#include "contact/OutlineSearch.hpp"

#include <limits>

namespace softgrain {

namespace {

/// Whether a contact node faces against a direction; disks have no normal of their own, and face
/// away from the middle of their grain.
template <int dim>
bool nodeFaces(const ContactBody<dim>& body, int node, const Vec<dim>& direction,
	       double leastCosine)
{
	if (body.hasFacets()) return body.facesAgainst(node, direction, leastCosine);
	return (body.position[node] - body.box.centre()).dot(direction) < 0;
}

/// What lies deeper than a contact is none, but is known by its depth. Behind a plate, which has no
/// inside, lies the other side of the grain.
template <int dim>
void append(const ContactKey& key, Contact<dim>& contact, const ContactBody<dim>& body,
	    ContactList<dim>& list)
{
	const bool deep = contact.gap < -contactDepth(body, body);
	if (deep && std::holds_alternative<PlateSurface<dim>>(list.rigid->surface)) return;
	list.noteOverlap(contact.gap, body.pointSpacing);
	if (deep) return;
	contact.key = key;
	list.contacts.push_back(contact);
}

template <int dim>
void nodesOnSurface(const ContactBody<dim>& body, double reach, ContactList<dim>& list)
{
	const RigidSurface<dim>& surface = list.rigid->surface;
	const BallSurface<dim> about = ballAbout<dim>(surface);
	const double within =
		about.radius + body.nodeRadius + std::max(reach, contactDepth(body, body));
	const auto nodes = body.nodesIn(Box<dim> { about.centre, about.centre }.grown(within));
	list.tested += static_cast<int>(nodes.size());
	for (int s : nodes) {
		if ((body.position[s] - about.centre).squaredNorm() > within * within) continue;
		const auto place = placeOn<dim>(
			surface, body.position[s], [&](const Vec<dim>& n, double leastCosine) {
				return nodeFaces<dim>(body, s, n, leastCosine);
			});
		if (!place) continue;
		Contact<dim> contact;
		contact.normal = place->normal;
		contact.gap = place->gap - body.nodeRadius;
		if (contact.gap < reach) append({ 0, s, -1 }, contact, body, list);
	}
}

template <int dim>
void tipsOnOutline(const ContactBody<dim>& body, double reach, ContactList<dim>& list)
{
	const double margin = std::max(reach, contactDepth(body, body));
	const double turn = body.pointSpacing / body.inradius; // of the outline, from node to node
	const auto tips =
		tipsOf<dim>(list.rigid->surface, body.box.grown(margin), body.pointSpacing);
	for (const Tip<dim>& tip : tips) {
		auto contact = ballOnOutline<dim>(tip.ball.centre, tip.ball.radius, body, reach);
		if (contact && !liesAlongSide<dim>(list.rigid->surface, tip, contact->normal, turn))
			append({ 1, tip.number, -1 }, *contact, body, list);
	}
}

} // namespace

template <int dim>
void findRigidContacts(const ContactBody<dim>& body, double reach, ContactList<dim>& list)
{
	nodesOnSurface<dim>(body, reach, list);
	if (body.isSurface()) tipsOnOutline<dim>(body, reach, list);
	const auto* ball = std::get_if<BallSurface<dim>>(&list.rigid->surface);
	if (!ball) return;
	const bool nested = body.mesh->irregular
				    ? list.contacts.empty() && body.encloses(ball->centre)
				    : body.holds(ball->centre, ball->radius);
	if (nested) list.deepest = std::numeric_limits<double>::infinity();
}

template void findRigidContacts<2>(const ContactBody<2>&, double, ContactList<2>&);
template void findRigidContacts<3>(const ContactBody<3>&, double, ContactList<3>&);

} // namespace softgrain
