#include "contact/search/RigidSearch.hpp"
#include "contact/search/BallOnOutline.hpp"
#include "contact/search/PlaceOnOutline.hpp"
#include "contact/search/PlaceOnRigid.hpp"
#include "contact/search/RigidSeams.hpp"
#include "contact/search/RigidTips.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace softgrain {

namespace {

/// Facing of a contact node; disks have no normal of their own, and face whatever is not on the
/// side of the middle of their grain. Where an outline is bent, either of its sides may be on that
/// of a body; which side of a flat surface it is on, as a whole, only both can tell.
template <int dim>
double facingOf(const ContactOutline<dim>& body, int node, const Vec<dim>& direction, bool isFlat)
{
	if (!body.hasFacets())
		return (body.position[node] - body.box.centre()).dot(direction) < 0 ? 1 : -1;
	const NodeFacing<dim> facing(body, node);
	return isFlat ? facing(direction) : facing.ofSides(direction);
}

template <int dim> struct Flat { ///< a plane
	Vec<dim> point, normal;
};

/// The plane of a plate, or of a block that is so thin that its sides are as one.
template <int dim> std::optional<Flat<dim>> flatOf(const RigidSurface<dim>& surface, double dr)
{
	if (const auto* plate = std::get_if<PlateSurface<dim>>(&surface))
		return Flat<dim> { plate->corner[0], normalOf<dim>(*plate) };
	const auto* block = std::get_if<BlockSurface<dim>>(&surface);
	constexpr double thin = 0.1; // over dr: overlaps of a step may be as large
	for (int a = 0; block && a < dim; ++a)
		if (2 * block->halfSides[a] < thin * dr)
			return Flat<dim> { block->centre, block->axes.col(a) };
	return std::nullopt;
}

/// Whether a corner that is squeezed flat upon a surface without an inside, so that it faces both
/// sides of that, and the far one more perhaps, is of a grain before the side with this normal.
template <int dim>
bool liesBefore(const ContactOutline<dim>& body, int node, const Flat<dim>* flat,
		const Vec<dim>& normal)
{
	constexpr double alike = 1 - 1e-9; // cosine
	// cosine: both sides within 26 degrees of it, as of a corner of 52 degrees or less upon it
	constexpr double squeezed = 0.9;
	constexpr double upon = 0.5; // over dr: what is farther off lies over something else
	if (!flat || std::abs(normal.dot(flat->normal)) < alike) return false;
	const double height = (body.position[node] - flat->point).dot(normal);
	const NodeFacing<dim> facing(body, node);
	return std::abs(height) < upon * body.pointSpacing && facing(normal) > squeezed &&
	       facing(-normal) > squeezed && (body.box.centre() - flat->point).dot(normal) > 0;
}

/// What lies deeper than a contact is none, but is known by its depth. Behind a plate or a block
/// lies the other side of the grain.
template <int dim>
void append(const ContactKey& key, Contact<dim>& contact, bool isBehind,
	    const ContactOutline<dim>& body, ContactList<dim>& list)
{
	const bool deep = contact.gap < -contactDepth(body, body);
	if (deep && isBehind) return;
	list.noteOverlap(contact.gap, body.pointSpacing);
	if (deep) return;
	contact.key = key;
	list.contacts.push_back(contact);
}

/// Whether the middle of a grain is before a side that a node of it is behind, and the way there
/// leads through the floor. (The middle may be outside of one that is not convex.)
template <int dim>
bool isMiddleBefore(const ContactOutline<dim>& body, int s, const SurfacePlace<dim>& place,
		    RigidSeams<dim>& seams)
{
	const Vec<dim> middle = body.box.centre();
	if (!body.encloses(middle)) return true;
	const Vec<dim> way = middle - body.position[s];
	const double rise = way.dot(place.normal);
	if (rise <= -place.gap) return false;
	return seams.isOnFloor(body.position[s] - place.gap / rise * way);
}

/// Whether a node behind a plate or a block has come through it. Both are touched from all sides:
/// one on the far side of a sharp corner, near to the plate that the corner stands on, faces as one
/// that has come through does. The grain of that one goes on before the plate, as far as it has
/// come through, and not past its end.
template <int dim>
bool hasComeThrough(const ContactOutline<dim>& body, int s, const SurfacePlace<dim>& place,
		    RigidSeams<dim>& seams)
{
	const double depth = -place.gap, deepest = contactDepth(body, body);
	if (depth > deepest) return false;
	if (!body.hasFacets()) return true;
	const double inwards = -body.normal[s].dot(place.normal);
	if (inwards <= 0) return false;
	constexpr double trustedOverlap = 0.05; // in dr: nodes beside a corner are farther apart
	if (depth <= trustedOverlap * body.pointSpacing) return true;
	if (depth > deepest * inwards) return false; // the way back
	const Vec<dim>& x = body.position[s];
	const Vec<dim> back = -depth / inwards * body.normal[s];
	return body.encloses(s, x + 2 * back) && seams.isOnFloor(x + back) &&
	       isMiddleBefore(body, s, place, seams);
}

/// Where a contact node touches with a gap below `reach`: past places that are hidden, and sides
/// that the grain is not on.
template <int dim>
std::optional<SurfacePlace<dim>>
placeOfNode(const ContactOutline<dim>& body, int s, double reach, const RigidSurface<dim>& surface,
	    const std::optional<Flat<dim>>& thin, RigidSeams<dim>& seams)
{
	const Vec<dim>& x = body.position[s];
	const Flat<dim>* flat = thin && body.isSharp(s) ? &*thin : nullptr;
	const Facing<dim> facing = [&](const Vec<dim>& n) {
		return liesBefore<dim>(body, s, flat, -n)
			       ? -1.
			       : facingOf<dim>(body, s, n, thin.has_value());
	};
	const auto goesOn = [&](const auto& edge, const auto& way) {
		return seams.goesOnFrom(edge, way);
	};
	std::optional<SurfacePlace<dim>> touched;
	bool isFirst = true;
	auto take = [&](const SurfacePlace<dim>& place, const Vec<dim>& from) {
		const bool isNext = !std::exchange(isFirst, false);
		// beneath a side that it faces, but just beneath another, through which it came
		const double depth = contactDepth(body, body);
		const bool isOfAnother = isNext || place.toEdge < depth;
		if (place.gap < -depth && isOfAnother) return true;
		if (place.gap - body.nodeRadius >= reach) return true;
		if (place.isBehind && !liesBefore<dim>(body, s, flat, place.normal) &&
		    !hasComeThrough(body, s, place, seams))
			return false;
		if (seams.hides(from, place)) return false;
		if (!seams.isAnothers(x, place, facing)) touched = place;
		return true;
	};
	tryPlaces<dim>(surface, x, facing, goesOn, seams.tolerance(), take);
	return touched;
}

/// Whether a contact node that is outside of a surface can only be before it, not behind: what has
/// come through a block of less than the depth of a contact is known on its far side.
template <int dim>
bool isBefore(const ContactOutline<dim>& body, int node, const RigidSurface<dim>& surface)
{
	if (const auto* block = std::get_if<BlockSurface<dim>>(&surface))
		return 2 * block->halfSides.minCoeff() >= contactDepth(body, body);
	const auto* plate = std::get_if<PlateSurface<dim>>(&surface);
	if (!plate) return true;
	if (!body.hasFacets() || body.isSharp(node)) return false; // they may face both sides
	const Vec<dim> normal = normalOf<dim>(*plate);
	const double height = (body.position[node] - plate->corner[0]).dot(normal);
	return height * body.normal[node].dot(normal) < 0;
}

template <int dim>
void nodesOnSurface(const ContactOutline<dim>& body, double reach, RigidSeams<dim>& seams,
		    ContactList<dim>& list)
{
	const RigidSurface<dim>& surface = list.rigid->surface;
	const auto thin = flatOf<dim>(surface, body.pointSpacing);
	const BallSurface<dim> about = ballAbout<dim>(surface);
	const double within = body.nodeRadius + marginOf(body, body, reach);
	const double before = body.nodeRadius + std::max(reach, seams.tolerance());
	const auto around = Box<dim> { about.centre, about.centre }.grown(about.radius + within);
	for (int s : body.nodesIn(around)) {
		const double distance = distanceTo<dim>(surface, body.position[s]);
		if (distance > before && (distance > within || isBefore(body, s, surface)))
			continue;
		++list.tested;
		const auto place = placeOfNode(body, s, reach, surface, thin, seams);
		if (!place) continue;
		Contact<dim> contact;
		contact.normal = place->normal;
		contact.gap = place->gap - body.nodeRadius;
		append({ 0, s, -1 }, contact, place->isBehind, body, list);
	}
}

template <int dim>
void tipsOnOutline(const ContactOutline<dim>& body, double reach, RigidSeams<dim>& seams,
		   ContactList<dim>& list)
{
	const double margin = marginOf(body, body, reach);
	const double turn = body.pointSpacing / body.inradius; // of the outline, from node to node
	const bool isPlate = std::holds_alternative<PlateSurface<dim>>(list.rigid->surface);
	const auto tips =
		tipsOf<dim>(list.rigid->surface, body.box.grown(margin), body.pointSpacing);
	for (const Tip<dim>& tip : tips) {
		const double within = body.outerRadius() + tip.ball.radius + reach;
		if ((tip.ball.centre - body.box.centre()).squaredNorm() > within * within) continue;
		auto contact = ballOnOutline<dim>(tip.ball.centre, tip.ball.radius, body, reach);
		if (!contact) continue;
		const bool isPoint = tip.ball.radius == 0;
		if (isPoint && seams.hides(tip, contact->normal, turn)) continue;
		append({ 1, tip.number, -1 }, *contact, isPlate, body, list);
	}
}

void crossingEdges(const ContactOutline<3>& body, double reach, RigidSeams<3>& seams,
		   ContactList<3>& list)
{
	if (body.mesh->sharpEdge.empty()) return;
	const RigidSurface<3>& surface = list.rigid->surface;
	const BallSurface<3> about = ballAbout<3>(surface);
	const auto around = Box<3> { about.centre, about.centre }.grown(about.radius);
	const double turn = body.pointSpacing / body.inradius;
	const auto rigid = edgesOf(surface, body.pointSpacing);
	const double margin = marginOf(body, body, reach);
	for (int e : edgesNear(body, around, margin)) {
		const Vec<3> middle = pieceOf(body, e).middle();
		if (distanceTo<3>(surface, middle) > margin + body.longestEdge) continue;
		const auto edge = edgeOf(body, e);
		if (!edge) continue;
		for (int r = 0; r < static_cast<int>(rigid.size()); ++r) {
			const auto nearest = nearestPlaces(*edge, rigid[r]);
			if (!nearest || !isBetweenEnds(nearest->onSecond) ||
			    !isOnPiece(nearest->onFirst, body, e, rigid[r]))
				continue;
			const auto crossing = crossingOf(*edge, rigid[r], *nearest);
			if (!crossing || crossing->gap >= reach) continue;
			const Vec<3> place = rigid[r].at(crossing->onSecond);
			if (!isWayOut(*crossing, place, body, body.pointSpacing) ||
			    seams.hidesOnEdge(place, crossing->normal, turn))
				continue;
			Contact<3> contact = contactAt(*crossing, body, e);
			constexpr bool isBehind = true; // deeper another way out is shorter
			append({ ContactKey::edges, e, r }, contact, isBehind, body, list);
		}
	}
}

/// Whether a place is inside of a grain, and deeper than contacts are: no node near it tells.
/// (Nodes are an edge apart. What bears a grain from outside is not looked at: it is at a side of
/// its box.)
template <int dim> bool isDeepInside(const ContactOutline<dim>& body, const Vec<dim>& x)
{
	const double deep = contactDepth(body, body) + body.longestEdge;
	if (!body.box.grown(-0.5 * deep).contains(x)) return false;
	for (const Vec<dim>& node : body.position)
		if ((node - x).squaredNorm() < deep * deep) return false;
	return body.hasFacets() ? body.encloses(x)
				: (x - body.box.centre()).norm() < body.innerRadius();
}

} // namespace

template <int dim>
void findRigidContacts(const ContactOutline<dim>& body, double reach, ContactList<dim>& list)
{
	const double within = body.outerRadius() + marginOf(body, body, reach);
	if (distanceTo<dim>(list.rigid->surface, body.box.centre()) > within) return;
	RigidSeams<dim> seams(body, *list.rigid);
	nodesOnSurface<dim>(body, reach, seams, list);
	if (body.isSurface()) {
		tipsOnOutline<dim>(body, reach, seams, list);
		if constexpr (dim == 3) crossingEdges(body, reach, seams, list);
	}
	const auto* ball = std::get_if<BallSurface<dim>>(&list.rigid->surface);
	const bool nested =
		ball && !body.mesh->irregular
			? body.holds(ball->centre, ball->radius)
			: isDeepInside<dim>(body, nearestPlaceOn<dim>(list.rigid->surface,
								      body.box.centre()));
	if (nested) list.deepest = std::numeric_limits<double>::infinity();
}

template void findRigidContacts<2>(const ContactOutline<2>&, double, ContactList<2>&);
template void findRigidContacts<3>(const ContactOutline<3>&, double, ContactList<3>&);

} // namespace softgrain
