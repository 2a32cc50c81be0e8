#include "Helpers.hpp"
#include "grain/InternalForce.hpp"
#include "grain/Observables.hpp"

#include <Eigen/Dense>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Observables: spin matrix is the cross product", "[grain]")
{
	Random random(1);
	const Vec<3> omega = random.vector<3>(), r = random.vector<3>();
	CHECK((spinMatrix<3>(omega) * r - omega.cross(r)).norm() < 1e-15);
	const Spin<2> rate(2.);
	CHECK((spinMatrix<2>(rate) * Vec<2>(1, 0) - Vec<2>(0, 2)).norm() == 0); // counter-clockwise
	CHECK((spinMatrix<2>(rate) * Vec<2>(0, 1) - Vec<2>(-2, 0)).norm() == 0);
}

TEMPLATE_TEST_CASE_SIG("Observables: a grain moving as a rigid body", "[grain]", ((int dim), dim),
		       2, 3)
{
	Random random(2);
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.constants.density = 1700;
	Batch<dim> batch(makeGrainTemplate<dim>(recipe(dim == 2 ? 0.11 : 0.25)), Law::neoHookean,
			 usualCondition<dim>, { paperGrain<dim>(), grain });
	const int g = 1;
	Spin<dim> omega;
	for (int a = 0; a < omega.size(); ++a)
		omega[a] = random.uniform(-50, 50);
	const Mat<dim> Q = random.rotation<dim>();
	const Vec<dim> velocity = random.vector<dim>(), shift = random.vector<dim>(0.1);
	batch.place(g, Q, velocity, spinMatrix<dim>(omega));
	batch.moveRigidly(g, Vec<dim>::Zero(), Mat<dim>::Identity(), shift, Vec<dim>::Zero(),
			  Mat<dim>::Zero());

	const auto whole = wholeGrain(batch, g);
	const double R = grain.radius, mass = 1700 * UnitBall<dim>().volume() * std::pow(R, dim);
	CHECK(std::abs(whole.mass / mass - 1) < 1e-13);
	CHECK((whole.centre - shift).norm() < 1e-14);
	CHECK((whole.velocity - velocity).norm() < 1e-13);
	CHECK((whole.angularVelocity - omega).norm() < 1e-10);
	CHECK((whole.rotation - Q).norm() < 1e-12);
	CHECK((whole.angularMomentum - whole.inertia * omega).norm() <
	      1e-12 * whole.angularMomentum.norm());
	// m R^2/2 (disk), 2/5 m R^2 (ball); coarse grains have a little more (decisions/0027).
	const double exact = (dim == 2 ? 0.5 : 0.4) * mass * R * R;
	for (int a = 0; a < omega.size(); ++a) {
		CHECK(whole.inertia(a, a) / exact > 1);
		CHECK(whole.inertia(a, a) / exact < (dim == 2 ? 1.07 : 1.45));
	}

	const double energy = kineticEnergy(batch, batch.v, batch.v, g);
	const double rigid =
		0.5 * mass * velocity.squaredNorm() + 0.5 * omega.dot(whole.inertia * omega);
	CHECK(std::abs(energy / rigid - 1) < 1e-12);
	NodalField<dim> doubled = batch.v;
	for (int I = 0; I < batch.reference->nodes(); ++I)
		doubled.set(g, I, 2 * batch.v.get(g, I));
	CHECK(std::abs(kineticEnergy(batch, batch.v, doubled, g) / rigid - 2) < 1e-12);
	CHECK(std::abs(presentVolume(batch, g) / (UnitBall<dim>().volume() * std::pow(R, dim)) -
		       1) < 1e-11);

	const auto other = wholeGrain(batch, 0); // the neighbour in the next lane has not moved
	CHECK(other.velocity.norm() == 0);
	CHECK((other.rotation - Mat<dim>::Identity()).norm() < 1e-12);
}

TEMPLATE_TEST_CASE_SIG("Observables: rotation and volume of a deformed grain", "[grain]",
		       ((int dim), dim), 2, 3)
{
	Random random(3);
	Batch<dim> batch = singleGrain<dim>(recipe(dim == 2 ? 0.2 : 0.35));
	for (int n = 0; n < 5; ++n) {
		// F = Q U: the mean rotation is that of the polar decomposition.
		const Mat<dim> Q = random.rotation<dim>(), V = random.rotation<dim>();
		Vec<dim> stretch;
		for (int a = 0; a < dim; ++a)
			stretch[a] = random.uniform(0.6, 1.5);
		deform<dim>(batch, 0, Q * V * stretch.asDiagonal() * V.transpose());
		const auto whole = wholeGrain(batch, 0);
		CHECK((whole.rotation - Q).norm() < 1e-11);
		CHECK(std::abs(whole.rotation.determinant() - 1) < 1e-12);
		const double volume =
			stretch.prod() * UnitBall<dim>().volume() * batch.pointScale[0];
		CHECK(std::abs(presentVolume(batch, 0) / volume - 1) < 1e-11);
	}
}

TEMPLATE_TEST_CASE_SIG("Observables: a component that is not finite", "[grain]", ((int dim), dim),
		       2, 3)
{
	Random random(4);
	for (double zeta : { 0.5, 0.4, 0.3 }) { // numbers of nodes with and without a rest of four
		Batch<dim> batch = singleGrain<dim>(recipe(zeta));
		const int nodes = batch.reference->nodes();
		for (int I = 0; I < nodes; ++I)
			batch.v.set(0, I, random.vector<dim>());
		CHECK(isFinite(batch.v, 0, nodes));
		for (int I = 0; I < nodes; ++I) {
			const Vec<dim> own = batch.v.get(0, I);
			batch.v.set(0, I, Vec<dim>::Unit(I % dim) * std::nan(""));
			CHECK(!isFinite(batch.v, 0, nodes));
			batch.v.set(0, I, Vec<dim>::Unit(I % dim) / 0.);
			CHECK(!isFinite(batch.v, 0, nodes));
			batch.v.set(0, I, own);
		}
	}
}
