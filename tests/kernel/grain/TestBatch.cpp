#include "Helpers.hpp"
#include "grain/Batch.hpp"
#include "grain/InternalForce.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// More grains than two blocks of lanes hold, none like another.
template <int dim> std::vector<GrainParameters<dim>> motley(int count)
{
	Random random(1);
	std::vector<GrainParameters<dim>> grains(count);
	for (GrainParameters<dim>& grain : grains) {
		grain.radius = random.uniform(0.001, 10);
		grain.constants = { random.uniform(1e5, 1e9), random.uniform(-0.2, 0.49),
				    random.uniform(100, 8000) };
		grain.origin = random.vector<dim>(5);
	}
	return grains;
}

} // namespace

namespace {

/// Grains of `motley` that vibrate, with their forces.
template <int dim> Batch<dim> shakenMotley(const TemplateRecipe& shape, int count, int threads)
{
	const auto reference = makeGrainTemplate<dim>(shape);
	Batch<dim> batch(reference, Law::neoHookean, usualCondition<dim>, motley<dim>(count));
	Random random(2);
	for (int g = 0; g < count; ++g) {
		deform<dim>(batch, g, random.deformation<dim>(0.2));
		shake(batch, g, 0.01, random);
	}
	computeInternalForce(batch, threads);
	return batch;
}

template <int dim> Batch<dim> shakenMotley(int count, int threads, int order = 3)
{
	TemplateRecipe shape = recipe(dim == 2 ? 0.2 : 0.35);
	shape.order = order;
	return shakenMotley<dim>(shape, count, threads);
}

/// `copies` times grain `g` of a batch in a batch of their own, with their forces.
template <int dim> Batch<dim> copiesOf(const Batch<dim>& batch, int g, int copies)
{
	Batch<dim> own(batch.reference, batch.law, batch.condition,
		       std::vector(copies, batch.grain[g]));
	for (int c = 0; c < copies; ++c)
		for (int I = 0; I < batch.reference->nodes(); ++I)
			own.x.set(c, I, batch.x.get(g, I));
	computeInternalForce(own, 1);
	return own;
}

template <int dim>
void checkSameBits(const Batch<dim>& one, int g, const Batch<dim>& other, int otherG)
{
	bool same = true;
	for (int I = 0; I < one.reference->nodes(); ++I)
		same = same && one.force.get(g, I) == other.force.get(otherG, I);
	CHECK(same);
	CHECK(one.report[g].elasticEnergy == other.report[otherG].elasticEnergy);
	CHECK(one.report[g].stiffening == other.report[otherG].stiffening);
	CHECK(one.report[g].invertedPoint == other.report[otherG].invertedPoint);
}

template <int dim> void checkAgreesWithAlone(const Batch<dim>& together)
{
	for (int g = 0; g < together.grains(); ++g) {
		CAPTURE(g);
		const Batch<dim> alone = copiesOf(together, g, 1);
		double largest = 0, difference = 0;
		for (int I = 0; I < alone.reference->nodes(); ++I) {
			largest = std::max(largest, alone.force.get(0, I).norm());
			difference =
				std::max(difference,
					 (alone.force.get(0, I) - together.force.get(g, I)).norm());
		}
		CHECK(difference < 1e-12 * largest);
		CHECK(std::abs(alone.report[0].elasticEnergy / together.report[g].elasticEnergy -
			       1) < 1e-12);
		CHECK(std::abs(alone.report[0].stiffening / together.report[g].stiffening - 1) <
		      1e-12);
	}
}

/// About a circle of radius 1, with a corner below.
Ring regularPolygon(int sides)
{
	Ring ring;
	for (int k = 0; k < sides; ++k) {
		const double angle = std::numbers::pi * (2. * k / sides - 0.5);
		ring.vertex.push_back(Vec<2>(std::cos(angle), std::sin(angle)) /
				      std::cos(std::numbers::pi / sides));
		ring.corner.push_back(k);
	}
	return ring;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Batch: other grains and lanes change no bit of a grain", "[grain]",
		       ((int dim), dim), 2, 3)
{
	const double zeta = dim == 2 ? 0.2 : 0.35;
	for (const TemplateRecipe& shape : { recipe(zeta), projectedRecipe(zeta) }) {
		const Batch<dim> together = shakenMotley<dim>(shape, 19, 1);
		REQUIRE(together.blocks() ==
			3); // two full ones, and one that is computed grain by grain
		for (int g = 0; g < 19; ++g) {
			CAPTURE(g);
			const Batch<dim> among = copiesOf(together, g, g < 16 ? 5 : 2);
			for (int c = 0; c < among.grains(); ++c)
				checkSameBits(together, g, among, c);
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Batch: grains and points side by side agree up to rounding", "[grain]",
		       ((int dim, int order), dim, order), (2, 1), (2, 2), (2, 3), (3, 1), (3, 2),
		       (3, 3))
{
	checkAgreesWithAlone(shakenMotley<dim>(8, 1, order));
}

TEMPLATE_TEST_CASE_SIG("Batch: so they do where volumes are projected", "[grain]",
		       ((int dim, int order), dim, order), (2, 2), (2, 3), (3, 2), (3, 3))
{
	const TemplateRecipe shape = projectedRecipe(dim == 2 ? 0.2 : 0.35, order);
	checkAgreesWithAlone(shakenMotley<dim>(shape, 8, 1));
}

TEST_CASE("Batch: so they do whatever the outline, whose points hardly miss common lines",
	  "[grain]")
{
	for (double zeta : { 0.1, 0.12, 0.2 }) {
		CAPTURE(zeta);
		TemplateRecipe ellipse = recipe(zeta), superdisk = ellipse;
		ellipse.form.form = superdisk.form.form = Form::superdisk;
		ellipse.form.aspect[0] = 1.5;
		superdisk.form.exponent = 8;
		const TemplateRecipe hexagon = polygonRecipe(zeta, regularPolygon(6));
		for (const TemplateRecipe& shape : { ellipse, superdisk, hexagon })
			checkAgreesWithAlone(shakenMotley<2>(shape, 8, 1));
	}
}

TEMPLATE_TEST_CASE_SIG("Batch: threads and repetition change no bit", "[grain]", ((int dim), dim),
		       2, 3)
{
	const Batch<dim> once = shakenMotley<dim>(19, 1);
	for (int threads : { 1, 2, 3 }) {
		const Batch<dim> again = shakenMotley<dim>(19, threads);
		for (int g = 0; g < 19; ++g)
			checkSameBits(once, g, again, g);
	}
}

TEMPLATE_TEST_CASE_SIG("Batch: the first inverted point of each grain is named", "[grain]",
		       ((int dim), dim), 2, 3)
{
	for (int count : { 1, 8, 10 }) { // points and grains side by side, a second block
		const auto reference = makeGrainTemplate<dim>(recipe(dim == 2 ? 0.2 : 0.35));
		Batch<dim> batch(reference, Law::neoHookean, usualCondition<dim>,
				 motley<dim>(count));
		const int bad = count - 1;
		// mirrors the part of the grain where x0 > 0.3 R
		const double radius = batch.grain[bad].radius;
		for (int I = 0; I < reference->nodes(); ++I) {
			Vec<dim> x = batch.x.get(bad, I);
			if (x[0] > 0.3 * radius) x[0] = 0.6 * radius - x[0];
			batch.x.set(bad, I, x);
		}
		computeInternalForce(batch, 1);
		int first = -1;
		for (int p = reference->points() - 1; p >= 0; --p) {
			Mat<dim> F = Mat<dim>::Zero();
			const auto& shapes = reference->pointShapes;
			for (int k = shapes.begin(p); k < shapes.end(p); ++k)
				F += batch.x.get(bad, shapes.column[k]) *
				     shapes.value[k].G.transpose() / radius;
			if (F.determinant() <= 0) first = p;
		}
		REQUIRE(first >= 0);
		for (int g = 0; g < count; ++g)
			CHECK(batch.report[g].invertedPoint == (g == bad ? first : -1));
	}
}

TEMPLATE_TEST_CASE_SIG("Batch: masses and energies scale with size, density and modulus", "[grain]",
		       ((int dim), dim), 2, 3)
{
	const auto reference = makeGrainTemplate<dim>(recipe(dim == 2 ? 0.2 : 0.35));
	GrainParameters<dim> small, large;
	small.radius = 1;
	small.constants = { 1, 0.3, 1 };
	large.radius = 3;
	large.constants = { 5, 0.3, 7 };
	Batch<dim> batch(reference, Law::neoHookean, usualCondition<dim>, { small, large });
	const double size = std::pow(3, dim);
	CHECK(std::abs(batch.mass(0) - UnitBall<dim>().volume()) < 1e-12);
	CHECK(std::abs(batch.mass(1) / batch.mass(0) / (7 * size) - 1) < 1e-14);
	for (int I = 0; I < reference->nodes(); ++I)
		CHECK(std::abs(batch.nodeMass(1, I) / batch.nodeMass(0, I) / (7 * size) - 1) <
		      1e-14);

	Random random(3);
	const Mat<dim> F = random.deformation<dim>(0.3);
	deform<dim>(batch, 0, F);
	deform<dim>(batch, 1, F);
	computeInternalForce(batch, 1);
	CHECK(std::abs(batch.report[1].elasticEnergy / batch.report[0].elasticEnergy / (5 * size) -
		       1) < 1e-12);
	for (int I = 0; I < reference->nodes(); ++I) // forces as modulus times R^(dim - 1)
		CHECK((batch.force.get(1, I) - 5 * size / 3 * batch.force.get(0, I)).norm() <
		      1e-10);
}

TEMPLATE_TEST_CASE_SIG("Batch: placing and moving a grain rigidly", "[grain]", ((int dim), dim), 2,
		       3)
{
	Random random(4);
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.origin = random.vector<dim>();
	Batch<dim> batch = singleGrain<dim>(recipe(0.35), grain);
	const Mat<dim> Q = random.rotation<dim>(), A = random.matrix<dim>();
	const Mat<dim> spin = A - A.transpose();
	const Vec<dim> velocity = random.vector<dim>();
	batch.place(0, Q, velocity, spin);
	for (int I = 0; I < batch.reference->nodes(); ++I) {
		const Vec<dim> arm = 0.01 * Q * batch.reference->nodePosition[I];
		CHECK((batch.x.get(0, I) - arm).norm() < 1e-16);
		CHECK((batch.position(0, I) - grain.origin - arm).norm() < 1e-15);
		CHECK((batch.v.get(0, I) - velocity - spin * arm).norm() < 1e-15);
	}

	shake(batch, 0, 0.05, random);
	const Batch<dim> before = batch;
	const Mat<dim> turn = random.rotation<dim>();
	const Vec<dim> centre = random.vector<dim>(0.01), shift = random.vector<dim>(),
		       push = random.vector<dim>();
	batch.moveRigidly(0, centre, turn, shift, push, spin);
	for (int I = 0; I < batch.reference->nodes(); ++I) {
		const Vec<dim> arm = turn * (before.x.get(0, I) - centre);
		CHECK((batch.x.get(0, I) - centre - shift - arm).norm() < 1e-15);
		CHECK((batch.v.get(0, I) - turn * before.v.get(0, I) - push - spin * arm).norm() <
		      1e-15);
	}
}

TEST_CASE("Nodal fields: grains exchanged stay with their fields, and are copied", "[grain]")
{
	NodalField<2> v, w;
	auto fill = [](NodalField<2>& field, double value) {
		field.resize(3, 2);
		for (int g = 0; g < 3; ++g)
			for (int I = 0; I < 2; ++I)
				field.set(g, I, Vec<2>(value, 2 * g + I));
	};
	auto valueOf = [](const NodalField<2>& field, int g) {
		CHECK(field.get(g, 1)[0] == field.get(g, 0)[0]);
		CHECK(field.of(g)[1][1] == 2 * g + 1);
		return field.get(g, 0)[0];
	};
	fill(v, 1);
	fill(w, 2);
	v.exchange(1, w);
	CHECK(valueOf(v, 0) == 1);
	CHECK(valueOf(v, 1) == 2);
	CHECK(valueOf(w, 1) == 1);
	const NodalField<2> copy = v;
	v.set(1, 0, Vec<2>(7, 7));
	CHECK(w.get(1, 0)[0] == 1);
	CHECK(valueOf(copy, 1) == 2);
	CHECK(valueOf(copy, 2) == 1);
	v.exchange(1, w);
	CHECK(valueOf(v, 1) == 1);
	CHECK(w.get(1, 0)[0] == 7);
}

TEST_CASE("Batch: inadmissible grains are named", "[grain]")
{
	const auto reference2 = makeGrainTemplate<2>(recipe(0.4));
	const auto reference3 = makeGrainTemplate<3>(recipe(0.4));
	auto complaint = [&](double radius, double poisson, Condition condition) {
		GrainParameters<2> bad = paperGrain<2>();
		bad.radius = radius;
		bad.constants.poisson = poisson;
		return complaintOf([&] {
			Batch<2>(reference2, Law::neoHookean, condition, { paperGrain<2>(), bad });
		});
	};
	CHECK(complaint(1, 0.3, Condition::planeStress) == "");
	CHECK(complaint(0, 0.3, Condition::planeStrain).starts_with("radius = 0 "));
	CHECK(complaint(-2, 0.3, Condition::planeStrain).starts_with("radius = -2 "));
	CHECK(complaint(std::numeric_limits<double>::quiet_NaN(), 0.3, Condition::planeStrain)
		      .starts_with("radius = "));
	CHECK(complaint(1, 0.5, Condition::planeStrain).starts_with("poisson = 0.5 "));
	CHECK(complaint(1, 0.3, Condition::solid).find("condition") != std::string::npos);
	CHECK(complaintOf([&] {
		      Batch<3>(reference3, Law::neoHookean, Condition::planeStrain,
			       { paperGrain<3>() });
	      }).find("condition") != std::string::npos);
}
