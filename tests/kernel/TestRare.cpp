// Optional values that lie elsewhere.
#include "Rare.hpp"

#include <catch2/catch_test_macros.hpp>

using namespace softgrain;

TEST_CASE("A rare value is copied with who has it", "[rare]")
{
	Rare<int> one;
	CHECK_FALSE(one);
	CHECK(one.emplace() == 0);
	*one = 3;
	Rare<int> other = one;
	*one = 4;
	CHECK(*other == 3);
	other = one;
	CHECK(*other == 4);
	CHECK(one.emplace() == 0);
	one.reset();
	CHECK_FALSE(one.has_value());
	other = one;
	CHECK_FALSE(other);
}
