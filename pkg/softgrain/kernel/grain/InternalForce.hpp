// The bulk of the total-Lagrangian MPM: from nodal positions to internal nodal forces.
#pragma once

#include "grain/Batch.hpp"
#include "material/PointLanes.hpp"

namespace softgrain {

/// F = sum_I x_I (x) G_I at every material point, P(F), f_I = - sum_p Vp0 P_p G_I(Xp) into
/// `batch.force`, and `batch.report` (method: section 2). Parallel over blocks of grains; the
/// result does not depend on the number of threads.
template <int dim> void computeInternalForce(Batch<dim>& batch, int threads);

/// Deformation and stress at one material point.
template <int dim> struct PointResponse {
	Vec<dim> position;   ///< in space, m
	double volume;       ///< present one, Vp0 J, m^2 (m^3)
	Mat<dim> F, cauchy;  ///< cauchy = P F^T / J, Pa, per present area
	double J;            ///< det F, in 2D of the in-plane part: present over reference area
	double F33 = 1;      ///< out-of-plane stretch in 2D
	double cauchy33 = 0; ///< out-of-plane normal stress in 2D, Pa
};
/// From an evaluated lane; position and volume are left to the caller.
template <int dim>
PointResponse<dim> pointResponse(const PointLanes<dim>& point, int lane, const OutOfPlane& out);
/// At every material point of grain `g`.
template <int dim> std::vector<PointResponse<dim>> pointResponses(const Batch<dim>& batch, int g);
/// Present area (volume) sum_p Vp0 J_p, m^2 (m^3).
template <int dim> double presentVolume(const Batch<dim>& batch, int g);

} // namespace softgrain
