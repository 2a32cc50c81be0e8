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

/// Error in units in the last place of the answer.
double errorOfLn(double x)
{
	const long double exact = std::log(static_cast<long double>(x));
	const double answer = static_cast<double>(exact);
	const double unit =
		std::nextafter(std::abs(answer), std::numeric_limits<double>::infinity()) -
		std::abs(answer);
	return static_cast<double>(std::abs(lnOf(Lanes {} + x)[3] - exact)) / unit;
}

} // namespace

TEST_CASE("Lane math: the logarithm to two units in the last place", "[material]")
{
	Random random(1);
	double worst = 0;
	for (int n = 0; n < 200000; ++n) {
		worst = std::max(worst, errorOfLn(random.uniform(0.3, 3)));
		worst = std::max(worst, errorOfLn(std::exp(random.uniform(-700, 700))));
		worst = std::max(worst, errorOfLn(1 + random.uniform(-1e-6, 1e-6)));
	}
	for (double x : { 0.5, 2., std::sqrt(0.5), std::sqrt(2.),
			  std::numeric_limits<double>::min(), std::numeric_limits<double>::max() })
		for (double near : { std::nextafter(x, 1.), x })
			worst = std::max(worst, errorOfLn(near));
	CHECK(worst < 2);
	CHECK(lnOf(Lanes {} + 1)[0] == 0);
}

TEST_CASE("Lane math: no logarithm where there is none, in that lane alone", "[material]")
{
	using Limits = std::numeric_limits<double>;
	const Lanes x { 0,
			-0.,
			-1,
			-Limits::infinity(),
			Limits::infinity(),
			Limits::quiet_NaN(),
			-Limits::denorm_min(),
			2 };
	const Lanes y = lnOf(x);
	for (int l = 0; l < laneWidth - 1; ++l)
		CHECK(std::isnan(y[l]));
	CHECK(y[laneWidth - 1] == lnOf(Lanes {} + 2)[0]);
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
