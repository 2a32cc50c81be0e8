#include "Helpers.hpp"
#include "grain/HourglassForces.hpp"
#include "grain/InternalForce.hpp"

#include <Eigen/Eigenvalues>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <functional>

using namespace softgrain;
using namespace softgrain::testing;
using Catch::Approx;

namespace {

TemplateRecipe ball(double zeta, int order = 3) { return recipe(zeta, order, 1.25); }

TemplateRecipe cube(double zeta)
{
	TemplateRecipe r = ball(zeta);
	r.form.form = Form::block;
	return r;
}

/// Of all stencils of a grain, its shear modulus 1, where nodes in the box lie at what a function
/// says of their place in the grid.
double energyOf(const GrainTemplate<3>& grain, const std::function<Vec<3>(const Vec<3>&)>& at)
{
	const PointLines<3>& lines = grain.pointLines;
	double energy = 0;
	std::vector<Vec<3>> forces(lines.places, Vec<3>::Zero());
	addHourglassForces<double, 3>(
		grain.hourglass, 1.,
		[&](int place, int a) {
			Vec<3> index;
			for (int b = 0; b < 3; ++b)
				index[b] = place / lines.stride[b] % lines.size[b];
			return at(index)[a];
		},
		[&](int place, int a) -> double& { return forces[place][a]; }, energy);
	return energy;
}

/// Angular frequency, over the speed of pressure waves over the radius, of the slowest motion but
/// the rigid ones, in small displacements.
double slowestOf(const TemplateRecipe& r)
{
	GrainParameters<3> parameters;
	parameters.radius = 1;
	parameters.constants = { 1, 0.3, 1 };
	Batch<3> batch = singleGrain<3>(r, parameters);
	const int nodes = batch.reference->nodes();
	constexpr double displacement = 1e-6;
	Eigen::MatrixXd K(3 * nodes, 3 * nodes);
	for (int I = 0; I < nodes; ++I)
		for (int a = 0; a < 3; ++a) {
			const Vec<3> X = batch.x.get(0, I);
			batch.x.set(0, I, X + displacement * Vec<3>::Unit(a));
			computeInternalForce(batch, 1);
			for (int J = 0; J < nodes; ++J)
				K.block<3, 1>(3 * J, 3 * I + a) =
					-batch.force.get(0, J) / displacement /
					std::sqrt(batch.nodeMass(0, I) * batch.nodeMass(0, J));
			batch.x.set(0, I, X);
		}
	const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (K + K.transpose()),
								    Eigen::EigenvaluesOnly);
	return std::sqrt(solver.eigenvalues()[6]) /
	       parameters.constants.waveSpeed(Condition::solid);
}

} // namespace

TEST_CASE("Hourglass control: patterns of nodes are held, smooth motions are not", "[reference]")
{
	const auto grain = makeGrainTemplate<3>(ball(0.3));
	double stiffness = 0;
	for (const HourglassStencil& stencil : grain->hourglass)
		stiffness += stencil.stiffness;
	REQUIRE(stiffness > 0);
	const Vec<3> size(1, 2, 3);
	auto pattern = [&](const Vec<3>& i) -> Vec<3> {
		return std::lround(i.sum()) % 2 ? size : Vec<3>(-size);
	};
	CHECK(energyOf(*grain, pattern) == Approx(0.5 * stiffness * size.squaredNorm()));
	const Mat<3> F = Random(1).deformation<3>(0.5);
	CHECK(energyOf(*grain, [&](const Vec<3>& i) { return F * i; }) < 1e-24 * stiffness);
	auto bent = [](const Vec<3>& i) { // linear along one of any two axes
		return Vec<3>(std::pow(i[0], 3) + i[1] * i[1], i[2] * i[2] * i[1],
			      i[0] * i[1] * i[2]);
	};
	CHECK(energyOf(*grain, bent) < 1e-20 * stiffness);
}

TEST_CASE("Hourglass control: for splines that cancel in space, or where volumes are projected",
	  "[reference]")
{
	CHECK(makeGrainTemplate<2>(recipe(0.3))->hourglass.empty());
	CHECK(!makeGrainTemplate<2>(projectedRecipe(0.3))->hourglass.empty());
	CHECK(makeGrainTemplate<3>(ball(0.3, 1))->hourglass.empty());
	CHECK(!makeGrainTemplate<3>(ball(0.3, 2))->hourglass.empty());
	const auto stiffnessOf = [](const TemplateRecipe& r) {
		return makeGrainTemplate<3>(r)->hourglass.front().stiffness;
	};
	TemplateRecipe projected = ball(0.3);
	projected.volumetric = VolumetricStrain::projected;
	CHECK(stiffnessOf(projected) / stiffnessOf(ball(0.3)) ==
	      Approx(hourglassStiffness<3>(true) / hourglassStiffness<3>(false)));
}

/// Without it 0.058 and 0.026, slower than the grain may spin.
TEST_CASE("Hourglass control: no motion of a grain is slow", "[reference]")
{
	CHECK(slowestOf(ball(0.3)) > 0.33);
	CHECK(slowestOf(cube(0.5)) > 0.13);
}
