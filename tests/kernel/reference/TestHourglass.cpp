#include "Helpers.hpp"
#include "grain/HourglassForces.hpp"
#include "grain/Vibrations.hpp"

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
template <int dim> double slowestOf(const TemplateRecipe& r)
{
	GrainParameters<dim> grain;
	grain.radius = 1;
	grain.constants = { 1, 0.3, 1 };
	const Eigen::VectorXd squares = eigenvalues(dynamicMatrix(singleGrain<dim>(r, grain)));
	return std::sqrt(squares[dim == 2 ? 3 : 6]) /
	       grain.constants.waveSpeed(usualCondition<dim>);
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
}

/// Without it 0.058 and 0.026, slower than the grain may spin; with projected volumes 0.28 and
/// 0.034.
TEST_CASE("Hourglass control: no motion of a grain is slow", "[reference]")
{
	CHECK(slowestOf<3>(ball(0.3)) > 0.33);
	CHECK(slowestOf<3>(cube(0.5)) > 0.13);
	TemplateRecipe disk = ball(0.2), sphere = ball(0.35);
	disk.volumetric = sphere.volumetric = VolumetricStrain::projected;
	CHECK(slowestOf<2>(disk) > 0.7);
	CHECK(slowestOf<3>(sphere) > 0.4);
}
