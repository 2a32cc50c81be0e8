#include "contact/search/PlaceOnRigid.hpp"
#include "contact/Facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace softgrain {

namespace {

/// An outline faces a side, and the edge of one, within the angles of these cosines. What is
/// further off than the second has a place nearer to the edge than the node, which the tips see.
constexpr double alongSide = 0.1, aboutEdge = 0.97;

template <int dim> using Place = std::optional<SurfacePlace<dim>>;

constexpr double farFromEdges = std::numeric_limits<double>::infinity();

template <int dim>
Place<dim> placeOnSurface(const BallSurface<dim>& ball, const Vec<dim>& x, const Facing<dim>&,
			  const GoesOn<dim>&, double)
{
	const Vec<dim> apart = x - ball.centre;
	const double distance = apart.norm();
	if (!(distance > 0)) return std::nullopt;
	return SurfacePlace<dim> { apart / distance, distance - ball.radius, farFromEdges };
}

/// About an edge or a corner: no side lies under `x`.
template <int dim>
Place<dim> placeBeyondEdge(const Vec<dim>& foot, const Vec<dim>& x, const Facing<dim>& facing)
{
	const double distance = (x - foot).norm();
	if (!(distance > 0)) return std::nullopt;
	const Vec<dim> normal = (x - foot) / distance;
	if (facing(normal) <= aboutEdge) return std::nullopt;
	return SurfacePlace<dim> { normal, distance, 0 };
}

/// Whether another surface, which the outline faces as well, goes on from an edge of a side: over
/// it, inclined or rising.
template <int dim>
bool goesOnFrom(const Vec<dim>& edge, const Vec<dim>& over, const Vec<dim>& normal,
		const Facing<dim>& facing, const GoesOn<dim>& goesOn)
{
	return anyRise<dim>(over, normal, [&](const Vec<dim>& way, const Vec<dim>& itsNormal) {
		return facing(itsNormal) > alongSide && goesOn(edge, way);
	});
}

/// Whether an outline faces against a direction, and more so than against the opposite one: a sharp
/// corner that leans may face both.
template <int dim> bool facesMore(const Vec<dim>& direction, const Facing<dim>& facing)
{
	return facing(direction) > std::max(alongSide, facing(-direction));
}

/// Whether a side of a block is none: the block is so thin, by what a place may have sunk into it,
/// that it is as a plate, and the outline faces the opposite side more.
template <int dim>
bool isBackOfSheet(const BlockSurface<dim>& block, int a, const Vec<dim>& normal, double sunk,
		   const Facing<dim>& facing)
{
	return block.halfSides[a] <= sunk && facing(normal) < facing(-normal);
}

/// Whether one rises steeply, as in the inside corner of a box, and the outline faces both: it may
/// have sunk into that beyond the edge, and is before the side all the same.
template <int dim>
bool risesFrom(const Vec<dim>& edge, const Vec<dim>& over, const Vec<dim>& normal,
	       const Facing<dim>& facing, const GoesOn<dim>& goesOn)
{
	if (!facesMore<dim>(normal, facing) || !facesMore<dim>(-over, facing)) return false;
	return goesOn(edge, normal) || goesOn(edge, (normal - over).normalized());
}

/// Whether a point beyond the edge of a side has sunk past that edge, to such a depth beneath the
/// plane of the side, where another surface goes on.
template <int dim>
bool isPastEdge(const Vec<dim>& edge, const Vec<dim>& beyond, const Vec<dim>& normal, double depth,
		const Facing<dim>& facing, const GoesOn<dim>& goesOn)
{
	constexpr double farthest = 4; // over the depth
	return beyond.norm() < farthest * depth &&
	       goesOnFrom<dim>(edge, beyond.normalized(), normal, facing, goesOn);
}

/// Plates and blocks that share an edge leave no slit between them: that much of one is added, over
/// its size.
constexpr double edgeMargin = 1e-9;
/// Over the height of a plate: what is nearer to an edge asks who else bears it. (Others that feel
/// it beyond their own edges are no farther than 1.4e-3 of its gap: RigidSeams.)
constexpr double nearEnd = 0.01;

/// From a corner of the plate to the opposite edge, at right angles.
Vec<2> awayFrom(const PlateSurface<2>& plate, int i)
{
	return plate.corner[1 - i] - plate.corner[i];
}
Vec<3> awayFrom(const PlateSurface<3>& plate, int i)
{
	const Vec<3>&a = plate.corner[(i + 1) % 3], &b = plate.corner[(i + 2) % 3];
	const Vec<3> edge = (b - a).normalized(), apart = a - plate.corner[i];
	return apart - apart.dot(edge) * edge;
}

/// Whether a point at such a depth beneath the plate is out of it sooner over an edge that the
/// outline faces: the plate pokes into the outline then, and has no side there but its edge. (What
/// has sunk by no more than `sunk` lies before the side that the outline faces more.)
template <int dim>
bool pokesIn(const PlateSurface<dim>& plate, const std::array<double, dim>& weight,
	     const Vec<dim>& normal, double depth, const Facing<dim>& facing,
	     const GoesOn<dim>& goesOn, double sunk)
{
	for (int i = 0; depth > 0 && i < dim; ++i) {
		const Vec<dim> away = awayFrom(plate, i), over = away.normalized();
		if (weight[i] * away.norm() >= depth || facing(over) <= alongSide) continue;
		if (depth <= sunk && facing(over) < facing(normal)) continue;
		const Vec<dim> edge = placeAt<dim>(plate, weight) + weight[i] * away;
		if (!goesOnFrom<dim>(edge, over, normal, facing, goesOn)) return true;
	}
	return false;
}

/// Whether a place on a side of the plate is at an edge where a floor that the outline is on
/// begins, and the plate is beneath: before that side, or behind it by such a depth. The outline
/// has sunk by no more than `sunk`.
template <int dim>
bool isBeneathFloor(const PlateSurface<dim>& plate, const std::array<double, dim>& weight,
		    const Vec<dim>& normal, double depth, const Facing<dim>& facing,
		    const GoesOn<dim>& goesOn, double sunk)
{
	for (int i = 0; i < dim; ++i) {
		const Vec<dim> away = awayFrom(plate, i), over = away.normalized();
		if (weight[i] * away.norm() > sunk || !facesMore<dim>(over, facing)) continue;
		const Vec<dim> edge = placeAt<dim>(plate, weight) + weight[i] * away;
		if (goesOn(edge, normal)) return true;
		const bool isBehind = depth > 0 && depth <= sunk;
		if (isBehind && facing(over) > facing(normal) && goesOn(edge, -normal)) return true;
	}
	return false;
}

template <int dim>
Place<dim> placeOnSurface(const PlateSurface<dim>& plate, const Vec<dim>& x,
			  const Facing<dim>& facing, const GoesOn<dim>& goesOn, double sunk)
{
	const auto weight = nearestOnFacet(x, plate.corner);
	const Vec<dim> foot = placeAt<dim>(plate, weight);
	const Vec<dim> normal = normalOf<dim>(plate);
	const double height = (x - foot).dot(normal);
	const double size = (plate.corner[1] - plate.corner[0]).norm();
	const Vec<dim> beyond = (x - foot) - height * normal;
	const bool isBeyond = beyond.norm() > edgeMargin * size;
	Place<dim> edge;
	if (isBeyond) edge = placeBeyondEdge<dim>(foot, x, facing);
	const double facedMore = facesMore<dim>(-normal, facing) ? -1 : 1;
	for (const double side : { facedMore, -facedMore }) {
		const double depth = -side * height;
		const Vec<dim> out = side * normal;
		if (facing(out) <= alongSide) continue;
		const bool rises = isBeyond && beyond.norm() <= sunk &&
				   risesFrom<dim>(foot, beyond.normalized(), out, facing, goesOn);
		if (edge && !rises) return edge;
		if (isBeyond ? !rises && !isPastEdge<dim>(foot, beyond, out, depth, facing, goesOn)
			     : pokesIn<dim>(plate, weight, out, depth, facing, goesOn, sunk))
			return std::nullopt;
		if (!isBeyond &&
		    isBeneathFloor<dim>(plate, weight, out, depth, facing, goesOn, sunk))
			return std::nullopt;
		SurfacePlace<dim> place { out, -depth, farFromEdges };
		place.isNearEnd = *std::min_element(weight.begin(), weight.end()) < nearEnd;
		place.isBehind = depth > 0;
		place.beside = isBeyond ? beyond.norm() : 0;
		return place;
	}
	return edge;
}

/// The place of a point `y`, in the axes of a block, on its side across axis `a`.
template <int dim>
SurfacePlace<dim> placeOnSide(const BlockSurface<dim>& block, const Vec<dim>& y, int a, double side)
{
	SurfacePlace<dim> place { side * block.axes.col(a), side * y[a] - block.halfSides[a],
				  farFromEdges };
	place.isOnBlock = true;
	for (int b = 0, edge = 0; b < dim; ++b) {
		if (b == a) continue;
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		place.toEdge = std::min(place.toEdge, std::max(toEdge, 0.));
		place.beside = std::hypot(place.beside, std::min(toEdge, 0.));
		place.edges[edge++] = { -std::copysign(1., y[b]) * block.axes.col(b), toEdge };
	}
	return place;
}

/// As of a plate; `foot`: of the point `y`, in the axes of the block, on its side across axis `a`.
template <int dim>
bool pokesIn(const BlockSurface<dim>& block, int a, const Vec<dim>& y, const Vec<dim>& foot,
	     const SurfacePlace<dim>& place, const Facing<dim>& facing, const GoesOn<dim>& goesOn)
{
	for (int b = 0; b < dim; ++b) {
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		if (b == a || toEdge >= -place.gap) continue;
		const Vec<dim> over = std::copysign(1., y[b]) * block.axes.col(b);
		if (facing(over) > alongSide &&
		    !goesOnFrom<dim>(foot + toEdge * over, over, place.normal, facing, goesOn))
			return true;
	}
	return false;
}

/// Whether a surface rises from an edge of the side across axis `a` that the point is beyond, or
/// nearer to than to the side: out of both it is over neither's edge. It has sunk into neither by
/// more than `sunk`.
template <int dim>
bool isInCorner(const BlockSurface<dim>& block, int a, const Vec<dim>& y, const Vec<dim>& foot,
		const SurfacePlace<dim>& place, const Facing<dim>& facing,
		const GoesOn<dim>& goesOn, double sunk)
{
	if (-place.gap > sunk) return false;
	const double rounding = edgeMargin * block.halfSides.maxCoeff();
	for (int b = 0; b < dim; ++b) {
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		if (b == a || toEdge > std::max(-place.gap, rounding) || toEdge < -sunk) continue;
		const Vec<dim> over = std::copysign(1., y[b]) * block.axes.col(b);
		if (risesFrom<dim>(foot + toEdge * over, over, place.normal, facing, goesOn))
			return true;
	}
	return false;
}

template <int dim> struct PlaceOnSide {
	SurfacePlace<dim> place;
	bool isInCorner;
};

/// Of two sides of a block that which a point is nearer to passing, but if it has sunk past both by
/// no more than `sunk` that which the outline faces more.
template <int dim>
bool comesFirst(const PlaceOnSide<dim>& a, const PlaceOnSide<dim>& b, const Facing<dim>& facing,
		double sunk)
{
	auto hasSunk = [&](double gap) { return gap <= 0 && gap >= -sunk; };
	if (a.isInCorner != b.isInCorner) return a.isInCorner;
	if (!a.isInCorner && hasSunk(a.place.gap) && hasSunk(b.place.gap))
		return facing(a.place.normal) > facing(b.place.normal);
	return a.place.gap > b.place.gap;
}

template <int dim>
Place<dim> placeOnSurface(const BlockSurface<dim>& block, const Vec<dim>& x,
			  const Facing<dim>& facing, const GoesOn<dim>& goesOn, double sunk)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	Vec<dim> nearest = y.cwiseMax(-block.halfSides).cwiseMin(block.halfSides);
	if ((y - nearest).norm() <= edgeMargin * block.halfSides.maxCoeff()) nearest = y;
	const Vec<dim> beyond = y - nearest;
	const auto sidesBeyond = (beyond.array() != 0).count();
	const Place<dim> edge =
		sidesBeyond > 1
			? placeBeyondEdge<dim>(block.centre + block.axes * nearest, x, facing)
			: std::nullopt;
	std::optional<PlaceOnSide<dim>> best;
	for (int a = 0; a < dim; ++a) {
		Vec<dim> beside = beyond; // of this side
		beside[a] = 0;
		const bool isBeside = !beside.isZero(0);
		for (const double side : { 1., -1. }) {
			auto place = placeOnSide<dim>(block, y, a, side);
			if (facing(place.normal) <= alongSide) continue;
			if (isBackOfSheet<dim>(block, a, place.normal, sunk, facing)) continue;
			const Vec<dim> foot = x - place.gap * place.normal;
			const Vec<dim> out = block.axes * beside;
			const bool inCorner =
				isInCorner<dim>(block, a, y, foot, place, facing, goesOn, sunk);
			if (best && !comesFirst<dim>({ place, inCorner }, *best, facing, sunk))
				continue;
			if (edge && !inCorner) continue;
			if (isBeside && !inCorner &&
			    !isPastEdge<dim>(foot - out, out, place.normal, -place.gap, facing,
					     goesOn))
				continue;
			place.isBehind = !isBeside && sidesBeyond > 0 && place.gap < 0;
			if (place.isBehind &&
			    pokesIn<dim>(block, a, y, foot, place, facing, goesOn))
				continue;
			best = { place, inCorner };
		}
	}
	return best ? best->place : edge;
}

} // namespace

template <int dim>
std::optional<SurfacePlace<dim>> placeOn(const RigidSurface<dim>& surface, const Vec<dim>& x,
					 const Facing<dim>& facing, const GoesOn<dim>& goesOn,
					 double sunk)
{
	return std::visit(
		[&](const auto& s) { return placeOnSurface<dim>(s, x, facing, goesOn, sunk); },
		surface);
}

template std::optional<SurfacePlace<2>> placeOn<2>(const RigidSurface<2>&, const Vec<2>&,
						   const Facing<2>&, const GoesOn<2>&, double);
template std::optional<SurfacePlace<3>> placeOn<3>(const RigidSurface<3>&, const Vec<3>&,
						   const Facing<3>&, const GoesOn<3>&, double);

} // namespace softgrain
