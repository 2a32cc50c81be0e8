#include "Helpers.hpp"
#include "contact/ContactOutline.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Contact outline: what is folded", "[contact]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.25));
	const auto round = contactBody<2>(*reference, 2, { 0.1, 0.2 }, Mat<2>::Identity());
	CHECK(!round.folded);
	const double edge = round.longestEdge;
	for (int s : { 0, 7, round.nodes() - 1 })
		for (double depth : { 0.05, 0.4, 3. }) { // in edges
			ContactOutline<2> body = round, image;
			body.position[s] -= depth * edge * body.normal[s];
			body.updateGeometry();
			CHECK(body.folded == (depth > 0.1));
			image.becomeImage(body, { 1, 0 });
			CHECK(image.folded == body.folded);
		}
}

TEMPLATE_TEST_CASE_SIG("Contact outline: normals and box", "[contact]", ((int dim), dim), 2, 3)
{
	Random random(5);
	const auto reference = makeGrainTemplate<dim>(recipe(0.25));
	const Vec<dim> centre = random.vector<dim>();
	const auto body = contactBody<dim>(*reference, 2, centre, random.rotation<dim>());
	for (int s = 0; s < body.nodes(); ++s) {
		CHECK(std::abs(body.normal[s].norm() - 1) < 1e-14);
		CHECK(body.normal[s].dot(body.position[s] - centre) > 1.98); // outwards
		CHECK(body.box.contains(body.position[s]));
	}
	CHECK(((body.box.high - body.box.low).array() <= 4 + 1e-12).all());
	CHECK(((body.box.high - body.box.low).array() > 3.8).all());
}

TEMPLATE_TEST_CASE_SIG("Contact outline: an image is displaced as a whole", "[contact]",
		       ((int dim), dim), 2, 3)
{
	Random random(6);
	const auto reference = makeGrainTemplate<dim>(recipe(0.25));
	const auto body =
		contactBody<dim>(*reference, 2, random.vector<dim>(), random.rotation<dim>());
	const Vec<dim> shift = random.vector<dim>();
	ContactOutline<dim> image, again = body;
	image.becomeImage(body, shift);
	CHECK(image.position[3] == body.position[3] + shift);
	CHECK(image.box.low == body.box.low + shift);
	CHECK(image.carried == body.carried + shift);
	CHECK(image.normal == body.normal);
	for (Vec<dim>& x : again.position)
		x += shift;
	again.updateGeometry();
	CHECK((image.box.high - again.box.high).norm() < 1e-14);
}
