// Fixed-size vectors and matrices of the kernel; `dim` is 2 or 3 everywhere.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace softgrain {

template <int dim> using Vec = Eigen::Matrix<double, dim, 1>;
template <int dim> using Mat = Eigen::Matrix<double, dim, dim>;

/// a x b along z.
inline double cross(const Vec<2>& a, const Vec<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Both components of a Vec<2> in one load or store. (The host turns Eigen's own vectorisation
/// off.)
using BothComponents [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;
inline const BothComponents& bothOf(const Vec<2>& v)
{
	return reinterpret_cast<const BothComponents&>(v);
}

/// sum = u + a v, for the innermost loops. (What was stored component by component and is loaded as
/// a pair at once waits for both stores: never `sum = u` and then `addScaled`.)
template <int dim> void setToSum(Vec<dim>& sum, const Vec<dim>& u, double a, const Vec<dim>& v)
{
	sum = u + a * v;
}
template <> inline void setToSum<2>(Vec<2>& sum, const Vec<2>& u, double a, const Vec<2>& v)
{
	reinterpret_cast<BothComponents&>(sum) = bothOf(u) + a * bothOf(v);
}

/// sum += a v
template <int dim> void addScaled(Vec<dim>& sum, double a, const Vec<dim>& v)
{
	setToSum<dim>(sum, sum, a, v);
}

} // namespace softgrain
