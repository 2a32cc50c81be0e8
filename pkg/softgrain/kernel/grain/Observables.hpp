// The grain as a whole: what a rigid body would show.
#pragma once

#include "grain/Batch.hpp"

namespace softgrain {

/// Momenta and mean motion of one grain. Angular quantities are vectors in 3D; in 2D they are
/// stored in the one out-of-plane component.
template <int dim> struct WholeGrain {
	using Angular = Eigen::Matrix<double, dim == 2 ? 1 : 3, 1>;

	double mass = 0;                      ///< kg (2D: kg/m)
	Vec<dim> centre = Vec<dim>::Zero();   ///< centre of mass relative to the grain's origin, m
	Vec<dim> velocity = Vec<dim>::Zero(); ///< of the centre of mass, m/s
	Angular angularMomentum = Angular::Zero(); ///< about the centre of mass
	Eigen::Matrix<double, Angular::RowsAtCompileTime, Angular::RowsAtCompileTime>
		inertia;                           ///< present
	Angular angularVelocity = Angular::Zero(); ///< inertia^-1 angularMomentum, 1/s
	Mat<dim> rotation = Mat<dim>::Identity();  ///< mean rotation: nearest to the motion X -> x
};

template <int dim> WholeGrain<dim> wholeGrain(const Batch<dim>& batch, int g);

/// Kinetic energy 1/2 sum_I mI v_I . w_I, J (2D: J/m). With v and w the velocities half a step
/// before and after t_n it is, with the elastic energy at t_n, the exact invariant of the linear
/// scheme.
template <int dim>
double kineticEnergy(const Batch<dim>& batch, const NodalField<dim>& v, const NodalField<dim>& w,
		     int g);

/// Skew matrix of a rotation rate: spin(omega) r = omega x r.
template <int dim> Mat<dim> spinMatrix(const typename WholeGrain<dim>::Angular& omega);

/// Current area (volume) sum_p Vp0 J_p, m^2 (m^3).
template <int dim> double currentVolume(const Batch<dim>& batch, int g);

} // namespace softgrain
