// The true boundary of a grain in its reference configuration, at unit size.
#pragma once

#include "Vector.hpp"
#include <array>
#include <vector>

namespace softgrain {

/// Closed piecewise linear outline: segments in 2D, triangles in 3D, oriented so that the
/// right-hand (2D: right of the direction of travel, counter-clockwise) normal points outwards.
template <int dim> struct OutlineMesh {
	std::vector<Vec<dim>> vertex;            ///< on the true boundary
	std::vector<std::array<int, dim>> facet; ///< vertex indices
};

/// Disk (dim = 2) or ball (dim = 3) of radius 1 about the origin.
template <int dim> struct UnitBall {
	/// Distance to the boundary, negative inside.
	static double signedDistance(const Vec<dim>& X) { return X.norm() - 1; }

	/// Area (2D) or volume (3D).
	static double volume();

	/// Vertices on the boundary about `spacing` (in radii) apart: at least 8 on a disk, equally
	/// spaced; on a ball a subdivided icosahedron whose mean edge is nearest to `spacing`.
	static OutlineMesh<dim> mesh(double spacing);
};

} // namespace softgrain
