#include "Helpers.hpp"
#include "reference/GrainTemplate.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <vector>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// How far the table of a point is from what its place along the line gives.
template <int dim, int order> double disagreement(const PointLines<dim>& lines, int i)
{
	SplineFactors value, slope;
	splineFactors<order>(lines.point[i].t, value, slope);
	double largest = 0;
	for (int j = 0; j < rowWidth; ++j) {
		largest = std::max(largest, std::abs(value[j] - lines.along[i].value[j]));
		largest = std::max(largest,
				   std::abs(slope[j] - lines.spacing * lines.along[i].slope[j]));
	}
	return largest;
}

/// G_I(Xp) of all nodes with unknowns from the lines: products of B-splines over the box, ties
/// resolved.
template <int dim>
std::vector<Vec<dim>> gradients(const PointLines<dim>& lines, int order, int line, int i)
{
	const int width = order + 1, nodes = dim == 2 ? width : width * width;
	const double* across = &lines.across[static_cast<std::size_t>(line) * dim * nodes];
	const auto& along = lines.along[i];
	std::vector<Vec<dim>> box(lines.places, Vec<dim>::Zero());
	for (int k = 0; k < nodes; ++k)
		for (int j = 0; j < width; ++j) {
			const int step = dim == 2 ? k * lines.stride[0]
						  : k / width * lines.stride[0] +
							    k % width * lines.stride[1];
			Vec<dim>& G = box[lines.line[line].place + step + lines.point[i].row + j];
			for (int b = 0; b < dim - 1; ++b)
				G[b] = across[(b + 1) * nodes + k] * along.value[j];
			G[dim - 1] = across[k] * along.slope[j];
		}
	std::vector<Vec<dim>> own;
	for (int place : lines.nodePlace)
		own.push_back(box[place]);
	for (int t = 0; t < lines.ties.rows(); ++t)
		for (int k = lines.ties.begin(t); k < lines.ties.end(t); ++k)
			own[lines.ties.column[k]] += lines.ties.value[k] * box[lines.tiePlace[t]];
	return own;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Point lines: the shape functions of every point", "[reference]",
		       ((int dim, int order), dim, order), (2, 1), (2, 2), (2, 3), (3, 1), (3, 2),
		       (3, 3))
{
	for (double spacing : { 1.25, 2. }) {
		TemplateRecipe own = recipe(dim == 2 ? 0.11 : 0.3);
		own.order = order;
		own.nodeSpacing = spacing;
		const auto grain = makeGrainTemplate<dim>(own);
		const PointLines<dim>& lines = grain->pointLines;
		std::vector<int> met(grain->points(), 0);
		double worst = 0;
		for (int n = 0; n < static_cast<int>(lines.line.size()); ++n)
			for (int i = lines.line[n].begin; i < lines.line[n].end; ++i) {
				const int p = lines.point[i].number;
				++met[p];
				CHECK(lines.point[i].volume == grain->pointVolume[p]);
				CHECK(disagreement<dim, order>(lines, i) < 1e-15);
				auto G = gradients<dim>(lines, order, n, i);
				const auto& shapes = grain->pointShapes;
				for (int k = shapes.begin(p); k < shapes.end(p); ++k)
					G[shapes.column[k]] -= shapes.value[k].G;
				for (const Vec<dim>& rest : G)
					worst = std::max(worst, rest.norm());
			}
		CHECK(worst < 1e-11 / own.zeta);
		CHECK(met == std::vector<int>(grain->points(), 1));
	}
}

TEMPLATE_TEST_CASE_SIG("Point lines: bounded, without gaps, in runs", "[reference]",
		       ((int dim), dim), 2, 3)
{
	TemplateRecipe fine = recipe(dim == 2 ? 0.03 : 0.15);
	const auto grain = makeGrainTemplate<dim>(fine);
	const PointLines<dim>& lines = grain->pointLines;
	int run = 0;
	std::size_t longest = 0;
	for (const auto& line : lines.line) {
		const int points = line.end - line.begin;
		longest = std::max<std::size_t>(longest, points);
		CHECK(points <= PointLines<dim>::maxPoints);
		CHECK(line.firstRun == run);
		int covered = 0; // rows met so far
		for (int i = line.begin; i < line.end; i = lines.run[run++].end) {
			CHECK(lines.run[run].begin == i);
			CHECK(lines.point[i].row <= covered);
			covered = lines.point[i].row + fine.order + 1;
		}
	}
	CHECK(run == static_cast<int>(lines.run.size()));
	CHECK(longest > 4);
}
