// Surfaces of rigid bodies that soft grains touch.
#pragma once

#include "contact/ContactOutline.hpp"

#include <array>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

namespace softgrain {

/// A disk (ball).
template <int dim> struct BallSurface {
	Vec<dim> centre = Vec<dim>::Zero();
	double radius = 0; ///< m
};

/// A segment (triangle) without thickness, that is touched from both sides.
template <int dim> struct PlateSurface {
	std::array<Vec<dim>, dim> corner;
};

/// A rectangle (cuboid).
template <int dim> struct BlockSurface {
	Vec<dim> centre = Vec<dim>::Zero();
	Mat<dim> axes = Mat<dim>::Identity();  ///< of its sides, as columns of a rotation
	Vec<dim> halfSides = Vec<dim>::Ones(); ///< m
};

template <int dim>
using RigidSurface = std::variant<BallSurface<dim>, PlateSurface<dim>, BlockSurface<dim>>;

/// Where a place of a grain touches a rigid surface.
template <int dim> struct SurfacePlace {
	Vec<dim> normal; ///< unit, out of the rigid body
	double gap;      ///< m, negative for an overlap
	/// From the place to the nearest edge of its side, m: 0 on an edge or a corner; on the
	/// sides of plates and on balls infinite, wherever it is.
	double toEdge;
	bool isNearEnd = false; ///< so near to an edge of a plate that it may lie on a seam
	/// Whether the grain lies on the other side of a plate or a block: the place has come
	/// through it, or it is one of the side that the grain turns away.
	bool isBehind = false;
	/// On a side of a block: along each of its edges by 1 towards the middle.
	Vec<dim> inwards = Vec<dim>::Zero();
};

/// Whether an outline faces against a direction (unit), within the angle of a cosine.
template <int dim> using Faces = std::function<bool(const Vec<dim>&, double)>;

/// Whether another surface goes on beyond an edge: at a place of it, in the direction over it, or
/// rising to the side of this normal (both unit).
template <int dim>
using GoesOn = std::function<bool(const Vec<dim>&, const Vec<dim>&, const Vec<dim>&)>;

/// The place of the surface that a point `x` of an outline touches. `faces` is asked of the outline
/// there: it tells the two sides of a plate apart, and the sides of a block about an edge; a point
/// that faces none of them touches nothing. What a point slides past, as the edge of the next plate
/// of a floor, it does not face closely enough. `goesOn` is asked of edges that may poke into it.
template <int dim>
std::optional<SurfacePlace<dim>> placeOn(
	const RigidSurface<dim>& surface, const Vec<dim>& x, const Faces<dim>& faces,
	const GoesOn<dim>& goesOn = [](const auto&, const auto&, const auto&) { return false; });

/// Of a point from the surface; 0 inside of a ball or a block.
template <int dim> double distanceTo(const RigidSurface<dim>& surface, const Vec<dim>& x);

/// What tells where the surface is, and how large: equal for a body that has not been moved.
template <int dim> std::vector<double> placeNumbers(const RigidSurface<dim>& surface);

/// A ball that holds the surface.
template <int dim> BallSurface<dim> ballAbout(const RigidSurface<dim>& surface);

/// A ball (of radius 0: a point) that the surface ends in; between contact nodes it may enter the
/// outline of a grain.
template <int dim> struct Tip {
	BallSurface<dim> ball;
	int number; ///< its own among the tips of the surface, whatever the box
};

/// Whether an outline with this normal (unit, outwards) at a tip lies along a side that ends there,
/// within an angle: the side bears it then, by the contact nodes, not the tip. A side of a block
/// that is narrower than their spacing does not.
template <int dim>
bool liesAlongSide(const RigidSurface<dim>& surface, const Tip<dim>& tip, const Vec<dim>& normal,
		   double angle, double spacing);

/// The ball itself; corners and, in 3D, points of the edges no further apart than `spacing`, those
/// in `box`.
template <int dim>
std::vector<Tip<dim>> tipsOf(const RigidSurface<dim>& surface, const Box<dim>& box, double spacing);

} // namespace softgrain
