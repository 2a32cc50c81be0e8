#include "Helpers.hpp"

#include <catch2/catch_test_macros.hpp>
#include <string>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Background grid: uniform points are as many as nodes", "[reference]")
{
	auto complaint = [](double zeta, int order, double nodeSpacing) {
		TemplateRecipe r = recipe(zeta);
		r.order = order;
		r.nodeSpacing = nodeSpacing;
		r.quadrature = QuadratureRule::lattice;
		return complaintOf([&] { makeGrainTemplate<2>(r); });
	};
	for (double zeta : { 0.2, 0.25, 0.3, 0.5 })
		CHECK(complaint(zeta, 3, 1.25).find("which could move without strain") !=
		      std::string::npos);
	CHECK(complaint(0.2, 3, 2).empty());
	CHECK(complaint(0.1, 3, 1.25).empty());
	CHECK(complaint(0.25, 1, 1.25).empty());
}

TEST_CASE("Background grid: nodes of thin arms are carried", "[reference]")
{
	for (double width : { 0.05, 0.1, 0.2 })
		for (int order : { 1, 2, 3 })
			for (double nodeSpacing : { 1.25, 2., 3. }) {
				Ring ring;
				ring.vertex = { { 0, 0 },           { 2, 0 },
						{ 2, 0.9 },         { 6, 0.9 },
						{ 6, 0.9 + width }, { 2, 0.9 + width },
						{ 2, 2 },           { 0, 2 } };
				ring.corner = { 0, 1, 2, 3, 4, 5, 6, 7 };
				TemplateRecipe r = polygonRecipe(0.3, ring, order, nodeSpacing);
				r.volumetric = VolumetricStrain::projected;
				CAPTURE(width, order, nodeSpacing);
				const auto t = makeGrainTemplate<2>(r);
				for (int p = 0; p < t->points(); ++p) {
					Vec<2> X = Vec<2>::Zero();
					Mat<2> F = Mat<2>::Zero();
					for (int k = t->pointShapes.begin(p);
					     k < t->pointShapes.end(p); ++k) {
						const Vec<2>& at =
							t->nodePosition[t->pointShapes.column[k]];
						X += t->pointShapes.value[k].N * at;
						F += at * t->pointShapes.value[k].G.transpose();
					}
					CHECK((X - t->pointPosition[p]).norm() < 1e-9);
					CHECK((F - Mat<2>::Identity()).norm() < 1e-8);
				}
			}
}
