#include "Helpers.hpp"
#include "contact/NearbyFacets.hpp"

#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>
#include <map>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Nearby facets: the nearest in their order, and how far all others were", "[contact]")
{
	Random random { 11 };
	for (int trial = 0; trial < 200; ++trial) {
		const double within = 0.7;
		NearbyFacets<3> nearby;
		nearby.clear(within);
		std::map<double, int> all;
		for (int facet = 0; facet < trial % 30; ++facet) {
			const double distance = 0.5 + 0.5 * random.vector<3>(1)[0];
			nearby.note(facet, distance);
			all[distance] = facet;
		}
		int k = 0;
		double others = within;
		for (const auto& [distance, facet] : all) {
			if (k == nearby.count()) {
				others = std::min(within, distance);
				break;
			}
			CHECK(nearby.facet(k) == facet);
			CHECK(nearby.distance(k) <= distance);
			CHECK(nearby.distance(k) == Catch::Approx(distance).epsilon(1e-5));
			CHECK(distance < within);
			++k;
		}
		CHECK(nearby.count() <= 8);
		CHECK(nearby.distanceOfOthers() <= others);
		CHECK(nearby.distanceOfOthers() == Catch::Approx(others).epsilon(1e-5));
	}
}

TEST_CASE("Nearby facets: nothing is known before any are noted", "[contact]")
{
	const NearbyFacets<2> nearby {};
	CHECK(nearby.count() == 0);
	CHECK(nearby.distanceOfOthers() == 0);
}
