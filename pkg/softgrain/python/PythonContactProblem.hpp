// Contact problems as dicts of numpy arrays; the keys are documented at
// SoftGrainIntegrator.contactProblem.
#pragma once

#include "Yade.hpp"
#include "assembly/ContactProblemArrays.hpp"

namespace softgrain {

boost::python::dict toDict(const ContactProblemArrays& problem);

/// Solves such a dict; returns one of impulse, residual, sweeps, converged.
boost::python::dict solveDict(const boost::python::dict& problem, double tolerance, int maxSweeps);

} // namespace softgrain
