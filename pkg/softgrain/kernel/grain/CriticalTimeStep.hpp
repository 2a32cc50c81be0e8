// The largest stable time step of explicit integration, dt_c = 2 / omega_max.
#pragma once

#include "grain/Batch.hpp"

#include <vector>

namespace softgrain {

/// Critical step where velocities live at the points over that where they stay at the nodes. With S
/// the (symmetric, 0 <= S <= 1) operator that takes nodal velocities to the points and back, the
/// step amplifies a mode by -1 where the largest eigenvalue of dt^2 (2 - S) M^-1 K is 4; that is at
/// most twice the largest of M^-1 K, so 1/sqrt(2) is safe.
constexpr double pointVelocityTimeStepShare = 0.7071067811865476;

/// dt_c of the undeformed grain, s.
template <int dim>
double criticalTimeStep(const GrainTemplate<dim>& reference, Condition condition,
			const GrainParameters<dim>& grain);

/// The same for congruent grains; the frequency is found once for each Poisson's ratio in the life
/// of the template.
template <int dim>
std::vector<double> criticalTimeSteps(const GrainTemplate<dim>& reference, Condition condition,
				      const std::vector<GrainParameters<dim>>& grains);

/// Finds Batch::isochoricShare where volumes are projected: the squared highest frequency of a
/// grain without the volumetric part of the law over that with it, both undeformed.
template <int dim> void findIsochoricShares(Batch<dim>& batch);

/// Critical step with damping (Damper) of a grain whose step without is `undamped`. Stable is what
/// satisfies s omega^2 dt^2 + 2 beta q omega^2 dt <= 2 (1 + exp(-alpha dt)), omega = 2/undamped,
/// with s how much the deformation stiffens and q = GrainSet::rateStiffening; a little less is
/// returned where alpha > 0. Without damping undamped/sqrt(s).
double dampedTimeStep(double undamped, const Damping& damping, double stiffening,
		      double rateStiffening);

} // namespace softgrain
