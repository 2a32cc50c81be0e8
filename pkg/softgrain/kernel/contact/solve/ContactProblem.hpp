// The contact problem of one step as numbers alone: what a solver, ours or another, is given.
//
// Find impulses r with  u = u_free + W r  and, for each contact,
//     0 <= u_n + b  _|_  r_n >= 0,     |r_t| <= mu r_n, sliding opposite to u_t at the bound.
#pragma once

#include "Vector.hpp"
#include "reference/SparseRows.hpp"

#include <vector>

namespace softgrain {

struct SolverReport;

template <int dim> struct ContactProblem {
	/// W_kl, 1/kg, contacts x contacts, symmetric. Nodal masses are the same in all directions:
	/// a block of the Delassus operator is W_kl times the identity, in any frame.
	SparseRows<double> delassus;
	std::vector<Vec<dim>> normal;       ///< unit, towards the body on which r acts
	std::vector<Vec<dim>> freeVelocity; ///< u_free, relative velocities without impulses, m/s
	std::vector<double> bias;           ///< b, m/s
	std::vector<double> friction;       ///< mu
	std::vector<Vec<dim>> start;        ///< impulses the sweeps start from, N s
	std::vector<Vec<dim>> impulse;      ///< r, N s

	int contacts() const { return static_cast<int>(normal.size()); }
	/// W_kk.
	double mobility(int k) const;
	/// u_free + W r, summed anew from `impulse`.
	std::vector<Vec<dim>> velocity() const;
	/// Of `impulse`: see ResidualSum.
	double residual() const;
};

/// Solves by the sweeps of the step (ContactSolver), from `start` to `impulse`.
template <int dim>
SolverReport solve(ContactProblem<dim>& problem, double tolerance, int maxSweeps);

} // namespace softgrain
