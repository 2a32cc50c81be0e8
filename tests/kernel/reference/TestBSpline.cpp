#include "Helpers.hpp"
#include "reference/BSpline.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace softgrain;
using softgrain::testing::Random;

namespace {

/// Random coordinates, and the knots where the pieces of the splines meet.
std::vector<double> coordinates()
{
	std::vector<double> x { -2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5, 2 };
	Random random(1);
	for (int k = 0; k < 200; ++k)
		x.push_back(random.uniform(-5, 5));
	return x;
}

/// N(x - i), 0 outside the stencil.
double spline(int order, double x, int i)
{
	const SplineStencil s = splineStencil(order, x);
	const int k = i - s.first;
	return k >= 0 && k <= order ? s.value[k] : 0;
}

} // namespace

TEST_CASE("B-splines: sums that define them", "[reference]")
{
	const int order = GENERATE(1, 2, 3);
	CAPTURE(order);
	for (double x : coordinates()) {
		CAPTURE(x);
		const SplineStencil s = splineStencil(order, x);
		double one = 0, position = 0, variance = 0, slope = 0, unit = 0;
		for (int k = 0; k <= order; ++k) {
			const double i = s.first + k;
			CHECK(s.value[k] >= 0);
			one += s.value[k];
			position += s.value[k] * i;
			variance += s.value[k] * (i - x) * (i - x);
			slope += s.gradient[k];
			unit += s.gradient[k] * i;
		}
		CHECK(std::abs(one - 1) < 1e-14);
		CHECK(std::abs(position - x) < 1e-13);
		CHECK(std::abs(slope) < 1e-14);
		CHECK(std::abs(unit - 1) < 1e-13);
		// A B-spline is the density of the sum of order + 1 uniform variables, each of
		// variance 1/12; from order 2 on the sum over the integers meets the integral.
		if (order > 1) CHECK(std::abs(variance - (order + 1) / 12.) < 1e-13);
		for (int k = order + 1; k <= maxSplineOrder; ++k) {
			CHECK(s.value[k] == 0);
			CHECK(s.gradient[k] == 0);
		}
	}
}

TEST_CASE("B-splines: gradients are the derivatives of the values", "[reference]")
{
	const int order = GENERATE(1, 2, 3);
	const double eps = 1e-6;
	Random random(2);
	for (int n = 0; n < 200; ++n) {
		const double x = random.uniform(-5, 5);
		CAPTURE(order, x);
		if (std::abs(2 * x - std::round(2 * x)) < 1e-4)
			continue; // a knot between x - eps and x + eps
		const SplineStencil s = splineStencil(order, x);
		for (int k = 0; k <= order; ++k) {
			const int i = s.first + k;
			const double slope =
				(spline(order, x + eps, i) - spline(order, x - eps, i)) / (2 * eps);
			CHECK(std::abs(s.gradient[k] - slope) < 1e-9);
		}
	}
}

TEST_CASE("B-splines: values at a node and support", "[reference]")
{
	CHECK(spline(1, 0, 0) == 1);
	CHECK(std::abs(spline(2, 0, 0) - 3. / 4) < 1e-15);
	CHECK(std::abs(spline(2, 0, 1) - 1. / 8) < 1e-15);
	CHECK(std::abs(spline(3, 0, 0) - 2. / 3) < 1e-15);
	CHECK(std::abs(spline(3, 0, -1) - 1. / 6) < 1e-15);
	CHECK(std::abs(spline(3, 1.5, 0) - 1. / 48) < 1e-15);
	for (int order : { 1, 2, 3 }) { // continuous across all knots
		for (double knot = -2.5; knot <= 2.5; knot += 0.5)
			for (int i = -5; i <= 5; ++i)
				CHECK(std::abs(spline(order, knot - 1e-12, i) -
					       spline(order, knot + 1e-12, i)) < 1e-11);
	}
}

TEMPLATE_TEST_CASE_SIG("B-splines: coefficients of the polynomials", "[reference]",
		       ((int order), order), 1, 2, 3)
{
	double worst = 0;
	for (double x : coordinates()) {
		const SplineStencil s = splineStencil(order, x);
		for (int j = 0; j < rowWidth; ++j) {
			double value = 0, gradient = 0;
			for (int k = order; k >= 0; --k) {
				value = value * s.t + splineCoefficients<order>[k][j];
				if (k > 0)
					gradient = gradient * s.t +
						   k * splineCoefficients<order>[k][j];
			}
			worst = std::max({ worst, std::abs(value - s.value[j]),
					   std::abs(gradient - s.gradient[j]) });
		}
	}
	CHECK(worst < 1e-15);
}
