#include "Helpers.hpp"
#include "contact/ContactBody.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

TEMPLATE_TEST_CASE_SIG("Contact body: nodes feel each other alike", "[contact]", ((int dim), dim),
		       2, 3)
{
	Random random(5);
	const auto reference = makeGrainTemplate<dim>(recipe(0.25));
	const auto body = contactBody<dim>(*reference, 2, random.vector<dim>());
	const int s = random.index(body.nodes());
	for (int t = 0; t < body.nodes(); ++t)
		CHECK(std::abs(body.mobility(s, t) - body.mobility(t, s)) <
		      1e-15 * body.mobility(s, s));
}
