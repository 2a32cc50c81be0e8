// Uniform B-splines on a unit grid: the one-dimensional factors of the shape functions N_I.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

namespace softgrain {

constexpr int minSplineOrder = 1;
constexpr int maxSplineOrder = 3;
/// B-splines of one coordinate for which there is room; those of lower order end with zeros.
constexpr int rowWidth = maxSplineOrder + 1;

/// The `order + 1` B-splines that do not vanish at one coordinate.
struct SplineStencil {
	int first = 0;                            ///< grid index of the first of them
	double t = 0;                             ///< x as `splineFactors` takes it
	std::array<double, rowWidth> value {};    ///< N(x - i), dimensionless
	std::array<double, rowWidth> gradient {}; ///< dN/dx, in 1/(grid step)
};

/// One of the factors for each B-spline that does not vanish.
using SplineFactors = std::array<double, rowWidth>;

/// Grid index of the first B-spline that does not vanish at `x` (grid steps), as a number.
template <int order> double firstSpline(double x)
{
	return order == 2 ? std::floor(x + 0.5) - 1 : std::floor(x) - (order == 3);
}

/// Values and gradients at `t` from the grid node that is the first one (order 1) or the second one
/// (orders 2 and 3) of the stencil.
template <int order> void splineFactors(double t, SplineFactors& value, SplineFactors& gradient)
{
	if constexpr (order == 1) {
		value = { 1 - t, t, 0, 0 };
		gradient = { -1, 1, 0, 0 };
	} else if constexpr (order == 2) { // t in [-1/2, 1/2)
		value = { 0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t),
			  0 };
		gradient = { t - 0.5, -2 * t, t + 0.5, 0 };
	} else { // t in [0, 1)
		const double u = 1 - t;
		value = { u * u * u / 6, 2. / 3 - t * t * (1 - 0.5 * t),
			  2. / 3 - u * u * (1 - 0.5 * u), t * t * t / 6 };
		gradient = { -0.5 * u * u, t * (1.5 * t - 2), -u * (1.5 * u - 2), 0.5 * t * t };
	}
}

/// The same values as polynomials: their coefficients of 1, t, t^2 ...
template <int order> constexpr std::array<SplineFactors, order + 1> splineCoefficients;
template <>
inline constexpr std::array<SplineFactors, 2> splineCoefficients<1> { { { 1, 0, 0, 0 },
									{ -1, 1, 0, 0 } } };
template <>
inline constexpr std::array<SplineFactors, 3> splineCoefficients<2> {
	{ { 1. / 8, 3. / 4, 1. / 8, 0 }, { -1. / 2, 0, 1. / 2, 0 }, { 1. / 2, -1, 1. / 2, 0 } }
};
template <>
inline constexpr std::array<SplineFactors, 4> splineCoefficients<3> {
	{ { 1. / 6, 2. / 3, 1. / 6, 0 },
	  { -1. / 2, 0, 1. / 2, 0 },
	  { 1. / 2, -1, 1. / 2, 0 },
	  { -1. / 6, 1. / 2, -1. / 2, 1. / 6 } }
};

/// B-splines of `order` centred on the integers, at `x` in grid steps. They sum to 1 and reproduce
/// linear functions: sum_i i N(x - i) = x.
template <int order> SplineStencil splineStencil(double x)
{
	SplineStencil s;
	const double first = firstSpline<order>(x);
	s.first = static_cast<int>(first);
	s.t = x - (s.first + (order > 1));
	splineFactors<order>(s.t, s.value, s.gradient);
	return s;
}

/// The same with order 1 (linear), 2 (quadratic) or 3 (cubic) chosen at run time.
inline SplineStencil splineStencil(int order, double x)
{
	return order == 1   ? splineStencil<1>(x)
	       : order == 2 ? splineStencil<2>(x)
			    : splineStencil<3>(x);
}

/// Calls `use` with the order of splines whose gradient is continuous, 2 or 3, as a type.
template <class Use> void withSmoothOrder(int order, Use&& use)
{
	if (order == 2)
		use(std::integral_constant<int, 2> {});
	else
		use(std::integral_constant<int, 3> {});
}

/// The same of any order, from 1.
template <class Use> void withOrder(int order, Use&& use)
{
	if (order == 1)
		use(std::integral_constant<int, 1> {});
	else
		withSmoothOrder(order, use);
}

} // namespace softgrain
