#include "Helpers.hpp"
#include "reference/BackgroundGrid.hpp"
#include "reference/GrainTemplate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> std::vector<TemplateRecipe> recipes()
{
	std::vector<TemplateRecipe> list;
	for (int order : { 1, 2, 3 })
		for (double zeta : dim == 2 ? std::vector<double> { 0.07, 0.11, 0.2, 0.29 }
					    : std::vector<double> { 0.2, 0.29 })
			for (double nodeSpacing : { 1.5, 2., 2.5 })
				list.push_back(recipe(zeta, order, nodeSpacing));
	list.push_back(recipe(0.2));
	list.back().contact = ContactGeometry::points;
	list.push_back(recipe(0.2));
	list.back().quadrature = QuadratureRule::lattice;
	return list;
}

template <int dim> double lightest(const GrainTemplate<dim>& t)
{
	return *std::min_element(t.nodeMass.begin(), t.nodeMass.end()) /
	       *std::max_element(t.nodeMass.begin(), t.nodeMass.end());
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Grain template: masses are positive and sum to the volume", "[reference]",
		       ((int dim), dim), 2, 3)
{
	std::vector<TemplateRecipe> list = recipes<dim>();
	Random random(3); // which nodes are light depends on where the outline cuts the grid
	for (int k = 0; k < (dim == 2 ? 60 : 6); ++k)
		list.push_back(recipe(random.uniform(dim == 2 ? 0.08 : 0.2, 0.5), 1 + k % 3,
				      random.uniform(1.5, 4)));
	for (const TemplateRecipe& r : list) {
		CAPTURE(r.zeta, r.order, r.nodeSpacing);
		const auto t = makeGrainTemplate<dim>(r);
		double sum = 0;
		for (double m : t->nodeMass)
			sum += m;
		CHECK(std::abs(sum / UnitBall<dim>().volume() - 1) < 1e-13);
		CHECK(lightest(*t) >
		      0.1 * lightNodeShare); // light nodes are tied, and tying makes none negative
		CHECK(static_cast<int>(t->nodeMass.size()) == t->nodes());
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: shape functions reproduce affine fields at material points",
		       "[reference]", ((int dim), dim), 2, 3)
{
	for (const TemplateRecipe& r : recipes<dim>()) {
		CAPTURE(r.zeta, r.order, r.nodeSpacing);
		const auto t = makeGrainTemplate<dim>(r);
		REQUIRE(t->pointShapes.rows() == t->points());
		double unity = 0, position = 0, noSlope = 0, slope = 0;
		for (int p = 0; p < t->points(); ++p) {
			double N = 0;
			Vec<dim> X = Vec<dim>::Zero(), G = Vec<dim>::Zero();
			Mat<dim> F = Mat<dim>::Zero();
			for (int k = t->pointShapes.begin(p); k < t->pointShapes.end(p); ++k) {
				const auto& shape = t->pointShapes.value[k];
				const Vec<dim>& XI = t->nodePosition[t->pointShapes.column[k]];
				N += shape.N;
				X += shape.N * XI;
				G += shape.G;
				F += XI * shape.G.transpose();
			}
			unity = std::max(unity, std::abs(N - 1));
			position = std::max(position, (X - t->pointPosition[p]).norm());
			noSlope = std::max(noSlope, G.norm());
			slope = std::max(slope, (F - Mat<dim>::Identity()).norm());
		}
		CHECK(unity < 1e-12);
		CHECK(position < 1e-12);
		CHECK(noSlope < 1e-10);
		CHECK(slope < 1e-10);
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: gradients are the derivatives of the shape functions",
		       "[reference]", ((int dim), dim), 2, 3)
{
	// On a grid with tied nodes too, so that the extrapolation carries the gradients with it.
	const double zeta = dim == 2 ? 0.13 : 0.25;
	const auto quadrature = makeQuadrature<dim>(QuadratureRule::cutCell, zeta);
	Random random(4);
	for (int order : { 2, 3 }) {
		const BackgroundGrid<dim> grid(order, Vec<dim>::Constant(2 * zeta), quadrature,
					       0.05);
		const int nodes = grid.position().size();
		auto dense = [&](const Vec<dim>& X) {
			SparseRows<ShapeFunction<dim>> row;
			grid.appendShapes(X, row);
			Eigen::MatrixXd table = Eigen::MatrixXd::Zero(nodes, dim + 1); // N, G
			for (int k = row.begin(0); k < row.end(0); ++k) {
				table(row.column[k], 0) = row.value[k].N;
				table.row(row.column[k]).tail(dim) = row.value[k].G.transpose();
			}
			return table;
		};
		const double eps = 1e-5;
		for (int n = 0; n < 20; ++n) {
			const Vec<dim> X = random.uniform(0, 1) * random.direction<dim>();
			const Eigen::MatrixXd here = dense(X);
			for (int a = 0; a < dim; ++a) {
				const Vec<dim> step = eps * Vec<dim>::Unit(a);
				const Eigen::VectorXd slope =
					(dense(X + step).col(0) - dense(X - step).col(0)) /
					(2 * eps);
				CHECK((slope - here.col(1 + a)).cwiseAbs().maxCoeff() <
				      (order == 2 ? 1e-3 : 1e-6));
			}
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: contact nodes follow affine motions", "[reference]",
		       ((int dim), dim), 2, 3)
{
	for (const TemplateRecipe& r : recipes<dim>()) {
		CAPTURE(r.zeta, r.order, r.nodeSpacing);
		const auto t = makeGrainTemplate<dim>(r);
		REQUIRE(t->contactShapes.rows() == t->contactNodes());
		double unity = 0, position = 0;
		for (int s = 0; s < t->contactNodes(); ++s) {
			double N = 0;
			Vec<dim> X = Vec<dim>::Zero();
			for (int k = t->contactShapes.begin(s); k < t->contactShapes.end(s); ++k) {
				N += t->contactShapes.value[k];
				X += t->contactShapes.value[k] *
				     t->nodePosition[t->contactShapes.column[k]];
			}
			unity = std::max(unity, std::abs(N - 1));
			position = std::max(position, (X - t->contactMesh.vertex[s]).norm());
		}
		CHECK(unity < 1e-12);
		CHECK(position < 1e-12);
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: a large share of tied nodes keeps mass and affine fields",
		       "[reference]", ((int dim), dim), 2, 3)
{
	// The default share ties few nodes; a large one exercises the extrapolation.
	const double zeta = dim == 2 ? 0.11 : 0.25;
	const auto quadrature = makeQuadrature<dim>(QuadratureRule::cutCell, zeta);
	const Vec<dim> h = Vec<dim>::Constant(2 * zeta);
	const BackgroundGrid<dim> all(3, h, quadrature, 0), tied(3, h, quadrature, 0.2);
	CHECK(tied.position().size() < 0.8 * all.position().size());
	double sum = 0;
	for (double m : tied.mass()) {
		CHECK(m > 0);
		sum += m;
	}
	CHECK(std::abs(sum / UnitBall<dim>().volume() - 1) < 1e-12);
	for (const Vec<dim>& X : UnitBall<dim>().mesh(0.2).vertex) {
		SparseRows<ShapeFunction<dim>> row;
		tied.appendShapes(X, row);
		double N = 0;
		Vec<dim> reproduced = Vec<dim>::Zero();
		for (int k = row.begin(0); k < row.end(0); ++k) {
			N += row.value[k].N;
			reproduced += row.value[k].N * tied.position()[row.column[k]];
		}
		CHECK(std::abs(N - 1) < 1e-12);
		CHECK((reproduced - X).norm() < 1e-12);
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: a tied node follows the nearest of all nodes",
		       "[reference]", ((int dim), dim), 2, 3)
{
	const auto quadrature =
		makeQuadrature<dim>(QuadratureRule::cutCell, dim == 2 ? 0.11 : 0.25);
	const Vec<dim> h = Vec<dim>::Constant(dim == 2 ? 0.15 : 0.4);
	const BackgroundGrid<dim> all(3, h, quadrature, 0), few(3, h, quadrature, 0.6);
	REQUIRE(few.number().size() < all.number().size());
	constexpr std::size_t wanted = dim == 2 ? 6 : 11;
	for (const auto& [index, number] : all.number()) {
		if (few.number().count(index)) continue;
		std::vector<std::pair<int, int>> nearest; // squared distance in steps, node
		for (const auto& [other, node] : few.number()) {
			int squared = 0;
			for (int a = 0; a < dim; ++a)
				squared += (other[a] - index[a]) * (other[a] - index[a]);
			nearest.push_back({ squared, node });
		}
		std::sort(nearest.begin(), nearest.end());
		const auto weights = few.extrapolation(index);
		REQUIRE(weights.size() >= wanted);
		CHECK(nearest[weights.size() - 1].first == nearest[wanted - 1].first);
		if (weights.size() < nearest.size())
			CHECK(nearest[weights.size()].first > nearest[wanted - 1].first);
		for (std::size_t k = 0; k < weights.size(); ++k)
			CHECK(weights[k].first == nearest[k].second);
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: Delassus table is N M^-1 N^T", "[reference]",
		       ((int dim), dim), 2, 3)
{
	for (ContactGeometry contact : { ContactGeometry::surface, ContactGeometry::points }) {
		TemplateRecipe r = recipe(dim == 2 ? 0.11 : 0.25);
		r.contact = contact;
		const auto t = makeGrainTemplate<dim>(r);
		const int n = t->contactNodes();
		Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, t->nodes()),
				W = Eigen::MatrixXd::Zero(n, n);
		for (int s = 0; s < n; ++s) {
			for (int k = t->contactShapes.begin(s); k < t->contactShapes.end(s); ++k)
				N(s, t->contactShapes.column[k]) += t->contactShapes.value[k];
			for (int k = t->delassus.begin(s); k < t->delassus.end(s); ++k) {
				CHECK(W(s, t->delassus.column[k]) == 0); // every entry once
				W(s, t->delassus.column[k]) = t->delassus.value[k];
			}
		}
		const Eigen::VectorXd inverseMass =
			Eigen::Map<const Eigen::VectorXd>(t->nodeMass.data(), t->nodes())
				.cwiseInverse();
		const Eigen::MatrixXd exact = N * inverseMass.asDiagonal() * N.transpose();
		CHECK((W - exact).norm() < 1e-12 * exact.norm());
		CHECK((W - W.transpose()).norm() < 1e-14 * W.norm());
		CHECK(W.diagonal().minCoeff() > 0);
		if (dim == 2) CHECK(t->delassus.column.size() < 0.6 * n * n); // banded
	}
}

TEMPLATE_TEST_CASE_SIG("Grain template: contact nodes of both geometries", "[reference]",
		       ((int dim), dim), 2, 3)
{
	TemplateRecipe r = recipe(0.2);
	r.surfaceSpacing = 1.25;
	const auto surface = makeGrainTemplate<dim>(r);
	CHECK(surface->contactRadius == 0);
	CHECK(surface->contactMesh.vertex.size() == UnitBall<dim>().mesh(0.25).vertex.size());
	CHECK(surface->contactMesh.facet.size() == UnitBall<dim>().mesh(0.25).facet.size());

	r.contact = ContactGeometry::points;
	const auto points = makeGrainTemplate<dim>(r);
	CHECK(points->contactMesh.facet.empty());
	CHECK(points->contactRadius == 0.1); // disks of diameter dr
	CHECK(points->contactMesh.vertex == boundaryPoints<dim>(r.quadrature, 0.2));
	for (const Vec<dim>& X : points->contactMesh.vertex)
		CHECK(X.norm() > 0.7);
}

TEST_CASE("Grain template: inadmissible recipes name the parameter and its value", "[reference]")
{
	auto complaint = [](auto change) {
		TemplateRecipe r;
		change(r);
		return complaintOf([&] { makeGrainTemplate<2>(r); });
	};
	auto names = [](const std::string& message, const std::string& name,
			const std::string& value) {
		CAPTURE(message, name);
		CHECK(message.starts_with(name + " = " + value));
		CHECK(message.find("range") != std::string::npos);
	};
	names(complaint([](TemplateRecipe& r) { r.zeta = 3; }), "zeta", "3");
	names(complaint([](TemplateRecipe& r) { r.zeta = 0; }), "zeta", "0");
	names(complaint([](TemplateRecipe& r) { r.zeta = -0.1; }), "zeta", "-0.1");
	names(complaint(
		      [](TemplateRecipe& r) { r.zeta = std::numeric_limits<double>::quiet_NaN(); }),
	      "zeta", "nan");
	names(complaint([](TemplateRecipe& r) { r.order = 5; }), "order", "5");
	names(complaint([](TemplateRecipe& r) { r.order = 0; }), "order", "0");
	names(complaint([](TemplateRecipe& r) { r.nodeSpacing = 1; }), "nodeSpacing", "1");
	names(complaint([](TemplateRecipe& r) { r.nodeSpacing = 5; }), "nodeSpacing", "5");
	names(complaint([](TemplateRecipe& r) { r.surfaceSpacing = 0.1; }), "surfaceSpacing",
	      "0.1");
	names(complaint([](TemplateRecipe& r) { r.surfaceSpacing = 7; }), "surfaceSpacing", "7");
	CHECK(complaint([](TemplateRecipe& r) { r.zeta = 0.5; }) ==
	      ""); // the ends of the ranges are inside
}

TEST_CASE("Grain template: recipes that differ anywhere are not taken for congruent", "[reference]")
{
	const TemplateRecipe base;
	auto differs = [&](auto change) {
		TemplateRecipe other;
		change(other);
		return (base < other) != (other < base);
	};
	CHECK(!differs([](TemplateRecipe&) {}));
	CHECK(differs([](TemplateRecipe& r) { r.zeta = 0.2; }));
	CHECK(differs([](TemplateRecipe& r) { r.order = 2; }));
	CHECK(differs([](TemplateRecipe& r) { r.nodeSpacing = 1.5; }));
	CHECK(differs([](TemplateRecipe& r) { r.surfaceSpacing = 2; }));
	CHECK(differs([](TemplateRecipe& r) { r.quadrature = QuadratureRule::lattice; }));
	CHECK(differs([](TemplateRecipe& r) { r.contact = ContactGeometry::points; }));
	CHECK(differs([](TemplateRecipe& r) { r.volumetric = VolumetricStrain::projected; }));
	CHECK(differs([](TemplateRecipe& r) { r.basis = Basis::triangles; }));
	CHECK(differs([](TemplateRecipe& r) { r.lumping = Lumping::rowSums; }));
	CHECK(differs([](TemplateRecipe& r) { r.form.form = Form::superdisk; }));
	for (int axis = 0; axis < 3; ++axis)
		CHECK(differs([&](TemplateRecipe& r) { r.form.aspect[axis] = 2; }));
	CHECK(differs([](TemplateRecipe& r) { r.form.exponent = 3; }));
}

TEST_CASE("Grain template: more points than fit into memory are refused", "[reference]")
{
	TemplateRecipe fine = recipe(0.002);
	CHECK_NOTHROW(fine.validate()); // a disk may be so fine
	CHECK_THROWS_AS(makeGrainTemplate<3>(fine), std::invalid_argument);
}

TEST_CASE("Grain template: what may be bent until it meets itself", "[reference]")
{
	auto mayMeetItself = [](Form form, double aspect) {
		TemplateRecipe r = recipe(0.4);
		r.form.form = form;
		r.form.aspect = { 1, aspect, 1 };
		return makeGrainTemplate<2>(r)->contactMesh.mayMeetItself;
	};
	CHECK(!mayMeetItself(Form::ball, 1));
	CHECK(!mayMeetItself(Form::block, 4));
	CHECK(mayMeetItself(Form::block, 6));
	CHECK(mayMeetItself(Form::superdisk, 6));
}
