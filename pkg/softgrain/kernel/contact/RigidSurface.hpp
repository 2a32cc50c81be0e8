// Surfaces of rigid bodies that soft grains touch.
#pragma once

#include "Vector.hpp"

#include <array>
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

/// Of a point from the surface; 0 inside of a ball or a block.
template <int dim> double distanceTo(const RigidSurface<dim>& surface, const Vec<dim>& x);

/// Its nearest place; x inside of a ball or a block.
template <int dim> Vec<dim> nearestPlaceOn(const RigidSurface<dim>& surface, const Vec<dim>& x);

/// What tells where the surface is, and how large: equal for a body that has not been moved.
template <int dim> std::vector<double> placeNumbers(const RigidSurface<dim>& surface);

/// A ball that holds the surface.
template <int dim> BallSurface<dim> ballAbout(const RigidSurface<dim>& surface);

/// Unit; which of both sides it points to is that of the order of the corners.
template <int dim> Vec<dim> normalOf(const PlateSurface<dim>& plate);

/// The place with these weights of the corners, m.
template <int dim>
Vec<dim> placeAt(const PlateSurface<dim>& plate, const std::array<double, dim>& weight);

} // namespace softgrain
