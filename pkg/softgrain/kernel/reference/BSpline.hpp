// Uniform B-splines on a unit grid: the one-dimensional factors of the shape functions N_I.
#pragma once

#include <array>
#include <cmath>

namespace softgrain {

constexpr int minSplineOrder = 1;
constexpr int maxSplineOrder = 3;

/// The `order + 1` B-splines that do not vanish at one coordinate.
struct SplineStencil {
	int first = 0;                                      ///< grid index of the first of them
	std::array<double, maxSplineOrder + 1> value {};    ///< N(x - i), dimensionless
	std::array<double, maxSplineOrder + 1> gradient {}; ///< dN/dx, in 1/(grid step)
};

/// B-splines of `order` 1 (linear), 2 (quadratic) or 3 (cubic) centred on the integers, at `x` in
/// grid steps. They sum to 1 and reproduce linear functions: sum_i i N(x - i) = x.
inline SplineStencil splineStencil(int order, double x)
{
	SplineStencil s;
	if (order == 1) {
		s.first = static_cast<int>(std::floor(x));
		const double t = x - s.first;
		s.value = { 1 - t, t, 0, 0 };
		s.gradient = { -1, 1, 0, 0 };
	} else if (order == 2) {
		s.first = static_cast<int>(std::floor(x + 0.5)) - 1;
		const double t = x - (s.first + 1); // in [-1/2, 1/2)
		s.value = { 0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t),
			    0 };
		s.gradient = { t - 0.5, -2 * t, t + 0.5, 0 };
	} else {
		s.first = static_cast<int>(std::floor(x)) - 1;
		const double t = x - (s.first + 1); // in [0, 1)
		const double u = 1 - t;
		s.value = { u * u * u / 6, 2. / 3 - t * t * (1 - 0.5 * t),
			    2. / 3 - u * u * (1 - 0.5 * u), t * t * t / 6 };
		s.gradient = { -0.5 * u * u, t * (1.5 * t - 2), -u * (1.5 * u - 2), 0.5 * t * t };
	}
	return s;
}

} // namespace softgrain
