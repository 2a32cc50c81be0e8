#include "Helpers.hpp"
#include "contact/ContactBody.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Contact body: what is folded", "[contact]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.25));
	const auto round = contactBody<2>(*reference, 2, { 0.1, 0.2 }, Mat<2>::Identity());
	CHECK(!round.folded);
	const double edge = round.longestEdge;
	for (int s : { 0, 7, round.nodes() - 1 })
		for (double depth : { 0.05, 0.4, 3. }) { // in edges
			ContactBody<2> body = round, image;
			body.position[s] -= depth * edge * body.normal[s];
			body.updateGeometry();
			CHECK(body.folded == (depth > 0.1));
			image.becomeImage(body, { 1, 0 });
			CHECK(image.folded == body.folded);
		}
}

TEMPLATE_TEST_CASE_SIG("Contact body: normals, box and mobilities", "[contact]", ((int dim), dim),
		       2, 3)
{
	Random random(5);
	const auto reference = makeGrainTemplate<dim>(recipe(0.25));
	const Vec<dim> centre = random.vector<dim>();
	auto body = contactBody<dim>(*reference, 2, centre, random.rotation<dim>());
	for (int s = 0; s < body.nodes(); ++s) {
		CHECK(std::abs(body.normal[s].norm() - 1) < 1e-14);
		CHECK(body.normal[s].dot(body.position[s] - centre) > 1.98); // outwards
		CHECK(body.box.contains(body.position[s]));
	}
	CHECK(((body.box.high - body.box.low).array() <= 4 + 1e-12).all());
	CHECK(((body.box.high - body.box.low).array() > 3.8).all());
	const int s = random.index(body.nodes());
	for (int t = 0; t < body.nodes(); ++t)
		CHECK(std::abs(body.mobility(s, t) - body.mobility(t, s)) <
		      1e-15 * body.mobility(s, s));
}
