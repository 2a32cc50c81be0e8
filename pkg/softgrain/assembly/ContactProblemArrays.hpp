// A contact problem of either dimension as plain arrays: what goes to files and to Python.
#pragma once

#include "contact/solve/ContactSolver.hpp"

#include <vector>

namespace softgrain {

/// ContactProblem with its vectors one after the other, `dim` numbers each.
struct ContactProblemArrays {
	int dim = 2;
	SparseRows<double> delassus;
	std::vector<double> normal, freeVelocity, bias, friction, start, impulse;
};

template <int dim> ContactProblemArrays arraysOf(const ContactProblem<dim>& problem);

/// Sweeps from `start` to `impulse`; throws std::invalid_argument naming what does not fit together
/// or is out of range.
SolverReport solve(ContactProblemArrays& problem, double tolerance, int maxSweeps);

} // namespace softgrain
