#include "contact/search/RigidSeams.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

namespace softgrain {

namespace {

/// Over dr: how far before an edge it is asked what is nearest. Steps of the floor below that are
/// none; pieces of a floor need not join to rounding, and what is felt of 0.05 dr is below the
/// error of the outline.
constexpr double beforeEdge = 0.05;

/// Over dr: what is deeper beneath a side, past its end, has not sunk there in an inside corner.
constexpr double deepBeyondEnd = 0.25;

/// Equally near counts as not nearer. (So what leans by up to 1.4e-3 beyond an edge is still
/// equally near to both.)
constexpr double rounding = 1e-6;

/// Directions along a plane with this normal, none further than 45 degrees from one of them.
std::array<Vec<2>, 2> waysAlong(const Vec<2>& normal)
{
	const Vec<2> way(-normal[1], normal[0]);
	return { way, -way };
}
std::array<Vec<3>, 4> waysAlong(const Vec<3>& normal)
{
	const Vec<3> way = normal.unitOrthogonal(), across = normal.cross(way);
	return { way, across, -way, -across };
}

} // namespace

template <int dim>
RigidSeams<dim>::RigidSeams(const ContactOutline<dim>& body, const RigidSide<dim>& rigid)
	: rigid_(rigid)
	, spacing_(body.pointSpacing)
	, distance_(beforeEdge * body.pointSpacing)
	, depth_(contactDepth(body, body))
	, alike_(rounding * body.pointSpacing)
{
}

template <int dim> bool RigidSeams<dim>::hides(const Vec<dim>& x, const SurfacePlace<dim>& place)
{
	if (place.beside > distance_) return true;
	if (place.toEdge >= depth_) return false;
	const Vec<dim> before = this->before(x, place);
	if (place.beside > 0 && place.gap < -deepBeyondEnd * spacing_ && isInAnotherBlock(before))
		return true;
	return place.isOnBlock ? isCovered(before, place) : goesOnBefore(before);
}

template <int dim> bool RigidSeams<dim>::isInAnotherBlock(const Vec<dim>& place)
{
	return anyOther([&](const SurfaceBeside<dim>& other) {
		return std::holds_alternative<BlockSurface<dim>>(other.surface) &&
		       distanceTo<dim>(other.surface, place) < distance_;
	});
}

/// (Another block may as well rise from the edge, or end beside the place: there places about it on
/// the side lie before both, and not in the block, or but for what the node has sunk into it.)
template <int dim>
bool RigidSeams<dim>::isCovered(const Vec<dim>& before, const SurfacePlace<dim>& place)
{
	constexpr unsigned ways = 1u << (dim - 1);
	for (unsigned way = 0; way < ways; ++way)
		if (!isCoveredTowards(before, place, way)) return false;
	return true;
}

/// (A plate covers the place itself, but not what is on the side above it.)
template <int dim>
bool RigidSeams<dim>::isCoveredTowards(const Vec<dim>& before, const SurfacePlace<dim>& place,
				       unsigned way)
{
	Vec<dim> further = before;
	for (int edge = 0; edge < dim - 1; ++edge) {
		const auto [inwards, away] = place.edges[edge];
		const bool goesOut = way >> edge & 1;
		if (goesOut && away <= distance_) return true; // not on the side any more
		further += (goesOut ? -distance_ : distance_ - std::min(away, 0.)) * inwards;
	}
	return anyOther([&](const SurfaceBeside<dim>& other) {
		const bool isPlate = std::holds_alternative<PlateSurface<dim>>(other.surface);
		return isPlate && way == 0
			       ? isNearer(other.surface, before)
			       : distanceTo<dim>(other.surface, further) < 0.5 * distance_;
	});
}

template <int dim>
bool RigidSeams<dim>::isAnothers(const Vec<dim>& x, const SurfacePlace<dim>& place,
				 const Facing<dim>& facing)
{
	if (place.toEdge >= depth_ && !place.isNearEnd) return false;
	return anyOther([&](const SurfaceBeside<dim>& other) {
		return (other.comesFirst || place.beside > alike_) &&
		       bearsToo(other.surface, x, place, facing);
	});
}

template <int dim>
bool RigidSeams<dim>::hides(const Tip<dim>& tip, const Vec<dim>& normal, double turn)
{
	const Vec<dim>& place = tip.ball.centre;
	return hidesEnd(place, normal, turn,
			[&](const auto& other) { return hasTip(other, place); });
}

template <int dim>
bool RigidSeams<dim>::hidesOnEdge(const Vec<dim>& place, const Vec<dim>& normal, double turn)
{
	return hidesEnd(place, normal, turn,
			[&](const auto& other) { return hasEdge(other, place); });
}

template <int dim>
template <class Has>
bool RigidSeams<dim>::hidesEnd(const Vec<dim>& place, const Vec<dim>& normal, double turn,
			       Has&& has)
{
	if (isBorneBeside(rigid_.surface, place, normal, turn)) return true;
	const Vec<dim> before = place - distance_ * normal;
	return goesOnBefore(before) || anyOther([&](const SurfaceBeside<dim>& other) {
		       return other.comesFirst && has(other.surface) &&
			      !isBorneBeside(other.surface, place, normal, turn) &&
			      !isNearerBefore(other.surface, before);
	       });
}

template <int dim>
bool RigidSeams<dim>::isBorneBeside(const RigidSurface<dim>& surface, const Vec<dim>& place,
				    const Vec<dim>& normal, double turn)
{
	const auto side = sideAlong<dim>(surface, place, normal, turn, spacing_);
	if (!side) return false;
	const auto ways = waysAlong(*side);
	return std::none_of(ways.begin(), ways.end(),
			    [&](const Vec<dim>& way) { return endsTowards(place, way, *side); });
}

template <int dim>
bool RigidSeams<dim>::endsTowards(const Vec<dim>& edge, const Vec<dim>& way, const Vec<dim>& normal)
{
	return !anyRise<dim>(way, normal, [&](const Vec<dim>& there, const Vec<dim>&) {
		return leaves(rigid_.surface, edge, there) || goesOnFrom(edge, there);
	});
}

/// (The pieces of a floor need not join to rounding; beyond its end there is none.)
template <int dim> bool RigidSeams<dim>::isOnFloor(const Vec<dim>& place)
{
	return distanceTo<dim>(rigid_.surface, place) < alike_ ||
	       anyOther([&](const SurfaceBeside<dim>& other) {
		       return distanceTo<dim>(other.surface, place) < distance_;
	       });
}

template <int dim> bool RigidSeams<dim>::goesOnFrom(const Vec<dim>& edge, const Vec<dim>& way)
{
	return anyOther(
		[&](const SurfaceBeside<dim>& other) { return leaves(other.surface, edge, way); });
}

/// (A surface from the edge is nearer to a place than half of that one's distance if it leaves the
/// edge within 30 degrees of it: those at 45 degrees from each other miss none in between.)
template <int dim>
bool RigidSeams<dim>::leaves(const RigidSurface<dim>& surface, const Vec<dim>& edge,
			     const Vec<dim>& way) const
{
	return distanceTo<dim>(surface, edge + distance_ * way) < 0.5 * distance_;
}

template <int dim> bool RigidSeams<dim>::goesOnBefore(const Vec<dim>& before)
{
	// A direction that leans along the edge by the angle between nodes of a coarse grain, up to
	// 0.6, stays above 0.8.
	constexpr double lean = 0.5;
	return distanceTo<dim>(rigid_.surface, before) < lean * distance_ ||
	       anyOther([&](const SurfaceBeside<dim>& other) {
		       return isNearer(other.surface, before);
	       });
}

template <int dim>
bool RigidSeams<dim>::bearsToo(const RigidSurface<dim>& surface, const Vec<dim>& x,
			       const SurfacePlace<dim>& place, const Facing<dim>& facing)
{
	const auto goesOn = [this](const auto& edge, const auto& way) {
		return leaves(rigid_.surface, edge, way) || goesOnFrom(edge, way);
	};
	const double alike = rounding * std::max(distance_, std::abs(place.gap));
	bool bears = false;
	auto take = [&](const SurfacePlace<dim>& other, const Vec<dim>& from) {
		if (other.normal.dot(place.normal) <= 1 - rounding) return false;
		bears = std::abs(other.gap - place.gap) < alike && other.beside < alike_ &&
			!isNearerBefore(surface, before(from, other));
		return true;
	};
	tryPlaces<dim>(surface, x, facing, goesOn, distance_, take);
	return bears;
}

template <int dim>
bool RigidSeams<dim>::isNearer(const RigidSurface<dim>& surface, const Vec<dim>& place) const
{
	return distanceTo<dim>(surface, place) <
	       (1 - rounding) * distanceTo<dim>(rigid_.surface, place);
}

template <int dim>
bool RigidSeams<dim>::isNearerBefore(const RigidSurface<dim>& surface, const Vec<dim>& before) const
{
	return distanceTo<dim>(rigid_.surface, before) <
	       (1 - rounding) * distanceTo<dim>(surface, before);
}

template <int dim>
bool RigidSeams<dim>::hasTip(const RigidSurface<dim>& surface, const Vec<dim>& place) const
{
	const auto tips = tipsOf<dim>(surface, Box<dim> { place, place }.grown(alike_), spacing_);
	return std::any_of(tips.begin(), tips.end(), [&](const Tip<dim>& tip) {
		return (tip.ball.centre - place).norm() < alike_;
	});
}

template <> bool RigidSeams<3>::hasEdge(const RigidSurface<3>& surface, const Vec<3>& place) const
{
	const auto edges = edgesOf(surface, spacing_);
	return std::any_of(edges.begin(), edges.end(), [&](const ConvexEdge& edge) {
		const Vec<3> way = edge.to - edge.from;
		const double share =
			std::clamp((place - edge.from).dot(way) / way.squaredNorm(), 0., 1.);
		return (edge.from + share * way - place).norm() < alike_;
	});
}
/// (In the plane edges are the sides.)
template <> bool RigidSeams<2>::hasEdge(const RigidSurface<2>&, const Vec<2>&) const
{
	return false;
}

template <int dim> template <class Is> bool RigidSeams<dim>::anyOther(Is&& is)
{
	if (!rigid_.others) return false;
	if (!std::exchange(hasAsked_, true)) others_ = rigid_.others();
	return std::any_of(others_.begin(), others_.end(), is);
}

template class RigidSeams<2>;
template class RigidSeams<3>;

} // namespace softgrain
