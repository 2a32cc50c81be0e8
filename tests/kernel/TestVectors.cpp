// Boxes, distances and directions of many vectors at a time: with the bits of one by one.
#include "Helpers.hpp"
#include "Vectors.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

#include <cmath>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> std::vector<Vec<dim>> someVectors(int count)
{
	Random random(static_cast<unsigned>(count));
	std::vector<Vec<dim>> vectors;
	for (int k = 0; k < count; ++k)
		vectors.push_back(random.vector<dim>() + 0.5 * Vec<dim>::Ones());
	return vectors;
}

/// Their number is no multiple of what is computed at a time, or less than that.
constexpr int mostVectors = 13;

} // namespace

TEMPLATE_TEST_CASE_SIG("Vectors: the box of vectors and the farthest of them", "[vectors]",
		       ((int dim), dim), 2, 3)
{
	for (int count = 1; count <= mostVectors; ++count) {
		const auto vectors = someVectors<dim>(count);
		const Vec<dim> centre = vectors[count / 2] - Vec<dim>::Unit(0);
		Vec<dim> low = vectors[0], high = vectors[0];
		double farthest = 0;
		for (const Vec<dim>& v : vectors) {
			low = low.cwiseMin(v);
			high = high.cwiseMax(v);
			farthest = std::max(farthest, (v - centre).norm());
		}
		CAPTURE(count);
		const Box<dim> box = boxOf(vectors);
		CHECK(box.low == low);
		CHECK(box.high == high);
		CHECK(farthestFrom<dim>(centre, vectors) == farthest);
		const VectorRange<dim> range = rangeOf(vectors);
		CHECK(range.middle == Vec<dim>(0.5 * (low + high)));
		CHECK(range.spread == farthestFrom<dim>(range.middle, vectors));
	}
}

TEMPLATE_TEST_CASE_SIG("Vectors: the range of the ways from some to others", "[vectors]",
		       ((int dim), dim), 2, 3)
{
	for (int count = 1; count <= mostVectors; ++count) {
		const auto to = someVectors<dim>(count);
		auto from = someVectors<dim>(2 * count);
		from.resize(count);
		std::vector<Vec<dim>> way;
		for (int k = 0; k < count; ++k)
			way.push_back(to[k] - from[k]);
		CAPTURE(count);
		const VectorRange<dim> expected = rangeOf(way), found = rangeOfWays<dim>(from, to);
		CHECK(found.middle == expected.middle);
		CHECK(found.spread == expected.spread);
	}
}

TEMPLATE_TEST_CASE_SIG("Vectors: unit vectors, and zero, which stays", "[vectors]",
		       ((int dim), dim), 2, 3)
{
	for (int count = 1; count <= mostVectors; ++count)
		for (int zero = 0; zero < count; ++zero) {
			auto vectors = someVectors<dim>(count);
			vectors[zero].setZero();
			auto expected = vectors;
			for (Vec<dim>& v : expected)
				v.normalize();
			normalizeAll(vectors);
			CAPTURE(count, zero);
			CHECK(vectors == expected);
		}
}

TEST_CASE("Vectors: which ones a box holds, its faces included", "[vectors]")
{
	const Box<2> box { { -1, 0 }, { 1, 2 } };
	const std::vector<Vec<2>> vectors { { -1, 0 },    { 1, 2 },      { 0, 1 },   { -1.001, 1 },
					    { 1.001, 1 }, { 0, -0.001 }, { 0, 2.1 }, { 0.5, 2 } };
	const auto inside = [&](int k) { return box.contains(vectors[k]); };
	CHECK(numbersThat(8, inside) == std::vector<int> { 0, 1, 2, 7 });
	CHECK(numbersThat(0, inside).empty());
	CHECK(numbersThat(3, [](int) { return false; }).empty());
}
