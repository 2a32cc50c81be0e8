// Contact on background nodes: what grains give to the nodes of a grid that is fixed in space and
// common to all of them, as in updated-Lagrangian MPM (Bardenhagen et al., Comput. Meth. Appl.
// Mech. Eng. 187, 2000). The grains' own background grids, on which they deform, have no part in
// it.
#pragma once

#include "Vector.hpp"
#include "reference/SparseRows.hpp"

#include <array>
#include <vector>

namespace softgrain {

/// Two bodies touch at a node of the grid when the centres of what each of them gives to it are
/// this many grid steps apart (Nairn, Comput. Model. Eng. Sci. 92, 2013, 271-299: 0.8).
constexpr double gridContactDistance = 0.8;

/// Material points of one body, as the grid sees them.
template <int dim> struct GridPoints {
	std::vector<Vec<dim>> position; ///< x_p, m
	std::vector<double> mass;       ///< m_p, kg
};

/// A node J of the common grid as one body sees it; N_J: multilinear hat of width 2 steps.
template <int dim> struct GridNode {
	std::array<int, dim> index;           ///< position over the grid step
	double mass = 0;                      ///< m_J = sum_p m_p N_J(x_p), kg
	Vec<dim> gradient = Vec<dim>::Zero(); ///< sum_p m_p grad N_J(x_p), kg/m; out of the body
	Vec<dim> centre = Vec<dim>::Zero();   ///< sum_p m_p N_J(x_p) x_p / m_J, m
	std::vector<std::pair<int, double>> share; ///< points and their m_p N_J(x_p) / m_J

	/// The same number in every step; unique within the reach of a pair of grains.
	int name() const;
};

/// All nodes of the grid of step `spacing` that get mass from a body, sorted by index.
template <int dim>
std::vector<GridNode<dim>> nodesOnGrid(const GridPoints<dim>& points, double spacing);

/// Rows of the velocity of J, v_J = sum_p (m_p N_J(x_p) / m_J) v_p, on the material points. Nodes
/// that are not `used` get empty rows.
template <int dim>
SparseRows<double> pointShares(const std::vector<GridNode<dim>>& nodes,
			       const std::vector<char>& used);

} // namespace softgrain
