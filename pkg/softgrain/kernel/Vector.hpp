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

/// sum += a v, for the innermost loops. (The host turns Eigen's own vectorisation off.)
template <int dim> void addScaled(Vec<dim>& sum, double a, const Vec<dim>& v) { sum += a * v; }
template <> inline void addScaled<2>(Vec<2>& sum, double a, const Vec<2>& v)
{
	using Pair [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;
	reinterpret_cast<Pair&>(sum) += a * reinterpret_cast<const Pair&>(v);
}

template <int dim> double largestNorm(const Vec<dim>* vectors, std::size_t count)
{
	double squared = 0;
	for (std::size_t k = 0; k < count; ++k)
		squared = std::max(squared, vectors[k].squaredNorm());
	return std::sqrt(squared);
}
template <int dim> double largestNorm(const std::vector<Vec<dim>>& vectors)
{
	return largestNorm<dim>(vectors.data(), vectors.size());
}

} // namespace softgrain
