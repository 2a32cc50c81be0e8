// Angular quantities: a vector in 3D, its component along z in 2D.
#pragma once

#include "Vector.hpp"

#include <Eigen/Geometry>

namespace softgrain {

template <int dim> constexpr int spins = dim == 2 ? 1 : 3; ///< their number of components
template <int dim> using Spin = Eigen::Matrix<double, spins<dim>, 1>;
template <int dim> using Inertia = Eigen::Matrix<double, spins<dim>, spins<dim>>;

/// omega x arm.
template <int dim> Vec<dim> spinCross(const Spin<dim>& omega, const Vec<dim>& arm)
{
	if constexpr (dim == 2)
		return Vec<2>(-omega[0] * arm[1], omega[0] * arm[0]);
	else
		return omega.cross(arm);
}

/// arm x J.
template <int dim> Spin<dim> moment(const Vec<dim>& arm, const Vec<dim>& J)
{
	if constexpr (dim == 2)
		return Spin<2>(cross(arm, J));
	else
		return arm.cross(J);
}

/// Skew matrix of a rotation rate: spinMatrix(omega) r = omega x r.
template <int dim> Mat<dim> spinMatrix(const Spin<dim>& omega)
{
	if constexpr (dim == 2)
		return (Mat<2>() << 0, -omega[0], omega[0], 0).finished();
	else
		return (Mat<3>() << 0, -omega[2], omega[1], omega[2], 0, -omega[0], -omega[1],
			omega[0], 0)
			.finished();
}

} // namespace softgrain
