// Fixed-size vectors and matrices of the kernel; `dim` is 2 or 3 everywhere.
#pragma once

#include <Eigen/Core>

namespace softgrain {

template <int dim> using Vec = Eigen::Matrix<double, dim, 1>;
template <int dim> using Mat = Eigen::Matrix<double, dim, dim>;

/// sum += a v, for the innermost loops. (The host turns Eigen's own vectorisation off.)
template <int dim> void addScaled(Vec<dim>& sum, double a, const Vec<dim>& v) { sum += a * v; }
template <> inline void addScaled<2>(Vec<2>& sum, double a, const Vec<2>& v)
{
	using Pair [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;
	reinterpret_cast<Pair&>(sum) += a * reinterpret_cast<const Pair&>(v);
}

} // namespace softgrain
