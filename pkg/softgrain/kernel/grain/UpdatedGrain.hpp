// One updated-Lagrangian grain and its traffic between points and grid: the inner loops, over all
// material points of the grain.
#pragma once

#include "grain/Batch.hpp"
#include "grain/GridRows.hpp"
#include "grain/SpatialGrid.hpp"
#include "reference/SparseRows.hpp"

namespace softgrain {

/// Where points see the grid: the first node of each one's stencil, and the one-dimensional factors
/// of its shape functions, for each axis 4 values and 4 gradients (in 1/m).
struct Stencils {
	std::vector<int> first;
	std::vector<double> factors;

	/// Those of one of the places.
	template <int dim, int order>
	GridRows<dim, order> rows(const SpatialGrid<dim>& grid, std::size_t place) const
	{
		return { grid, first[place], &factors[place * factorCount<dim>] };
	}
};

/// One grain: state and what a step makes of it. Point arrays hold `laneWidth` points side by side;
/// they are filled up with points without mass at the place of the first one.
template <int dim> struct UpdatedGrain {
	std::array<std::vector<double>, dim> x;       ///< relative to the grain's origin, m
	std::array<std::vector<double>, dim> v;       ///< at t_n - dt/2, m/s
	std::array<std::vector<double>, dim * dim> F; ///< row by row
	std::vector<double> mass, volume;             ///< m_p, kg; Vp0, m^dim
	std::vector<Vec<dim>> contactX;               ///< x_s relative to the grain's origin, m
	std::vector<Vec<dim>> contactV;               ///< in the last step, m/s
	LameConstants lame;                           ///< the same in all lanes
	double spacing = 0;                           ///< h, m

	SpatialGrid<dim> grid;
	Stencils points, contacts;
	SparseRows<double> contactShapes; ///< row s: carrying nodes I with N_I(x_s), ties resolved
	SparseRows<double> delassus;      ///< W_ss', 1/kg
	BulkReport report;

	/// Lays the grid about the points and contact nodes, finds all stencils. A grain
	/// wider than `widest` (m) has fallen apart: returns false with its outermost point in
	/// `report.invertedPoint`.
	bool layGrid(int order, double widest);
	/// Mass, momentum and internal force of the nodes from the points; fills `report`. Before
	/// light nodes are tied.
	void pointsToGrid(int order, Law law, Condition condition);
	/// Shape functions of the contact nodes and W_ss', after light nodes were tied.
	void findContactMobility(int order);
	/// Moves points and contact nodes by dt with the new velocities of all nodes.
	void gridToPoints(int order, double dt, double picShare);
};

} // namespace softgrain
