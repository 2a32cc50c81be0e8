#include "Helpers.hpp"
#include "reference/PressureSpace.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> std::vector<double> randomField(int points, Random& random)
{
	std::vector<double> values(points);
	for (double& value : values)
		value = random.uniform(-1, 1);
	return values;
}

double dot(const std::vector<double>& volume, const std::vector<double>& a,
	   const std::vector<double>& b)
{
	double sum = 0;
	for (std::size_t p = 0; p < a.size(); ++p)
		sum += volume[p] * a[p] * b[p];
	return sum;
}

std::vector<double> projected(const PressureSpace& space, const std::vector<double>& volume,
			      std::vector<double> values)
{
	project<1>(space, volume, values.data());
	return values;
}

double largest(const std::vector<double>& a, const std::vector<double>& b)
{
	double largest = 0;
	for (std::size_t p = 0; p < a.size(); ++p)
		largest = std::max(largest, std::abs(a[p] - b[p]));
	return largest;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Pressure space: an orthogonal projection that keeps constants",
		       "[reference]", ((int dim), dim), 2, 3)
{
	Random random(1);
	const auto zetas = dim == 2 ? std::vector { 0.5, 0.37, 0.2, 0.13, 0.11, 0.1, 0.05 }
				    : std::vector { 0.5, 0.37, 0.2 };
	for (double zeta : zetas)
		for (double nodeSpacing : { 1.5, 2., 4. }) {
			CAPTURE(zeta, nodeSpacing);
			const auto quadrature = makeQuadrature<dim>(QuadratureRule::cutCell, zeta);
			const auto space =
				makePressureSpace<dim>(quadrature, 2 * nodeSpacing * zeta);
			const auto& V = quadrature.weight;
			const int points = static_cast<int>(V.size());
			REQUIRE(space.shapes.rows() == points);
			REQUIRE(space.functions() > dim);
			const std::vector<double> one(points, 1.);
			CHECK(largest(projected(space, V, one), one) < 1e-10);
			const auto a = randomField<dim>(points, random),
				   b = randomField<dim>(points, random);
			const auto Pa = projected(space, V, a), Pb = projected(space, V, b);
			CHECK(largest(projected(space, V, Pa), Pa) < 1e-9);
			CHECK(std::abs(dot(V, Pa, b) - dot(V, a, Pb)) < 1e-10);
			CHECK(dot(V, Pa, Pa) < dot(V, a, a));
			CHECK(std::abs(dot(V, Pa, one) - dot(V, a, one)) < 1e-10);
		}
}

TEST_CASE("Pressure space: fields side by side are projected as alone", "[reference]")
{
	Random random(2);
	const auto quadrature = makeQuadrature<2>(QuadratureRule::cutCell, 0.2);
	const auto space = makePressureSpace<2>(quadrature, 0.8);
	const int points = static_cast<int>(quadrature.point.size());
	const auto a = randomField<2>(points, random), b = randomField<2>(points, random);
	std::vector<double> both;
	for (int p = 0; p < points; ++p) {
		both.push_back(a[p]);
		both.push_back(b[p]);
	}
	project<2>(space, quadrature.weight, both.data());
	const auto Pa = projected(space, quadrature.weight, a),
		   Pb = projected(space, quadrature.weight, b);
	for (int p = 0; p < points; ++p) {
		CHECK(both[2 * p] == Pa[p]);
		CHECK(both[2 * p + 1] == Pb[p]);
	}
}

TEST_CASE("Pressure space: smooth fields are met to second order", "[reference]")
{
	auto error = [](double zeta) {
		const auto quadrature = makeQuadrature<2>(QuadratureRule::cutCell, zeta);
		const auto space = makePressureSpace<2>(quadrature, 4 * zeta);
		std::vector<double> field;
		for (const Vec<2>& X : quadrature.point)
			field.push_back(std::sin(2 * X[0]) * std::cos(X[1]));
		std::vector<double> rest = projected(space, quadrature.weight, field);
		for (std::size_t p = 0; p < field.size(); ++p)
			rest[p] -= field[p];
		return std::sqrt(dot(quadrature.weight, rest, rest));
	};
	const double coarse = error(0.1), fine = error(0.05);
	CAPTURE(coarse, fine);
	CHECK(fine < coarse / 3);
}
