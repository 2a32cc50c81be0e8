#include "contact/PlaceOnRigid.hpp"
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
Place<dim> placeOnSurface(const BallSurface<dim>& ball, const Vec<dim>& x, const Faces<dim>&,
			  const GoesOn<dim>&)
{
	const Vec<dim> apart = x - ball.centre;
	const double distance = apart.norm();
	if (!(distance > 0)) return std::nullopt;
	return SurfacePlace<dim> { apart / distance, distance - ball.radius, farFromEdges };
}

/// About an edge or a corner: no side lies under `x`.
template <int dim>
Place<dim> placeBeyondEdge(const Vec<dim>& foot, const Vec<dim>& x, const Faces<dim>& faces)
{
	const double distance = (x - foot).norm();
	if (!(distance > 0)) return std::nullopt;
	const Vec<dim> normal = (x - foot) / distance;
	if (!faces(normal, aboutEdge)) return std::nullopt;
	return SurfacePlace<dim> { normal, distance, 0 };
}

/// Whether a point beneath the plane of a side, at such a depth, and beyond its edge is one of that
/// side all the same: it has sunk into what rises from the edge, as in the inside corner of a box.
template <int dim>
bool isBesideEdge(const Vec<dim>& edge, const Vec<dim>& beyond, const Vec<dim>& normal,
		  double depth, const GoesOn<dim>& goesOn)
{
	// over the depth: of what a wall leaves, 1e-3 dr, it sinks a quarter before it is held
	constexpr double farthest = 4;
	return beyond.norm() < farthest * depth && goesOn(edge, beyond.normalized(), normal);
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
/// outline faces: the plate pokes into the outline then, and has no side there but its edge.
template <int dim>
bool pokesIn(const PlateSurface<dim>& plate, const std::array<double, dim>& weight,
	     const Vec<dim>& normal, double depth, const Faces<dim>& faces,
	     const GoesOn<dim>& goesOn)
{
	for (int i = 0; depth > 0 && i < dim; ++i) {
		const Vec<dim> away = awayFrom(plate, i), over = away.normalized();
		if (weight[i] * away.norm() >= depth || !faces(over, alongSide)) continue;
		const Vec<dim> edge = placeAt<dim>(plate, weight) + weight[i] * away;
		if (!goesOn(edge, over, normal)) return true;
	}
	return false;
}

template <int dim>
Place<dim> placeOnSurface(const PlateSurface<dim>& plate, const Vec<dim>& x,
			  const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	const auto weight = nearestOnFacet(x, plate.corner);
	const Vec<dim> foot = placeAt<dim>(plate, weight);
	const Vec<dim> normal = normalOf<dim>(plate);
	const double height = (x - foot).dot(normal);
	const double size = (plate.corner[1] - plate.corner[0]).norm();
	const Vec<dim> beyond = (x - foot) - height * normal;
	const bool isBeyond = beyond.norm() > edgeMargin * size;
	if (isBeyond)
		if (const auto edge = placeBeyondEdge<dim>(foot, x, faces)) return edge;
	for (const double side : { 1., -1. }) {
		const double depth = -side * height;
		const Vec<dim> out = side * normal;
		if (!faces(out, alongSide)) continue;
		if (isBeyond ? !isBesideEdge<dim>(foot, beyond, out, depth, goesOn)
			     : pokesIn<dim>(plate, weight, out, depth, faces, goesOn))
			return std::nullopt;
		SurfacePlace<dim> place { out, -depth, farFromEdges };
		place.isNearEnd = *std::min_element(weight.begin(), weight.end()) < nearEnd;
		place.isBehind = depth > 0;
		place.beside = isBeyond ? beyond.norm() : 0;
		return place;
	}
	return std::nullopt;
}

/// The place of a point `y`, in the axes of a block, on its side across axis `a`.
template <int dim>
SurfacePlace<dim> placeOnSide(const BlockSurface<dim>& block, const Vec<dim>& y, int a, double side)
{
	SurfacePlace<dim> place { side * block.axes.col(a), side * y[a] - block.halfSides[a],
				  farFromEdges };
	for (int b = 0; b < dim; ++b) {
		if (b == a) continue;
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		place.toEdge = std::min(place.toEdge, std::max(toEdge, 0.));
		place.beside = std::hypot(place.beside, std::min(toEdge, 0.));
		place.inwards -= std::copysign(1., y[b]) * block.axes.col(b);
	}
	return place;
}

/// As of a plate; `foot`: of the point `y`, in the axes of the block, on its side across axis `a`.
template <int dim>
bool pokesIn(const BlockSurface<dim>& block, int a, const Vec<dim>& y, const Vec<dim>& foot,
	     const SurfacePlace<dim>& place, const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	for (int b = 0; b < dim; ++b) {
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		if (b == a || toEdge >= -place.gap) continue;
		const Vec<dim> over = std::copysign(1., y[b]) * block.axes.col(b);
		if (faces(over, alongSide) && !goesOn(foot + toEdge * over, over, place.normal))
			return true;
	}
	return false;
}

template <int dim>
Place<dim> placeOnSurface(const BlockSurface<dim>& block, const Vec<dim>& x,
			  const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	Vec<dim> nearest = y.cwiseMax(-block.halfSides).cwiseMin(block.halfSides);
	if ((y - nearest).norm() <= edgeMargin * block.halfSides.maxCoeff()) nearest = y;
	const Vec<dim> beyond = y - nearest;
	const auto sidesBeyond = (beyond.array() != 0).count();
	if (sidesBeyond > 1)
		if (const auto edge =
			    placeBeyondEdge<dim>(block.centre + block.axes * nearest, x, faces))
			return edge;
	Place<dim> best;
	for (int a = 0; a < dim; ++a) {
		const bool isBeside = sidesBeyond > 0 && beyond[a] == 0; // of this side
		if (sidesBeyond > 1 && !isBeside) continue;
		for (const double side : { 1., -1. }) {
			auto place = placeOnSide<dim>(block, y, a, side);
			if ((best && place.gap <= best->gap) || !faces(place.normal, alongSide))
				continue;
			const Vec<dim> foot = x - place.gap * place.normal;
			const Vec<dim> out = block.axes * beyond;
			if (isBeside &&
			    !isBesideEdge<dim>(foot - out, out, place.normal, -place.gap, goesOn))
				continue;
			place.isBehind = !isBeside && sidesBeyond > 0 && place.gap < 0;
			if (place.isBehind && pokesIn<dim>(block, a, y, foot, place, faces, goesOn))
				continue;
			best = place;
		}
	}
	return best;
}

} // namespace

template <int dim>
std::optional<SurfacePlace<dim>> placeOn(const RigidSurface<dim>& surface, const Vec<dim>& x,
					 const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	return std::visit([&](const auto& s) { return placeOnSurface<dim>(s, x, faces, goesOn); },
			  surface);
}

template std::optional<SurfacePlace<2>> placeOn<2>(const RigidSurface<2>&, const Vec<2>&,
						   const Faces<2>&, const GoesOn<2>&);
template std::optional<SurfacePlace<3>> placeOn<3>(const RigidSurface<3>&, const Vec<3>&,
						   const Faces<3>&, const GoesOn<3>&);

} // namespace softgrain
