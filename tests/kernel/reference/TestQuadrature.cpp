#include "Helpers.hpp"
#include "reference/Outline.hpp"
#include "reference/Quadrature.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch_template_test_macros.hpp>
#include <numbers>
#include <set>

using namespace softgrain;

namespace {

template <int dim>
constexpr double exactVolume = dim == 2 ? std::numbers::pi : 4 * std::numbers::pi / 3;

template <int dim> Mat<dim> secondMoment(const Quadrature<dim>& q)
{
	Mat<dim> sum = Mat<dim>::Zero();
	for (std::size_t p = 0; p < q.point.size(); ++p)
		sum += q.weight[p] * q.point[p] * q.point[p].transpose();
	return sum;
}

template <int dim> std::array<int, dim> cellOf(const Vec<dim>& X, double spacing)
{
	std::array<int, dim> cell;
	for (int a = 0; a < dim; ++a)
		cell[a] = static_cast<int>(std::floor(X[a] / spacing));
	return cell;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Quadrature: moments of the ball", "[reference]", ((int dim), dim), 2, 3)
{
	for (QuadratureRule rule : { QuadratureRule::cutCell, QuadratureRule::lattice })
		for (double spacing : { 0.11, 0.2, 0.25, 0.37 }) {
			CAPTURE(spacing, rule == QuadratureRule::cutCell);
			const auto q = makeQuadrature<dim>(rule, spacing);
			double volume = 0;
			Vec<dim> first = Vec<dim>::Zero();
			for (std::size_t p = 0; p < q.point.size(); ++p) {
				volume += q.weight[p];
				first += q.weight[p] * q.point[p];
			}
			CHECK(std::abs(volume / exactVolume<dim> - 1) < 1e-13);
			CHECK(first.norm() < 1e-13);
		}
}

TEMPLATE_TEST_CASE_SIG("Quadrature: cut cells miss the second moment by that of a cell",
		       "[reference]", ((int dim), dim), 2, 3)
{
	// Exact: V/(dim + 2). A centroid rule loses the moment of each cell about its centroid,
	// dr^2/12 per unit of volume and less where cells are cut, hence second order and always
	// from below.
	const double exact = exactVolume<dim> / (dim + 2);
	for (double spacing : { 0.1, 0.11, 0.2, 0.25, 0.37 }) {
		if (dim == 3 && spacing < 0.11) continue;
		CAPTURE(spacing);
		const Mat<dim> moment =
			secondMoment(makeQuadrature<dim>(QuadratureRule::cutCell, spacing));
		const double cell = exactVolume<dim> * spacing * spacing / 12;
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				if (a == b) {
					CHECK(exact - moment(a, a) > 0.2 * cell);
					CHECK(exact - moment(a, a) < 1.03 * cell);
				} else
					CHECK(std::abs(moment(a, b)) < 1e-13);
	}
}

TEMPLATE_TEST_CASE_SIG("Quadrature: points inside, one a cell and one a part of a cell at the rim",
		       "[reference]", ((int dim), dim), 2, 3)
{
	for (double spacing : { 0.15, 0.2, 0.33 }) {
		CAPTURE(spacing);
		const auto q = makeQuadrature<dim>(QuadratureRule::cutCell, spacing);
		const double cell = std::pow(spacing, dim);
		std::set<std::array<int, dim>> cells;
		std::size_t whole = 0;
		for (std::size_t p = 0; p < q.point.size(); ++p) {
			CHECK(q.point[p].norm() <
			      1 + spacing / (dim == 2 ? 64 : 16)); // the resolution of the cuts
			CHECK(q.weight[p] > 0);
			// The sum is scaled to the exact volume; the scale tells how well the cuts
			// were resolved.
			const double most = dim == 2 ? 1 + 1e-5 : 1 + 1e-3;
			CHECK(q.weight[p] < most * cell);
			CHECK(cells.insert(cellOf<dim>(q.point[p], 0.5 * spacing)).second);
			Vec<dim> centre;
			for (int a = 0; a < dim; ++a)
				centre[a] = (std::floor(q.point[p][a] / spacing) + 0.5) * spacing;
			if (centre.norm() > 1 - 0.999 * spacing)
				CHECK(q.weight[p] < most * cell / (1 << dim));
			if (centre.norm() < 1 - 1.001 * spacing) ++whole;
		}
		const double uncut = *std::max_element(q.weight.begin(), q.weight.end());
		CHECK(std::abs(uncut / cell - 1) < (dim == 2 ? 1e-5 : 1e-3));
		CHECK(whole > 0);
		CHECK(whole < q.point.size());
	}
}

TEMPLATE_TEST_CASE_SIG("Quadrature: lattice points have uniform weights", "[reference]",
		       ((int dim), dim), 2, 3)
{
	const double spacing = 0.2;
	const auto q = makeQuadrature<dim>(QuadratureRule::lattice, spacing);
	std::size_t expected = 0;
	const int reach = 5, side = 2 * reach;
	for (int k = 0; k < std::pow(side, dim); ++k) {
		Vec<dim> X;
		for (int a = 0, rest = k; a < dim; ++a, rest /= side)
			X[a] = (rest % side - reach + 0.5) * spacing;
		expected += X.norm() < 1;
	}
	REQUIRE(q.point.size() == expected);
	for (std::size_t p = 0; p < q.point.size(); ++p) {
		CHECK(q.weight[p] == q.weight[0]);
		for (int a = 0; a < dim; ++a) {
			const double inCell =
				q.point[p][a] / spacing - std::floor(q.point[p][a] / spacing);
			CHECK(std::abs(inCell - 0.5) < 1e-12);
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Quadrature: boundary points, one a cell beside an empty one", "[reference]",
		       ((int dim), dim), 2, 3)
{
	const double spacing = 0.2;
	for (QuadratureRule rule : { QuadratureRule::cutCell, QuadratureRule::lattice }) {
		const auto q = makeQuadrature<dim>(rule, spacing);
		std::set<std::array<int, dim>> cells, open, found;
		for (const Vec<dim>& X : q.point)
			cells.insert(cellOf<dim>(X, spacing));
		for (const auto& cell : cells)
			for (int a = 0; a < dim; ++a)
				for (int step : { -1, 1 }) {
					auto beside = cell;
					beside[a] += step;
					if (!cells.count(beside)) open.insert(cell);
				}
		for (const Vec<dim>& X : boundaryPoints<dim>(rule, spacing))
			CHECK(found.insert(cellOf<dim>(X, spacing)).second);
		CHECK(found == open);
		CHECK(!open.empty());
		CHECK(open.size() < cells.size());
	}
}
