#include "Helpers.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "grain/HighestFrequency.hpp"
#include "grain/InternalForce.hpp"
#include "grain/Stiffening.hpp"
#include "grain/Vibrations.hpp"
#include "material/Points.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Rows and columns of the nodes that are at least half as heavy as the heaviest.
template <int dim> std::vector<int> heavyComponents(const GrainTemplate<dim>& reference)
{
	const double heaviest =
		*std::max_element(reference.nodeMass.begin(), reference.nodeMass.end());
	std::vector<int> list;
	for (int i = 0; i < reference.nodes() * dim; ++i)
		if (reference.nodeMass[i / dim] > 0.5 * heaviest) list.push_back(i);
	return list;
}

/// Largest displacement from rest, over the size of the initial noise, after free steps of `dt`.
template <int dim> double growth(Batch<dim> batch, double dt, int steps)
{
	const double noise = 1e-9; // far below where the law shows that it is not linear
	Random random(1);
	shake(batch, 0, noise, random);
	for (int n = 0; n < steps; ++n) {
		computeInternalForce(batch, 1);
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			batch.v.set(0, I,
				    batch.v.get(0, I) +
					    dt / batch.nodeMass(0, I) * batch.force.get(0, I));
			batch.x.set(0, I, batch.x.get(0, I) + dt * batch.v.get(0, I));
		}
	}
	double largest = 0;
	for (int I = 0; I < batch.reference->nodes(); ++I)
		largest = std::max(largest, (batch.x.get(0, I) / batch.grain[0].radius -
					     batch.reference->nodePosition[I])
						    .norm());
	for (const BulkReport& report : batch.report)
		if (report.invertedPoint >= 0) return std::numeric_limits<double>::infinity();
	return largest / noise;
}

} // namespace

TEMPLATE_TEST_CASE("Critical time step: highest frequency of the internal force", "[grain]",
		   PlaneStrain, PlaneStress, Solid)
{
	constexpr int dim = TestType::dim;
	for (int order : { 1, 2, 3 })
		for (auto [poisson, nodeSpacing] :
		     { std::pair(0.45, 2.), std::pair(0.2, 2.), std::pair(0.45, 1.25) }) {
			CAPTURE(order, poisson, nodeSpacing);
			GrainParameters<dim> grain = paperGrain<dim>();
			grain.constants.poisson = poisson;
			const auto batch =
				singleGrain<dim>(recipe(dim == 2 ? 0.23 : 0.5, order, nodeSpacing),
						 grain, TestType::condition);
			const Eigen::MatrixXd dynamics = dynamicMatrix(batch);
			const Eigen::VectorXd squares = eigenvalues(dynamics);
			const double largest = squares[squares.size() - 1],
				     exact = 2 / std::sqrt(largest);
			const double found =
				criticalTimeStep(*batch.reference, TestType::condition, grain);
			CAPTURE(found / exact);
			CHECK(found < exact); // on the safe side
			CHECK(found > 0.985 * exact);
			CHECK(squares.head(dim == 2 ? 3 : 6).cwiseAbs().maxCoeff() <
			      1e-7 * largest); // rigid motions
			// No hourglass modes: with the rim held fast, nothing inside moves without
			// stiffness. (Free rims do have soft modes, of the light nodes.)
			const std::vector<int> heavy = heavyComponents(*batch.reference);
			REQUIRE(heavy.size() >= dim);
			const Eigen::MatrixXd inside = dynamics(heavy, heavy);
			CHECK(eigenvalues(inside)[0] > 0.005 * largest);
		}
}

namespace {

/// Highest frequency squared over that of the undeformed grain, and its bound.
struct Stiffened {
	double measured, bound;
};

template <class Kind>
Stiffened stiffenedBy(const Mat<Kind::dim>& F, const TemplateRecipe& recipe, double poisson)
{
	constexpr int dim = Kind::dim;
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.constants.poisson = poisson;
	auto batch = singleGrain<dim>(recipe, grain, Kind::condition);
	findIsochoricShares(batch);
	batch.arrange({ 0 }, {});
	const double rest = highestFrequency(batch, 0);
	deform<dim>(batch, 0, F);
	computeInternalForce(batch, 1);
	const double present = highestFrequency(batch, 0);
	return { present * present / (rest * rest), std::max(1., batch.report[0].stiffening) };
}

} // namespace

TEMPLATE_TEST_CASE("Critical time step: the bound of a grain with projected volumes", "[grain]",
		   PlaneStrain, Solid)
{
	constexpr int dim = TestType::dim;
	TemplateRecipe own = projectedRecipe(dim == 2 ? 0.15 : 0.3);
	Random random(11);
	for (double poisson : { 0.3, 0.49, 0.499 }) {
		for (int n = 0; n < 4; ++n) {
			const auto [measured, bound] =
				stiffenedBy<TestType>(random.deformation<dim>(0.2), own, poisson);
			CAPTURE(poisson, measured, bound);
			CHECK(measured < bound);
		}
		// Stress grows with lambda, the waves that it stiffens are slower by as much.
		const auto [measured, bound] =
			stiffenedBy<TestType>(0.9 * Mat<dim>::Identity(), own, poisson);
		CAPTURE(poisson, measured, bound);
		CHECK(measured < bound);
		CHECK(bound < 1.25 * measured);
	}
}

TEMPLATE_TEST_CASE("Critical time step: the bound of an auxetic grain", "[grain]", PlaneStrain,
		   PlaneStress, Solid)
{
	constexpr int dim = TestType::dim;
	const TemplateRecipe own = recipe(dim == 2 ? 0.2 : 0.4);
	Random random(12);
	for (double poisson : { -0.1, -0.4, -0.8 }) {
		CAPTURE(poisson);
		const auto rest = stiffenedBy<TestType>(Mat<dim>::Identity(), own, poisson);
		CHECK(std::abs(rest.bound - 1) < 1e-7);
		for (int n = 0; n < 4; ++n) {
			const auto [measured, bound] =
				stiffenedBy<TestType>(random.deformation<dim>(0.3), own, poisson);
			CAPTURE(measured, bound);
			CHECK(measured < bound);
			CHECK(bound < 2 * measured);
		}
	}
}

TEST_CASE("Critical time step: a measured stiffening keeps its share of the bound", "[grain]")
{
	auto at = [](double bound, double energy = 1) { return BulkReport { energy, bound, -1 }; };
	Stiffening stiffening;
	CHECK(stiffening.value(at(1.015)) == 1.015);
	CHECK(!stiffening.isDue(at(1.015)));
	REQUIRE(stiffening.isDue(at(2)));
	CHECK(stiffening.value(at(2)) == 2);
	stiffening.set(at(2), 1.7);
	CHECK(stiffening.value(at(2)) == 1.7);
	CHECK(stiffening.value(at(2.05)) == 2.05 * 0.85);
	CHECK(stiffening.value(at(1.6)) == 1.6 * 0.85);
	CHECK(stiffening.value(at(1.1)) == 1); // never softer than undeformed
	CHECK(!stiffening.isDue(at(2.03)));
	CHECK(!stiffening.isDue(at(2, 10)));
	CHECK(stiffening.isDue(at(2.05)));
	const Stiffening loaded = Stiffening::fromNumbers(stiffening.numbers());
	CHECK(loaded.value(at(1.9)) == stiffening.value(at(1.9)));
	stiffening.set(at(3), 3.6); // what was measured counts, though the bound says less
	CHECK(std::abs(stiffening.value(at(3)) - 3.6) < 1e-12);
}

TEST_CASE("Critical time step: a small share holds while the grain is deformed alike", "[grain]")
{
	auto at = [](double bound, double energy) { return BulkReport { energy, bound, -1 }; };
	const double safe = 0.9 * 0.9; // 0.9 of the step found with it is stable by the bound
	Stiffening stiffening;
	stiffening.set(at(3, 1), 1.5);
	CHECK(stiffening.value(at(3, 1)) == 1.5);
	for (double bound : { 3.1, 3.7 })
		CHECK(stiffening.value(at(bound, 1.4)) == bound * 0.5);
	CHECK(stiffening.value(at(2, 0.5)) == 1.5); // it may be as stiff elsewhere
	CHECK(stiffening.value(at(1.5, 0.3)) == 1.5 * safe);
	for (const BulkReport& other : { at(3.8, 1), at(3, 1.6), at(3, 0.2) })
		CHECK(stiffening.value(other) == other.stiffening * safe);
	CHECK(stiffening.isDue(at(3.2, 1)));
	CHECK(stiffening.isDue(at(2, 1.6)));
	CHECK(!stiffening.isDue(at(3, 0.2))); // a vibration would have it measured for ever
	const Stiffening loaded = Stiffening::fromNumbers(stiffening.numbers());
	CHECK(loaded.value(at(2, 0.5)) == 1.5);
	CHECK(loaded.value(at(3, 1.6)) == 3 * safe);
	stiffening.set(at(3, 1), 0.5);
	CHECK(stiffening.value(at(3, 1)) == 3 * 0.5);
	stiffening.set(at(3, 1), std::numeric_limits<double>::quiet_NaN());
	CHECK(stiffening.value(at(3, 1)) == 3);
	for (const BulkReport& odd : { at(2, -1), at(2, 0), at(0.9, 1), at(1, 1) }) {
		stiffening.set(odd, 1.2); // or the step would be looked for for ever
		CHECK(!stiffening.isDue(odd));
	}
}

TEST_CASE("Critical time step: what is pressed in one place, then all round, stays stable",
	  "[grain]")
{
	auto batch = singleGrain<2>(recipe(0.1, 3));
	const double radius = batch.grain[0].radius;
	const double undeformed =
		2 / criticalTimeStep(*batch.reference, batch.condition, batch.grain[0]);
	auto measured = [&] {
		const double ratio = highestFrequency(batch, 0) / undeformed;
		return ratio * ratio;
	};
	auto press = [&](double depth, double breadth) { // beneath a punch on its rim
		const Vec<2> rim(1, 0);
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			const Vec<2> X = batch.reference->nodePosition[I];
			const double distance = (X - rim).norm() / breadth;
			const double way = depth * std::exp(-distance * distance);
			batch.x.set(0, I, radius * (X - Vec<2>(way, 0)));
		}
		computeInternalForce(batch, 1);
		return batch.report[0];
	};
	Stiffening stiffening;
	const BulkReport inOnePlace = press(0.08, 0.12);
	stiffening.set(inOnePlace, measured());
	const double kept = stiffening.value(inOnePlace);

	double shrunk = 1; // until somewhere it is as stiff as it was beneath the punch
	do {
		shrunk -= 0.001;
		deform<2>(batch, 0, shrunk * Mat<2>::Identity());
		computeInternalForce(batch, 1);
	} while (batch.report[0].stiffening < inOnePlace.stiffening);
	const double value = stiffening.value(batch.report[0]);
	CAPTURE(inOnePlace.stiffening, kept, value, measured());
	REQUIRE(0.81 * measured() > kept); // 0.9 of that step would not be stable
	CHECK(0.81 * measured() <= value);
}

TEMPLATE_TEST_CASE_SIG("Critical time step: separates stable from unstable free grains", "[grain]",
		       ((int dim), dim), 2, 3)
{
	for (int order : { 2, 3 }) {
		const auto batch = singleGrain<dim>(recipe(dim == 2 ? 0.2 : 0.4, order));
		const double dt =
			criticalTimeStep(*batch.reference, batch.condition, batch.grain[0]);
		const double stable = growth(batch, 0.99 * dt, 1500),
			     unstable = growth(batch, 1.05 * dt, 60);
		CAPTURE(order, stable, unstable);
		CHECK(stable < 100);
		CHECK(unstable > 1e4);
	}
}

TEST_CASE("Critical time step: as a Courant number", "[grain]")
{
	// omega_max h/c of fine disks: 1.31 cubic, 1.47 quadratic, 2.14 linear, h = 2 dr.
	const GrainParameters<2> grain = paperGrain<2>();
	const double c = grain.constants.waveSpeed(Condition::planeStrain);
	for (auto [order, expected] :
	     { std::pair(3, 1.31), std::pair(2, 1.47), std::pair(1, 2.14) }) {
		const auto reference = makeGrainTemplate<2>(recipe(0.1, order));
		const double h = 2 * 0.1 * grain.radius;
		const double number =
			2 / criticalTimeStep(*reference, Condition::planeStrain, grain) * h / c;
		CAPTURE(order, number);
		CHECK(std::abs(number / expected - 1) < 0.03);
	}
}

TEST_CASE("Critical time step: what a template knows is of one condition and Poisson's ratio",
	  "[grain]")
{
	const auto shared = makeGrainTemplate<2>(recipe(0.3));
	for (auto [condition, poisson] :
	     { std::pair(Condition::planeStrain, 0.45), std::pair(Condition::planeStress, 0.45),
	       std::pair(Condition::planeStrain, 0.2), std::pair(Condition::planeStrain, 0.45) }) {
		CAPTURE(static_cast<int>(condition), poisson);
		GrainParameters<2> grain = paperGrain<2>();
		grain.constants.poisson = poisson;
		const auto fresh = makeGrainTemplate<2>(recipe(0.3));
		CHECK(criticalTimeStep(*shared, condition, grain) ==
		      criticalTimeStep(*fresh, condition, grain));
	}
}

TEST_CASE("Critical time step: scales with size and wave speed", "[grain]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.3));
	GrainParameters<2> grain = paperGrain<2>();
	const double dt = criticalTimeStep(*reference, Condition::planeStrain, grain);
	grain.radius *= 3;
	grain.constants.young *= 4;
	grain.constants.density *= 16;
	CHECK(std::abs(criticalTimeStep(*reference, Condition::planeStrain, grain) / (6 * dt) - 1) <
	      1e-12);
}

TEMPLATE_TEST_CASE_SIG("Critical time step: with projected volumetric strain", "[grain]",
		       ((int dim), dim), 2, 3)
{
	for (double poisson : { 0.3, 0.49, 0.499 }) {
		GrainParameters<dim> grain = paperGrain<dim>();
		grain.constants.poisson = poisson;
		const double zeta = dim == 2 ? 0.23 : 0.5;
		const auto batch = singleGrain<dim>(projectedRecipe(zeta), grain);
		const Eigen::VectorXd squares = eigenvalues(dynamicMatrix(batch));
		const double exact = 2 / std::sqrt(squares[squares.size() - 1]);
		const double found = criticalTimeStep(*batch.reference, usualCondition<dim>, grain);
		CAPTURE(poisson, found / exact);
		CHECK(found < exact);
		CHECK(found > 0.985 * exact);
		const auto pointwise = singleGrain<dim>(recipe(zeta), grain);
		CHECK(found >
		      0.99 * criticalTimeStep(*pointwise.reference, usualCondition<dim>, grain));
	}
}
