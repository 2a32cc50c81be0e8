#include "Helpers.hpp"
#include "grain/HighestFrequency.hpp"
#include "grain/Vibrations.hpp"
#include "material/Points.hpp"

#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numeric>

using namespace softgrain;
using namespace softgrain::testing;

TEMPLATE_TEST_CASE("Highest frequency: of a deformed grain", "[grain]", PlaneStrain, PlaneStress,
		   Solid)
{
	constexpr int dim = TestType::dim;
	Random random(1);
	for (int order : { 2, 3 })
		for (double size : { 0.1, 0.3 }) {
			CAPTURE(order, size);
			auto batch = singleGrain<dim>(recipe(dim == 2 ? 0.2 : 0.5, order),
						      paperGrain<dim>(), TestType::condition);
			deform<dim>(batch, 0, random.deformation<dim>(size));
			for (int I = 0; I < batch.reference->nodes(); ++I) {
				const Vec<dim> X = batch.reference->nodePosition[I]; // not affine
				batch.x.set(0, I,
					    batch.x.get(0, I) + size * 0.3 * batch.grain[0].radius *
									X[0] * X[1] *
									Vec<dim>::Unit(1));
			}
			const Eigen::VectorXd squares = eigenvalues(dynamicMatrix(batch));
			const double ratio =
				highestFrequency(batch, 0) / std::sqrt(squares[squares.size() - 1]);
			CAPTURE(ratio);
			CHECK(ratio > 1);
			CHECK(ratio < 1.0101);
		}
}

TEMPLATE_TEST_CASE("Highest frequency: few iterations find it to a percent", "[grain]", PlaneStrain,
		   PlaneStress, Solid)
{
	constexpr int dim = TestType::dim;
	Random random(3);
	for (double zeta : { dim == 2 ? 0.2 : 0.4, dim == 2 ? 0.08 : 0.15 })
		for (double nodeSpacing : { 1.25, 2. })
			for (double size : { 0., 0.1, 0.3 }) {
				auto batch =
					singleGrain<dim>(recipe(zeta, 3, nodeSpacing),
							 paperGrain<dim>(), TestType::condition);
				const Mat<dim> F = size > 0 ? random.deformation<dim>(size)
							    : Mat<dim>(Mat<dim>::Identity());
				for (int I = 0; I < batch.reference->nodes(); ++I) {
					const Vec<dim> X = batch.reference->nodePosition[I];
					const double dent = std::exp(
						-20 * (X - Vec<dim>::Unit(0)).squaredNorm());
					batch.x.set(0, I,
						    0.01 * (F * X -
							    0.5 * size * dent * Vec<dim>::Unit(0)));
				}
				const double exact = highestFrequency(batch, 0);
				auto found = [&](bool early) {
					const auto measured = highestFrequencies<dim>(
						batch, { 0 },
						[&](std::size_t, double) { return early; });
					CHECK(measured[0].forces == (early ? 8 : 24));
					return measured[0].frequency / exact;
				};
				CAPTURE(zeta, nodeSpacing, size, batch.reference->nodes());
				CHECK(found(true) > 0.99); // who uses it has 5 % to spare
				CHECK(found(true) < 1.04);
				CHECK(found(false) > 0.985);
				CHECK(found(false) <= 1 + 1e-12);
			}
}

TEMPLATE_TEST_CASE("Highest frequency: of grains side by side as of each alone", "[grain]",
		   PlaneStrain, PlaneStress, Solid)
{
	constexpr int dim = TestType::dim;
	const int count = laneWidth;
	Random random(5);
	std::vector<GrainParameters<dim>> parameters(count, paperGrain<dim>());
	for (int g = 0; g < count; ++g)
		parameters[g].radius *= 1 + 0.1 * g;
	Batch<dim> batch(makeGrainTemplate<dim>(recipe(dim == 2 ? 0.2 : 0.5)), Law::neoHookean,
			 TestType::condition, parameters);
	for (int g = 0; g < count; ++g)
		deform<dim>(batch, g, random.deformation<dim>(0.04 * g));
	std::vector<int> some(count - 2); // all but the first two, the last one first
	std::iota(some.rbegin(), some.rend(), 2);
	auto isEnough = [](std::size_t k) { return k % 3 == 0; };
	const auto together = highestFrequencies<dim>(
		batch, some, [&](std::size_t k, double) { return isEnough(k); });
	REQUIRE(together.size() == some.size());
	for (std::size_t k = 0; k < some.size(); ++k) {
		const auto alone = highestFrequencies<dim>(
			batch, { some[k] }, [&](std::size_t, double) { return isEnough(k); });
		CAPTURE(k);
		CHECK(together[k].forces == (isEnough(k) ? 8 : 24));
		CHECK(together[k].frequency == Catch::Approx(alone[0].frequency).epsilon(1e-6));
		CHECK(together[k].frequency / highestFrequency(batch, some[k]) > 0.985);
	}
}
