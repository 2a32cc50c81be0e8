#include "contact/RigidSearch.hpp"
#include "contact/OutlineSearch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Calls with the places of a point on the sides of a surface that it faces, the nearest side about
/// a corner first, until `take` takes one.
template <int dim, class Take>
void tryPlaces(const RigidSurface<dim>& surface, const Vec<dim>& x, const Faces<dim>& faces,
	       const GoesOn<dim>& goesOn, Take&& take)
{
	std::array<Vec<dim>, dim> passed; // their normals
	Vec<dim> from = x;
	int sides = 0;
	const Faces<dim> facesAnother = [&](const Vec<dim>& n, double leastCosine) {
		constexpr double alike =
			0.99; // the same side: those of a block are at right angles
		return std::none_of(passed.begin(), passed.begin() + sides,
				    [&](const Vec<dim>& side) { return n.dot(side) >= alike; }) &&
		       faces(n, leastCosine);
	};
	for (; sides < dim; ++sides) {
		const auto place = placeOn<dim>(surface, from, facesAnother, goesOn);
		if (!place || take(*place, from)) return;
		const bool isEdge = place->inwards.isZero(0) && !place->isBehind;
		if (isEdge) return;
		passed[sides] = place->normal;
		from -= std::max(place->gap, 0.) * place->normal; // no longer beyond that side
	}
}

/// The surfaces beside a rigid one, of which an edge may be a seam: where a floor goes on, what
/// lies before the edge is nearer to the next side than to the edge, and must not meet it head-on;
/// and what both bear is to count once.
template <int dim> class Surroundings {
public:
	Surroundings(const ContactOutline<dim>& body, const RigidSide<dim>& rigid)
		: body_(body)
		, rigid_(rigid)
		, distance_(beforeEdge * body.pointSpacing)
		, depth_(contactDepth(body, body))
		, alike_(rounding * body.pointSpacing)
	{
	}
	/// Whether the place that `x` would touch is none: an edge, or a side of a block so near to
	/// one that `x` may be beneath the next side, at which the surface goes on. (Where a block
	/// rises from the edge of a side, a place a little further in is before both.)
	bool hides(const Vec<dim>& x, const SurfacePlace<dim>& place)
	{
		if (place.toEdge >= depth_) return false;
		const Vec<dim> before = this->before(x, place);
		if (place.inwards.isZero(0)) return goesOn(before);
		return anyOther([&](const SurfaceBeside<dim>& other) {
			const bool isBlock =
				std::holds_alternative<BlockSurface<dim>>(other.surface);
			const Vec<dim> further = before + distance_ * place.inwards;
			return isBlock ? distanceTo<dim>(other.surface, further) < 0.5 * distance_
				       : isNearer(other.surface, before);
		});
	}
	/// Whether another surface bears the same place, on the seam of both: one that comes first,
	/// or any if the place lies beside this surface.
	bool isAnothers(const Vec<dim>& x, const SurfacePlace<dim>& place, const Faces<dim>& faces)
	{
		if (place.toEdge >= depth_ && !place.isNearEnd) return false;
		const bool yields = beside(rigid_.surface, x, place) > alike_;
		return anyOther([&](const SurfaceBeside<dim>& other) {
			return (other.comesFirst || yields) &&
			       bearsToo(other.surface, x, place, faces);
		});
	}
	/// How far the place of a point on a side of this surface lies beyond the end of that, over
	/// what is felt of a step.
	double beside(const Vec<dim>& x, const SurfacePlace<dim>& place) const
	{
		return beside(rigid_.surface, x, place) / distance_;
	}
	/// Both of a tip that the outline touches with this normal (unit, outwards), `turn` as
	/// in liesAlongSide.
	bool hides(const Tip<dim>& tip, const Vec<dim>& normal, double turn)
	{
		const Vec<dim> before = tip.ball.centre - distance_ * normal;
		return goesOn(before) || anyOther([&](const SurfaceBeside<dim>& other) {
			       return other.comesFirst && hasTip(other.surface, tip.ball.centre) &&
				      !liesAlongSide<dim>(other.surface, tip, normal, turn,
							  body_.pointSpacing) &&
				      !isNearerBefore(other.surface, before);
		       });
	}

	/// GoesOn of the other surfaces.
	bool goesOnBeyond(const Vec<dim>& edge, const Vec<dim>& over, const Vec<dim>& normal)
	{
		return anyOther([&](const auto& other) {
			return isBeyond(other.surface, edge, over, normal);
		});
	}

private:
	/// Whether a surface goes on from an edge, inclined by less than 30 degrees, or rises from
	/// it.
	bool isBeyond(const RigidSurface<dim>& surface, const Vec<dim>& edge, const Vec<dim>& over,
		      const Vec<dim>& normal) const
	{
		constexpr double rises[] { 0, M_PI / 4, M_PI / 2, 3 * M_PI / 4 };
		return std::any_of(std::begin(rises), std::end(rises), [&](double rise) {
			const Vec<dim> way = std::cos(rise) * over + std::sin(rise) * normal;
			return distanceTo<dim>(surface, edge + distance_ * way) < 0.5 * distance_;
		});
	}
	/// Whether a side of its own, or another surface, is nearer than an edge to what lies
	/// before it. In space the direction there may lean along the edge.
	bool goesOn(const Vec<dim>& before)
	{
		// A direction that leans along the edge by the angle between nodes of a coarse
		// grain, 0.3, stays above 0.95.
		constexpr double lean = 0.5;
		return distanceTo<dim>(rigid_.surface, before) < lean * distance_ ||
		       anyOther([&](const auto& other) { return isNearer(other.surface, before); });
	}
	/// Whether another surface lies beneath the same place of the outline, and keeps it.
	bool bearsToo(const RigidSurface<dim>& surface, const Vec<dim>& x,
		      const SurfacePlace<dim>& place, const Faces<dim>& faces) const
	{
		const auto goesOn = [this](const auto& edge, const auto& over, const auto& normal) {
			return isBeyond(rigid_.surface, edge, over, normal);
		};
		const double alike = rounding * std::max(distance_, std::abs(place.gap));
		bool bears = false;
		auto take = [&](const SurfacePlace<dim>& other, const Vec<dim>& from) {
			if (other.normal.dot(place.normal) <= 1 - rounding) return false;
			bears = std::abs(other.gap - place.gap) < alike &&
				beside(surface, x, other) < alike_ &&
				!isNearerBefore(surface, before(from, other));
			return true;
		};
		tryPlaces<dim>(surface, x, faces, goesOn, take);
		return bears;
	}
	/// Whether another surface is nearer to a place than this one.
	bool isNearer(const RigidSurface<dim>& surface, const Vec<dim>& place) const
	{
		return distanceTo<dim>(surface, place) <
		       (1 - rounding) * distanceTo<dim>(rigid_.surface, place);
	}
	/// Whether this surface is nearer to what lies before another one.
	bool isNearerBefore(const RigidSurface<dim>& surface, const Vec<dim>& before) const
	{
		return distanceTo<dim>(rigid_.surface, before) <
		       (1 - rounding) * distanceTo<dim>(surface, before);
	}
	double beside(const RigidSurface<dim>& surface, const Vec<dim>& x,
		      const SurfacePlace<dim>& place) const
	{
		return distanceTo<dim>(surface, x - place.gap * place.normal);
	}
	bool hasTip(const RigidSurface<dim>& surface, const Vec<dim>& place) const
	{
		const auto tips = tipsOf<dim>(surface, Box<dim> { place, place }.grown(alike_),
					      body_.pointSpacing);
		return std::any_of(tips.begin(), tips.end(), [&](const Tip<dim>& tip) {
			return (tip.ball.centre - place).norm() < alike_;
		});
	}
	Vec<dim> before(const Vec<dim>& x, const SurfacePlace<dim>& place) const
	{
		return x + (distance_ - place.gap) * place.normal;
	}
	template <class Is> bool anyOther(Is&& is)
	{
		if (!rigid_.others) return false;
		if (!std::exchange(hasAsked_, true)) others_ = rigid_.others();
		return std::any_of(others_.begin(), others_.end(), is);
	}

	static constexpr double rounding = 1e-6; ///< equally near counts as not nearer
	const ContactOutline<dim>& body_;
	const RigidSide<dim>& rigid_;
	double distance_, depth_; ///< m
	double alike_;            ///< between places that are one, m
	std::vector<SurfaceBeside<dim>> others_;
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

/// Where a contact node touches with a gap below `reach`: past places that are hidden, and sides
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
	const auto goesOn = [&](const auto& edge, const auto& over, const auto& normal) {
		return surroundings.goesOnBeyond(edge, over, normal);
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
		if (surroundings.beside(x, place) > 1) return false;
		if (place.isBehind && !hasComeThrough(body, s, place)) return false;
		if (surroundings.hides(from, place)) return false;
		if (!surroundings.isAnothers(x, place, faces)) touched = place;
		return true;
	};
	tryPlaces<dim>(surface, x, faces, goesOn, take);
	return touched;
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
		if (isPoint && surroundings.hides(tip, contact->normal, turn)) continue;
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
