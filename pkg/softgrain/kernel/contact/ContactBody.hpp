// A grain in contact: its outline, the velocities and impulses of its contact nodes, and the
// constant table that turns the one into the other.
#pragma once

#include "contact/ContactOutline.hpp"
#include "reference/SparseRows.hpp"
#include "reference/SurfaceMobility.hpp"

namespace softgrain {

template <int dim> struct ContactBody : ContactOutline<dim> {
	const SparseRows<double>* delassus = nullptr;
	const SurfaceMobility<dim>* surfaceMobility =
		nullptr; ///< the same as `delassus` for sweeps; null where there is none
	const SparseRows<double>* overlap =
		nullptr;          ///< sum_I N_I(Xs) N_I(Xs'), for averages along the outline
	double delassusScale = 0; ///< 1/(rho R^dim); table times this is W_ss', 1/kg

	/// vs at t_n + dt/2, being solved, m/s; in 3D only that of nodes in contact. Behind the
	/// nodes is room for `surfaceMobility`.
	std::vector<Vec<dim>> velocity;
	std::vector<Vec<dim>>
		velocityBefore;        ///< vs at t_n - dt/2, m/s; empty unless energies are tracked
	std::vector<Vec<dim>> impulse; ///< sum of the reactions on each node, N s
	/// 3D: blocks of nodes on which contacts of this step act; `surfaceMobility` moves no
	/// others.
	std::vector<BlockSet> markedBlocks;

	/// A contact of this step acts on the node.
	void noteContactAt(int node)
	{
		if (dim == 3 && surfaceMobility)
			markedBlocks[node / nodesPerSegment] |= blockOf(node);
	}
	/// Room for sweeps behind `velocity`; zero impulses; no block marked. For bodies in
	/// contact, before the solve.
	void prepareSolve();
	bool hasFiniteVelocities() const;
	/// W_ss', 1/kg; 0 for nodes that do not feel each other.
	double mobility(int node, int other) const;
};

} // namespace softgrain
