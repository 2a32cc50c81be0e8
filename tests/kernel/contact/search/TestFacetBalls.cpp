#include "Helpers.hpp"
#include "contact/search/FacetBalls.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <memory>
#include <numeric>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// A block four times as long as wide, and the template that its outline needs.
template <int dim> struct FineBlock {
	std::shared_ptr<const GrainTemplate<dim>> reference;
	ContactOutline<dim> outline;
};

template <int dim> FineBlock<dim> fineBlock(double zeta)
{
	TemplateRecipe fine = recipe(zeta);
	fine.form.form = Form::block;
	fine.form.aspect[0] = 4;
	const auto reference = makeGrainTemplate<dim>(fine);
	return { reference,
		 contactBody<dim>(*reference, 2, Vec<dim>::Zero(), Mat<dim>::Identity()) };
}

template <int dim> std::vector<int> allFacets(const ContactOutline<dim>& body)
{
	std::vector<int> facets(body.mesh->facet.size());
	std::iota(facets.begin(), facets.end(), 0);
	return facets;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Facet balls: the nearest place is that of all facets one by one",
		       "[contact]", ((int dim), dim), 2, 3)
{
	Random random(3);
	const auto block = fineBlock<dim>(dim == 2 ? 0.02 : 0.15);
	const ContactOutline<dim>& body = block.outline;
	const auto facets = allFacets(body);
	const FacetBalls<dim> balls(body, facets);
	REQUIRE(facets.size() > 500);
	for (int k = 0; k < 200; ++k) {
		Vec<dim> x = 3 * random.vector<dim>();
		if (k % 4 == 0) x = body.position[k % body.nodes()]; // as near to all about it
		PlaceOnOutline<dim> nearest;
		for (int f : facets) {
			const auto place = placeOnFacet<dim>(x, body, f);
			if (comesBefore(place, nearest)) nearest = place;
		}
		const auto found = nearestPlace(x, body, balls, anyFacet);
		CHECK(found.facet == nearest.facet);
		CHECK(found.squaredDistance == nearest.squaredDistance);
	}
}

TEST_CASE("Facet balls: few facets are looked at, however many there are", "[contact]")
{
	for (double zeta : { 0.1, 0.01, 0.002 }) {
		const auto block = fineBlock<2>(zeta);
		const ContactOutline<2>& body = block.outline;
		const FacetBalls<2> balls(body, allFacets(body));
		for (int s : { 0, body.nodes() / 3, body.nodes() / 2 }) {
			int looked = 0;
			balls.forNear(body.position[s], 2 * body.longestEdge,
				      [&](int) { ++looked; });
			CHECK(looked > 1);
			CHECK(looked < 10);
		}
	}
}

TEST_CASE("Facet balls: those far from a place are left out", "[contact]")
{
	const auto block = fineBlock<2>(0.02);
	const ContactOutline<2>& body = block.outline;
	FacetBalls<2> balls(body, allFacets(body));
	const Vec<2> corner = body.box.low;
	balls.leaveOutFarFrom(corner, 0.5);
	CHECK(balls.facets().size() > 20);
	CHECK(balls.facets().size() < 40);
	for (int f : balls.facets())
		CHECK(std::sqrt(placeOnFacet<2>(corner, body, f).squaredDistance) <= 0.5);
	balls.leaveOutFarFrom({ 99, 99 }, 1);
	CHECK(balls.empty());
	CHECK(nearestPlace(corner, body, balls, anyFacet).facet == -1);
}
