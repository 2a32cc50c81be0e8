#include "contact/RigidSearch.hpp"
#include "contact/OutlineSearch.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace softgrain {

namespace {

/// Whether a contact node faces against a direction; disks have no normal of their own, and face
/// away from the middle of their grain.
template <int dim>
bool nodeFaces(const ContactOutline<dim>& body, int node, const Vec<dim>& direction,
	       double leastCosine)
{
	if (body.hasFacets()) return body.facesAgainst(node, direction, leastCosine);
	return (body.position[node] - body.box.centre()).dot(direction) < 0;
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

/// Over dr: how far before an edge it is asked what is nearest. Steps of the floor below that are
/// none; pieces of a floor need not join to rounding, and what is felt of 0.05 dr is below the
/// error of the outline.
constexpr double beforeEdge = 0.05;

/// The surfaces beside a rigid one, of which an edge may be a seam: where a floor goes on, what
/// lies before the edge is nearer to the next side than to the edge, and must not meet it head-on.
template <int dim> class Surroundings {
public:
	Surroundings(const ContactOutline<dim>& body, const RigidSide<dim>& rigid)
		: rigid_(rigid)
		, distance_(beforeEdge * body.pointSpacing)
		, depth_(contactDepth(body, body))
	{
	}
	/// Whether the place that `x` would touch is none: an edge, or a side of a block so near to
	/// one that `x` may be beneath the next side, at which the surface goes on.
	bool hides(const Vec<dim>& x, const SurfacePlace<dim>& place)
	{
		return place.toEdge < depth_ &&
		       goOnBefore(x - place.gap * place.normal, place.normal);
	}
	/// Whether a side of its own, or another surface, is nearer than `edge` to what lies before
	/// it in a direction (unit). In space the direction may lean along the edge.
	bool goOnBefore(const Vec<dim>& edge, const Vec<dim>& direction)
	{
		// Equally near counts as not nearer. A direction that leans along the edge by the
		// angle between nodes of a coarse grain, 0.3, stays above 0.95.
		constexpr double rounding = 1e-6, lean = 0.5;
		const Vec<dim> before = edge + distance_ * direction;
		const double own = (1 - rounding) * distanceTo<dim>(rigid_.surface, before);
		if (own < lean * distance_) return true;
		if (!rigid_.others) return false;
		if (!std::exchange(hasAsked_, true)) others_ = rigid_.others();
		return std::any_of(others_.begin(), others_.end(), [&](const auto& other) {
			return distanceTo<dim>(other, before) < own;
		});
	}

private:
	const RigidSide<dim>& rigid_;
	double distance_, depth_; ///< m
	std::vector<RigidSurface<dim>> others_;
	bool hasAsked_ = false; ///< for them (of an optional GCC warns wrongly)
};

/// Whether a node behind a plate or a block has come through it. Both are touched from all sides:
/// one on the far side of a sharp corner, near to the plate that the corner stands on, faces as one
/// that has come through does. The grain of that one goes on before the plate.
template <int dim>
bool hasComeThrough(const ContactOutline<dim>& body, int s, const SurfacePlace<dim>& place)
{
	if (place.gap < -contactDepth(body, body)) return false;
	if (!body.hasFacets()) return true;
	constexpr double trustedOverlap = 0.05; // in dr: nodes beside a corner are farther apart
	const double trusted = trustedOverlap * body.pointSpacing;
	const double inwards = -body.normal[s].dot(place.normal);
	if (inwards <= 0) return false;
	if (place.gap >= -trusted) return true;
	const double way = (trusted - place.gap) / inwards; // to a little before it
	return body.encloses(body.position[s] - way * body.normal[s]);
}

/// Where a contact node touches with a gap below `reach`, past places that are hidden and sides
/// that the grain is not on.
template <int dim>
std::optional<SurfacePlace<dim>> placeOfNode(const ContactOutline<dim>& body, int s, double reach,
					     const RigidSurface<dim>& surface,
					     Surroundings<dim>& surroundings)
{
	const Vec<dim>& x = body.position[s];
	const Faces<dim> faces = [&](const Vec<dim>& n, double leastCosine) {
		return nodeFaces<dim>(body, s, n, leastCosine);
	};
	auto isInReach = [&](const auto& p) { return p && p->gap - body.nodeRadius < reach; };
	auto isHidden = [&](const SurfacePlace<dim>& p) {
		return (p.isBehind && !hasComeThrough(body, s, p)) || surroundings.hides(x, p);
	};
	const auto place = placeOn<dim>(surface, x, faces);
	if (!isInReach(place)) return std::nullopt;
	if (!isHidden(*place)) return place;
	constexpr double alike = 0.99; // the same side: those of a block are at right angles
	const auto next = placeOn<dim>(surface, x, [&](const Vec<dim>& n, double leastCosine) {
		return n.dot(place->normal) < alike && faces(n, leastCosine);
	});
	if (!isInReach(next) || isHidden(*next)) return std::nullopt;
	return next;
}

template <int dim>
void nodesOnSurface(const ContactOutline<dim>& body, double reach, Surroundings<dim>& surroundings,
		    ContactList<dim>& list)
{
	const RigidSurface<dim>& surface = list.rigid->surface;
	const BallSurface<dim> about = ballAbout<dim>(surface);
	const double within =
		about.radius + body.nodeRadius + std::max(reach, contactDepth(body, body));
	const auto nodes = body.nodesIn(Box<dim> { about.centre, about.centre }.grown(within));
	list.tested += static_cast<int>(nodes.size());
	for (int s : nodes) {
		if ((body.position[s] - about.centre).squaredNorm() > within * within) continue;
		const auto place = placeOfNode(body, s, reach, surface, surroundings);
		if (!place) continue;
		Contact<dim> contact;
		contact.normal = place->normal;
		contact.gap = place->gap - body.nodeRadius;
		append({ 0, s, -1 }, contact, place->isBehind, body, list);
	}
}

template <int dim>
void tipsOnOutline(const ContactOutline<dim>& body, double reach, Surroundings<dim>& surroundings,
		   ContactList<dim>& list)
{
	const double margin = std::max(reach, contactDepth(body, body));
	const double turn = body.pointSpacing / body.inradius; // of the outline, from node to node
	const bool isPlate = std::holds_alternative<PlateSurface<dim>>(list.rigid->surface);
	const auto tips =
		tipsOf<dim>(list.rigid->surface, body.box.grown(margin), body.pointSpacing);
	for (const Tip<dim>& tip : tips) {
		auto contact = ballOnOutline<dim>(tip.ball.centre, tip.ball.radius, body, reach);
		if (!contact || liesAlongSide<dim>(list.rigid->surface, tip, contact->normal, turn,
						   body.pointSpacing))
			continue;
		const bool isPoint = tip.ball.radius == 0;
		if (isPoint && surroundings.goOnBefore(tip.ball.centre, -contact->normal)) continue;
		append({ 1, tip.number, -1 }, *contact, isPlate, body, list);
	}
}

} // namespace

template <int dim>
void findRigidContacts(const ContactOutline<dim>& body, double reach, ContactList<dim>& list)
{
	Surroundings<dim> surroundings(body, *list.rigid);
	nodesOnSurface<dim>(body, reach, surroundings, list);
	if (body.isSurface()) tipsOnOutline<dim>(body, reach, surroundings, list);
	const auto* ball = std::get_if<BallSurface<dim>>(&list.rigid->surface);
	if (!ball) return;
	const bool nested = body.mesh->irregular
				    ? list.contacts.empty() && body.encloses(ball->centre)
				    : body.holds(ball->centre, ball->radius);
	if (nested) list.deepest = std::numeric_limits<double>::infinity();
}

template void findRigidContacts<2>(const ContactOutline<2>&, double, ContactList<2>&);
template void findRigidContacts<3>(const ContactOutline<3>&, double, ContactList<3>&);

} // namespace softgrain
