// Fixed-size vectors and matrices of the kernel; `dim` is 2 or 3 everywhere.
#pragma once

#include <Eigen/Core>

namespace softgrain {

template <int dim> using Vec = Eigen::Matrix<double, dim, 1>;
template <int dim> using Mat = Eigen::Matrix<double, dim, dim>;

} // namespace softgrain
