// Material points: where the reference configuration is sampled and with which weight.
#pragma once

#include "Vector.hpp"
#include "reference/Outline.hpp"
#include <vector>

namespace softgrain {

enum class QuadratureRule {
	/// Every lattice cell cut with the outline: point at the centroid of what is inside. Cells
	/// whose centre is within a cell of the outline or beyond are cut into 2^dim parts with a
	/// point each: the shape functions that just reach into the grain live there, and one point
	/// a cell leaves them so soft that contacts sink in (doc/decisions/0001-rim.md).
	cutCell,
	/// Cell centres inside the outline, uniform weights (the paper). Not for polygons, whose
	/// centre of mass they move.
	lattice
};

template <int dim> struct Quadrature {
	std::vector<Vec<dim>> point; ///< Xp, in radii
	std::vector<double> weight;  ///< Vp0, in radii^dim; their sum is the exact volume
};

/// Material points on a lattice of cells of side `spacing` (dr, in radii, in [0.001, 0.5]; see
/// Outline::cellSides) with a cell corner at the centre.
template <int dim>
Quadrature<dim> makeQuadrature(QuadratureRule rule, double spacing,
			       const Outline<dim>& outline = UnitBall<dim>());

/// Centroids (cutCell) or centres (lattice) of the cells that have an empty neighbour: the boundary
/// material points of the paper, one a cell.
template <int dim>
std::vector<Vec<dim>> boundaryPoints(QuadratureRule rule, double spacing,
				     const Outline<dim>& outline = UnitBall<dim>());

} // namespace softgrain
