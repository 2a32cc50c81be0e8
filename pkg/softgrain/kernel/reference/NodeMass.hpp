// Nodal masses of a grain: how its mass is shared out to the background nodes.
#pragma once

#include "Vector.hpp"
#include "reference/Quadrature.hpp"
#include "reference/ShapeFunction.hpp"
#include "reference/SparseRows.hpp"

#include <vector>

namespace softgrain {

/// How the mass matrix is made diagonal.
enum class Lumping {
	/// Sums of its rows, sum_p V_p N_I(X_p). They spread mass by the width of the splines, so
	/// that the moment of inertia is too large, and the half empty nodes about the outline
	/// limit the time step.
	rowSums,
	/// In proportion to what limits the time step, and with the moments of the continuum
	/// (doc/decisions/0027-nodal-masses.md).
	balanced
};

/// Grains some node of which would have less than this share of the sum of its row are too coarse
/// to be balanced (the time step would not gain: decisions/0027): they keep the sums of rows.
constexpr double leastMassShare = 0.7;

/// Most that exact second moments may take from a node, as a share of what it has with those of
/// the sums of rows; they cost time step. With 0.4 quadratic and cubic grains lose none (0027).
constexpr double largestInertiaShare = 0.4;

/// Masses (q_0 + q_a X_a + q_ab X_a X_b) sum_J |L_IJ| with L_IJ = sum_p V_p G_I.G_J: by
/// Gershgorin's theorem no eigenvalue of M^-1 L is larger than the inverse of the smallest value of
/// the polynomial at a node. Its coefficients are such that mass and centre are those of `rowSums`,
/// and that second moments are those of the points, taken as cubes of their volumes, or as far on
/// the way to them from those of `rowSums` as `largestInertiaShare` allows.
template <int dim>
std::vector<double>
balancedNodeMass(const std::vector<Vec<dim>>& nodePosition, const std::vector<double>& rowSums,
		 const Quadrature<dim>& points, const SparseRows<ShapeFunction<dim>>& pointShapes);

} // namespace softgrain
