#include "Helpers.hpp"
#include "reference/Outline.hpp"
#include "reference/Quadrature.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> Vec<dim> halves()
{
	const Vec<3> all(2.3, 1, 1.4);
	return all.head<dim>();
}

template <int dim> TemplateRecipe blockRecipe(double zeta)
{
	TemplateRecipe r = recipe(zeta);
	r.form.form = Form::block;
	r.form.aspect = { 2.3, 1, dim == 2 ? 1 : 1.4 };
	return r;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Block: distance, volume and what is inside of a cell", "[reference]",
		       ((int dim), dim), 2, 3)
{
	const Block<dim> block(halves<dim>());
	CHECK(std::abs(block.volume() / (dim == 2 ? 9.2 : 25.76) - 1) < 1e-14);
	CHECK(block.inradius() == 1);
	CHECK(block.signedDistance(Vec<dim>::Zero()) == -1);
	Vec<dim> beyond = halves<dim>();
	beyond[0] += 3;
	beyond[1] += 4;
	CHECK(std::abs(block.signedDistance(beyond) - 5) < 1e-14);
	beyond = Vec<dim>::Zero();
	beyond[0] = 2;
	CHECK(std::abs(block.signedDistance(beyond) + 0.3) < 1e-14);

	// a unit cell about a corner: a 2^dim-th of it is inside
	const auto inside = block.cut(halves<dim>(), Vec<dim>::Ones());
	REQUIRE(inside);
	CHECK(std::abs(inside->volume - std::pow(0.5, dim)) < 1e-14);
	CHECK((inside->first / inside->volume - (halves<dim>() - Vec<dim>::Constant(0.25))).norm() <
	      1e-14);
	CHECK(block.cut(Vec<dim>(2 * halves<dim>()), Vec<dim>::Ones())->volume == 0);
}

TEMPLATE_TEST_CASE_SIG("Block: moments of the quadrature", "[reference]", ((int dim), dim), 2, 3)
{
	const Block<dim> block(halves<dim>());
	for (QuadratureRule rule : { QuadratureRule::cutCell, QuadratureRule::lattice })
		for (double spacing : { 0.2, 0.37, 0.5 }) {
			CAPTURE(spacing);
			const auto q = makeQuadrature<dim>(rule, spacing, block);
			double volume = 0;
			Vec<dim> first = Vec<dim>::Zero(), second = Vec<dim>::Zero();
			for (std::size_t p = 0; p < q.point.size(); ++p) {
				CHECK(block.signedDistance(q.point[p]) < 0);
				volume += q.weight[p];
				first += q.weight[p] * q.point[p];
				second += q.weight[p] * q.point[p].cwiseAbs2();
			}
			CHECK(std::abs(volume / block.volume() - 1) < 1e-13);
			CHECK(first.norm() < 1e-12);
			// a point loses the moment of its cell about the centre, dr^2/12
			const Vec<dim> exact = block.volume() * halves<dim>().cwiseAbs2() / 3;
			const double lost = block.volume() * spacing * spacing / 12;
			CHECK(((exact - second).array() > 0).all());
			CHECK(((exact - second).array() < 1.4 * lost).all());
		}
}

TEMPLATE_TEST_CASE_SIG("Block: a closed outline with nodes in the corners", "[reference]",
		       ((int dim), dim), 2, 3)
{
	const Block<dim> block(halves<dim>());
	const auto mesh = block.mesh(0.3);
	ContactBody<dim> body;
	body.mesh = &mesh;
	body.position = mesh.vertex;
	body.updateGeometry();
	Vec<dim> sum = Vec<dim>::Zero();
	double enclosed = 0;
	for (std::size_t f = 0; f < mesh.facet.size(); ++f) {
		const Vec<dim> area = body.areaOfFacet(static_cast<int>(f));
		sum += area;
		enclosed += area.dot(mesh.vertex[mesh.facet[f][0]]) / dim;
	}
	CHECK(sum.norm() < 1e-12);
	CHECK(std::abs(enclosed / block.volume() - 1) < 1e-13);
	for (int s = 0; s < body.nodes(); ++s) {
		CHECK(std::abs(block.signedDistance(mesh.vertex[s])) < 1e-14);
		const int ends =
			((mesh.vertex[s].cwiseAbs() - halves<dim>()).array().abs() < 1e-12).count();
		CHECK(body.isSharp(s) == (ends > 1));
		// no side is rounded off: normals are those of the sides, also next to corners
		for (std::size_t f = 0; f < mesh.facet.size(); ++f)
			for (int vertex : mesh.facet[f]) {
				if (vertex != s) continue;
				const Vec<dim> n = body.normalAt(static_cast<int>(f), s);
				CHECK(std::abs(n.cwiseAbs().maxCoeff() - 1) < 1e-14);
			}
	}
}

TEST_CASE("Block: the form is checked", "[reference]")
{
	TemplateRecipe r = blockRecipe<2>(0.25);
	r.form.aspect = { 2, 1.5, 1.2 };
	CHECK(complaintOf([&] { r.validate(); }).find("aspect (smallest component) = 1.2") == 0);
	r.form.aspect = { 101, 1, 1 };
	CHECK(complaintOf([&] { r.validate(); }).find("aspect (component) = 101") == 0);
	r.form.aspect = { std::nan(""), 1, 1 };
	CHECK(complaintOf([&] { r.validate(); }).find("aspect (component) = nan") == 0);
}

TEMPLATE_TEST_CASE_SIG("Block: recipes of balls and blocks have templates of their own",
		       "[reference]", ((int dim), dim), 2, 3)
{
	const auto ball = recipe(0.5), block = blockRecipe<dim>(0.5);
	CHECK((ball < block || block < ball));
	const auto reference = makeGrainTemplate<dim>(block);
	double mass = 0;
	for (double m : reference->nodeMass)
		mass += m;
	CHECK(std::abs(mass / Block<dim>(halves<dim>()).volume() - 1) < 1e-13);
	CHECK(reference->volume == Block<dim>(halves<dim>()).volume());
}
