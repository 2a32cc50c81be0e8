#include "Helpers.hpp"
#include "lanes/LaneMath.hpp"
#include "lanes/Parts.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <class Part> double lnOfOne(double x)
{
	return lnOf<Part>(typename Part::Numbers {} + x)[3];
}

/// Error in units in the last place of the answer.
template <class Part> double errorOfLn(double x)
{
	const long double exact = std::log(static_cast<long double>(x));
	const double answer = static_cast<double>(exact);
	const double unit =
		std::nextafter(std::abs(answer), std::numeric_limits<double>::infinity()) -
		std::abs(answer);
	return static_cast<double>(std::abs(lnOfOne<Part>(x) - exact)) / unit;
}

} // namespace

TEMPLATE_TEST_CASE("Lane math: the logarithm to two units in the last place", "[material]",
		   WholeLanes, HalfLanes)
{
	Random random(1);
	double worst = 0;
	for (int n = 0; n < 200000; ++n) {
		worst = std::max(worst, errorOfLn<TestType>(random.uniform(0.3, 3)));
		worst = std::max(worst, errorOfLn<TestType>(std::exp(random.uniform(-700, 700))));
		worst = std::max(worst, errorOfLn<TestType>(1 + random.uniform(-1e-6, 1e-6)));
	}
	for (double x : { 0.5, 2., std::sqrt(0.5), std::sqrt(2.),
			  std::numeric_limits<double>::min(), std::numeric_limits<double>::max() })
		for (double near : { std::nextafter(x, 1.), x })
			worst = std::max(worst, errorOfLn<TestType>(near));
	CHECK(worst < 2);
	CHECK(lnOfOne<TestType>(1) == 0);
}

TEMPLATE_TEST_CASE("Lane math: no logarithm where there is none, in that lane alone", "[material]",
		   WholeLanes, HalfLanes)
{
	using Limits = std::numeric_limits<double>;
	constexpr int last = TestType::width - 1;
	for (double none : { 0., -0., -1., -Limits::infinity(), Limits::infinity(),
			     Limits::quiet_NaN(), -Limits::denorm_min() }) {
		CAPTURE(none);
		auto x = typename TestType::Numbers {} + none;
		x[last] = 2;
		const auto y = lnOf<TestType>(x);
		for (int l = 0; l < last; ++l)
			CHECK(std::isnan(y[l]));
		CHECK(y[last] == lnOfOne<TestType>(2));
	}
}

TEMPLATE_TEST_CASE("Parts of lanes: transposition", "[material]", WholeLanes, HalfLanes)
{
	constexpr int width = TestType::width;
	typename TestType::Numbers row[width];
	for (int r = 0; r < width; ++r)
		for (int l = 0; l < width; ++l)
			row[r][l] = 10 * r + l;
	transpose<TestType>(row);
	for (int r = 0; r < width; ++r)
		for (int l = 0; l < width; ++l)
			CHECK(row[r][l] == 10 * l + r);
}

TEMPLATE_TEST_CASE("Parts of lanes: ends of arrays", "[material]", WholeLanes, HalfLanes)
{
	constexpr int width = TestType::width, count = width + 3;
	double numbers[count + 1] = {}, copy[count + 1] = {};
	for (int i = 0; i <= count; ++i)
		numbers[i] = i + 1;
	for (int k = 0; k < count; k += width) {
		const auto some = numbersFrom<TestType>(numbers, k, count);
		for (int l = 0; l < width; ++l)
			CHECK(some[l] == (k + l < count ? k + l + 1 : 0));
		putNumbers<TestType>(some, copy, k, count);
	}
	for (int i = 0; i < count; ++i)
		CHECK(copy[i] == numbers[i]);
	CHECK(copy[count] == 0);
}
