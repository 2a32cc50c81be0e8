// The largest stable time step of explicit integration, dt_c = 2 / omega_max.
#pragma once

#include "grain/Batch.hpp"

namespace softgrain {

/// Highest angular frequency of the undeformed grain, times R/c (dimensionless), by power iteration
/// on the linearised internal force of the template (method: section 2). Raised by 1 % because the
/// iteration approaches from below.
template <int dim>
double highestFrequency(const GrainTemplate<dim>& reference, Condition condition, double poisson);

/// dt_c of the undeformed grain, s.
template <int dim>
double criticalTimeStep(const GrainTemplate<dim>& reference, Condition condition,
			const GrainParameters<dim>& grain);

/// The same for congruent grains; the iteration runs once for each Poisson's ratio.
template <int dim>
std::vector<double> criticalTimeSteps(const GrainTemplate<dim>& reference, Condition condition,
				      const std::vector<GrainParameters<dim>>& grains);

} // namespace softgrain
