#include "Helpers.hpp"
#include "grain/InternalForce.hpp"
#include "material/Points.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Cases with the volumetric strain projected.
template <class Case> struct Projected : Case {
	static constexpr bool projected = true;
};
/// Cases on linear triangles.
template <class Case> struct Triangles : Case {
	static constexpr bool triangles = true;
};
template <class Case> TemplateRecipe recipeOf(double zeta)
{
	constexpr bool projected = requires { Case::projected; };
	TemplateRecipe own = projected ? projectedRecipe(zeta) : recipe(zeta);
	if (requires { Case::triangles; }) own.basis = Basis::triangles;
	return own;
}

template <class Case>
Batch<Case::dim> randomGrain(Random& random, double zeta = Case::dim == 2 ? 0.2 : 0.35)
{
	auto batch = singleGrain<Case::dim>(recipeOf<Case>(zeta), paperGrain<Case::dim>(),
					    Case::condition);
	deform<Case::dim>(batch, 0, random.deformation<Case::dim>(0.2));
	shake(batch, 0, 0.02, random);
	return batch;
}

template <int dim> double energyOf(Batch<dim>& batch)
{
	computeInternalForce(batch, 1);
	return batch.report[0].elasticEnergy;
}

/// Size of the forces, to measure their sums by.
template <int dim> double forceScale(const Batch<dim>& batch)
{
	double sum = 0;
	for (int I = 0; I < batch.reference->nodes(); ++I)
		sum += batch.force.get(0, I).norm();
	return sum;
}

} // namespace

TEMPLATE_TEST_CASE("Internal force: minus the derivative of the elastic energy", "[grain]",
		   PlaneStrain, PlaneStress, Solid, Projected<PlaneStrain>, Triangles<PlaneStrain>,
		   Projected<Solid>)
{
	constexpr int dim = TestType::dim;
	Random random(1);
	Batch<dim> batch = randomGrain<TestType>(random);
	const double eps = 1e-6 * batch.grain[0].radius;
	for (int n = 0; n < 10; ++n) {
		const Batch<dim> start = batch;
		std::vector<Vec<dim>> way(batch.reference->nodes());
		for (Vec<dim>& w : way)
			w = random.vector<dim>();
		auto energyAt = [&](double along) {
			for (int I = 0; I < batch.reference->nodes(); ++I)
				batch.x.set(0, I, start.x.get(0, I) + along * way[I]);
			return energyOf(batch);
		};
		const double slope = (energyAt(eps) - energyAt(-eps)) / (2 * eps);
		energyAt(0);
		double power = 0;
		for (int I = 0; I < batch.reference->nodes(); ++I)
			power += batch.force.get(0, I).dot(way[I]);
		CHECK(std::abs(power + slope) < 1e-6 * std::abs(slope));
	}
}

TEMPLATE_TEST_CASE("Internal force: no resultant and no moment", "[grain]", PlaneStrain,
		   PlaneStress, Solid, Projected<PlaneStrain>, Triangles<PlaneStrain>,
		   Projected<Solid>)
{
	constexpr int dim = TestType::dim;
	Random random(2);
	for (int n = 0; n < 5; ++n) {
		Batch<dim> batch = randomGrain<TestType>(random);
		computeInternalForce(batch, 1);
		Vec<dim> sum = Vec<dim>::Zero();
		Mat<dim> moment = Mat<dim>::Zero();
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			const Vec<dim> f = batch.force.get(0, I), x = batch.x.get(0, I);
			sum += f;
			moment += f * x.transpose() - x * f.transpose();
		}
		const double scale = forceScale(batch);
		CHECK(scale > 1);
		CHECK(sum.norm() < 1e-12 * scale);
		CHECK(moment.norm() < 1e-12 * scale * batch.grain[0].radius);
	}
}

TEMPLATE_TEST_CASE("Internal force: none in a grain moved rigidly", "[grain]", PlaneStrain,
		   PlaneStress, Solid, Projected<PlaneStrain>, Triangles<PlaneStrain>,
		   Projected<Solid>)
{
	constexpr int dim = TestType::dim;
	Random random(3);
	auto batch = singleGrain<dim>(recipeOf<TestType>(dim == 2 ? 0.11 : 0.3), paperGrain<dim>(),
				      TestType::condition);
	const Vec<dim> shift = random.vector<dim>(0.05);
	deform<dim>(batch, 0, random.rotation<dim>());
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.x.set(0, I, batch.x.get(0, I) + shift);
	computeInternalForce(batch, 1);
	const auto& c = batch.grain[0].constants;
	CHECK(forceScale(batch) < 1e-9 * c.young * std::pow(batch.grain[0].radius, dim - 1));
	CHECK(std::abs(batch.report[0].elasticEnergy) < 1e-10 * c.young * batch.pointScale[0]);
	CHECK(std::abs(batch.report[0].stiffening - 1) < 1e-6);
	for (const auto& r : pointResponses(batch, 0))
		CHECK(r.cauchy.norm() < 1e-10 * c.young);
}

TEMPLATE_TEST_CASE("Internal force: a homogeneous deformation is met exactly", "[grain]",
		   PlaneStrain, PlaneStress, Solid, Projected<PlaneStrain>, Triangles<PlaneStrain>,
		   Projected<Solid>)
{
	constexpr int dim = TestType::dim;
	Random random(4);
	auto batch = singleGrain<dim>(recipeOf<TestType>(dim == 2 ? 0.2 : 0.35), paperGrain<dim>(),
				      TestType::condition);
	const auto& c = batch.grain[0].constants;
	for (int n = 0; n < 5; ++n) {
		const Mat<dim> F = random.deformation<dim>(0.3);
		deform<dim>(batch, 0, F);
		computeInternalForce(batch, 1);
		const auto law = respond<TestType>(F, c);
		const double volume = batch.reference->volume * std::pow(0.01, dim);
		CHECK(std::abs(batch.report[0].elasticEnergy / (law.energy * volume) - 1) < 1e-10);
		if constexpr (!requires { TestType::projected; })
			CHECK(std::abs(batch.report[0].stiffening / law.stiffening - 1) < 1e-9);
		else
			CHECK(batch.report[0].stiffening > (1 - 1e-9) * law.stiffening);
		Mat<dim> virial = Mat<dim>::Zero(); // - sum_I f_I (x) X_I = V P
		for (int I = 0; I < batch.reference->nodes(); ++I)
			virial -= batch.force.get(0, I) * 0.01 *
				  batch.reference->nodePosition[I].transpose();
		CHECK((virial - volume * law.P).norm() < 1e-10 * volume * law.P.norm());
		for (const auto& r : pointResponses(batch, 0)) {
			CHECK((r.F - F).norm() < 1e-11);
			CHECK(std::abs(r.J - F.determinant()) < 1e-11);
		}
	}
}

TEMPLATE_TEST_CASE("Point responses: Cauchy stress is that of the 3D law", "[grain]", PlaneStrain,
		   PlaneStress, Solid)
{
	constexpr int dim = TestType::dim;
	Random random(5);
	Batch<dim> batch = randomGrain<TestType>(random);
	for (const auto& r : pointResponses(batch, 0)) {
		Mat<3> F = Mat<3>::Identity();
		F.topLeftCorner<dim, dim>() = r.F;
		if (dim == 2) F(2, 2) = r.F33;
		if (TestType::condition == Condition::planeStrain) CHECK(r.F33 == 1);
		const Mat<3> sigma = respond<Solid>(F, batch.grain[0].constants).P * F.transpose() /
				     F.determinant();
		const double scale = 1e6;
		CHECK((r.cauchy - sigma.topLeftCorner<dim, dim>()).norm() < 1e-9 * scale);
		if (dim == 2) CHECK(std::abs(r.cauchy33 - sigma(2, 2)) < 1e-9 * scale);
	}
}

TEST_CASE("Internal force: projected volumetric strain is for plane strain and 3D", "[grain]")
{
	const std::string complaint = complaintOf([] {
		singleGrain<2>(projectedRecipe(0.2), paperGrain<2>(), Condition::planeStress);
	});
	CHECK(complaint.find("volumetric = 'projected'") != std::string::npos);
}
