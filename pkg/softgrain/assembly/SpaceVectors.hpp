// Vectors in three dimensions, as YADE has them, and those of the kernel in the dimension of the
// grains: 2D grains lie in a plane z = const.
#pragma once

#include "Vector.hpp"
#include "grain/Observables.hpp"

#include <Eigen/Geometry>
#include <vector>

namespace softgrain {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Rotation = Eigen::Quaterniond;

/// How far a centre may be out of the plane of 2D grains, over the radius.
constexpr double planeTolerance = 1e-6;

template <int dim> Vec<dim> toKernel(const Vec3& v) { return v.head<dim>(); }
template <int dim> Vec3 toSpace(const Vec<dim>& v, double z = 0)
{
	Vec3 result(0, 0, z);
	result.head<dim>() = v;
	return result;
}
template <int dim> std::vector<Vec3> allToSpace(const std::vector<Vec<dim>>& vectors, double z = 0)
{
	std::vector<Vec3> result;
	for (const Vec<dim>& v : vectors)
		result.push_back(toSpace<dim>(v, z));
	return result;
}
template <int dim> Mat3 toSpace(const Mat<dim>& m)
{
	Mat3 result = Mat3::Zero();
	result.topLeftCorner<dim, dim>() = m;
	return result;
}
template <int dim> Spin<dim> angularToKernel(const Vec3& omega)
{
	if constexpr (dim == 2)
		return Spin<2>(omega[2]);
	else
		return omega;
}
template <int dim> Vec3 angularToSpace(const Spin<dim>& omega)
{
	if constexpr (dim == 2)
		return Vec3(0, 0, omega[0]);
	else
		return omega;
}
template <int dim> Mat<dim> rotationToKernel(const Rotation& q)
{
	return q.toRotationMatrix().template topLeftCorner<dim, dim>();
}

template <int dim> std::vector<double> numbersOf(const std::vector<Vec<dim>>& vectors)
{
	std::vector<double> numbers;
	for (const Vec<dim>& v : vectors)
		numbers.insert(numbers.end(), v.data(), v.data() + dim);
	return numbers;
}

} // namespace softgrain
