// Sums over the nodes and the points of lines (reference/PointLines.hpp), with the same of
// laneWidth congruent grains side by side.
//
// A point meets order + 1 rows of nodes. Where registers hold the sums over as many rows for all
// lanes (AVX-512), these stay there from point to point as a window. With AVX2 they do not, and are
// kept in a table of all rows of the line (doc/decisions/0013-bulk-pass.md compares).
#pragma once

#include "grain/BlockField.hpp"
#include "grain/Strip.hpp"

namespace softgrain::detail {

/// Parts that are worked on at once: what is computed for every one of them alike is computed once,
/// and the sums of one row stay in registers.
template <class Part, int dim> constexpr int partsAtOnce = dim == 2 ? laneWidth / Part::width : 1;

/// Sums over the nodes across a line in one row: component `a` with the products `q` of
/// PointLines::across, of all parts at once.
template <int dim, class Part> struct RowSums {
	static constexpr int parts = partsAtOnce<Part, dim>;
	typename Part::Numbers at[dim][dim][parts];
};

template <int dim, int order, class Part>
void sumRow(const LinesInLoop<dim, order>& in, const double* across, const double* x,
	    RowSums<dim, Part>& sums)
{
	constexpr int nodes = nodesAcross<dim, order>, parts = sums.parts;
	typename Part::Numbers sum[dim][dim][parts] = {};
	for (int k = 0; k < nodes; ++k)
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				for (int h = 0; h < parts; ++h)
					sum[q][a][h] += across[q * nodes + k] *
							lanesAt<Part, dim>(x, in.step[k], a, h);
	for (int q = 0; q < dim; ++q)
		for (int a = 0; a < dim; ++a)
			for (int h = 0; h < parts; ++h)
				sums.at[q][a][h] = sum[q][a][h];
}

/// The transpose of `sumRow`, subtracted.
template <int dim, int order, class Part>
void spreadRow(const LinesInLoop<dim, order>& in, const double* across,
	       const RowSums<dim, Part>& sums, double* force)
{
	constexpr int nodes = nodesAcross<dim, order>;
	for (int k = 0; k < nodes; ++k) {
		double factor[dim]; // read before the stores, which might change it
		for (int q = 0; q < dim; ++q)
			factor[q] = across[q * nodes + k];
		for (int a = 0; a < dim; ++a)
			for (int h = 0; h < sums.parts; ++h) {
				auto& node = lanesAt<Part, dim>(force, in.step[k], a, h);
				typename Part::Numbers sum = node;
				for (int q = 0; q < dim; ++q)
					sum -= factor[q] * sums.at[q][a][h];
				node = sum;
			}
	}
}

/// F of a point from the rows that it meets.
template <int dim, int order, class Part>
void gatherPoint(const typename PointLines<dim>::Factors& along, const RowSums<dim, Part>* row,
		 double* tensor)
{
	constexpr int parts = RowSums<dim, Part>::parts;
	typename Part::Numbers F[dim][dim][parts] = {};
	for (int j = 0; j <= order; ++j)
		for (int a = 0; a < dim; ++a)
			for (int h = 0; h < parts; ++h) {
				for (int q = 1; q < dim; ++q)
					F[a][q - 1][h] += along.value[j] * row[j].at[q][a][h];
				F[a][dim - 1][h] += along.slope[j] * row[j].at[0][a][h];
			}
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			for (int h = 0; h < parts; ++h)
				lanesAt<Part, dim>(tensor, a, b, h) = F[a][b][h];
}

/// Adds the stresses of a point to one of the rows that it meets.
template <int dim, class Part>
void scatterPoint(double value, double slope, const double* tensor, RowSums<dim, Part>& row)
{
	for (int a = 0; a < dim; ++a)
		for (int h = 0; h < row.parts; ++h) {
			for (int q = 1; q < dim; ++q)
				row.at[q][a][h] += value * lanesAt<Part, dim>(tensor, a, q - 1, h);
			row.at[0][a][h] += slope * lanesAt<Part, dim>(tensor, a, dim - 1, h);
		}
}

/// First number of the first row of a line.
template <int dim, class Number, class Line> Number* firstRow(Number* field, const Line& line)
{
	return field + static_cast<std::ptrdiff_t>(line.place) * dim * laneWidth;
}
template <int dim> constexpr int tensorStep = dim * dim * laneWidth; ///< from point to point

/// The rows of a line that one point meets, all lanes of them.
template <int dim, int order> struct Window {
	RowSums<dim, WholeLanes> row[order + 1];

	void shift()
	{
		for (int j = 0; j < order; ++j)
			for (int q = 0; q < dim; ++q)
				for (int a = 0; a < dim; ++a)
					row[j].at[q][a][0] = row[j + 1].at[q][a][0];
	}
};

/// F at the points of a line; returns what follows its last tensor.
template <int dim, int order>
double* gatherLine(WholeLanes, const LinesInLoop<dim, order>& in, int n, const double* x,
		   double* tensor)
{
	constexpr int width = order + 1;
	const auto line = in.line[n];
	const double* across = in.acrossLine(n);
	const double* first = firstRow<dim>(x, line);
	Window<dim, order> window;
#pragma GCC unroll 4
	for (int j = 0; j < width; ++j)
		sumRow(in, across, first + j * dim * laneWidth, window.row[j]);
	int next = width; // row after the window
	for (int i = line.begin; i < line.end; ++i, tensor += tensorStep<dim>) {
		for (; next < in.point[i].row + width; ++next) {
			window.shift();
			sumRow(in, across, first + next * dim * laneWidth, window.row[order]);
		}
		gatherPoint<dim, order>(in.along[i], window.row, tensor);
	}
	return tensor;
}
template <int dim, int order>
double* gatherLine(HalfLanes, const LinesInLoop<dim, order>& in, int n, const double* x,
		   double* tensor)
{
	const auto line = in.line[n];
	const double* across = in.acrossLine(n);
	const double* first = firstRow<dim>(x, line);
	RowSums<dim, HalfLanes> row[PointLines<dim>::maxPoints * order + 1];
	const int rows = in.point[line.end - 1].row + order + 1;
	for (int r = 0; r < rows; ++r)
		sumRow(in, across, first + r * dim * laneWidth, row[r]);
	for (int i = line.begin; i < line.end; ++i, tensor += tensorStep<dim>)
		gatherPoint<dim, order>(in.along[i], row + in.point[i].row, tensor);
	return tensor;
}

/// Forces of the stresses at the points of a line.
template <int dim, int order>
void scatterLine(WholeLanes, const LinesInLoop<dim, order>& in, int n, const double* tensor,
		 double* force)
{
	constexpr int width = order + 1;
	const auto line = in.line[n];
	const double* across = in.acrossLine(n);
	double* first = firstRow<dim>(force, line);
	Window<dim, order> window = {};
	int row = 0; // first of the window
	for (int i = line.begin; i < line.end; ++i, tensor += tensorStep<dim>) {
		const auto& along = in.along[i];
		for (; row < in.point[i].row; ++row) {
			spreadRow(in, across, window.row[0], first + row * dim * laneWidth);
			window.shift();
			window.row[order] = {};
		}
		for (int j = 0; j < width; ++j)
			scatterPoint(along.value[j], along.slope[j], tensor, window.row[j]);
	}
#pragma GCC unroll 4
	for (int j = 0; j < width; ++j)
		spreadRow(in, across, window.row[j], first + (row + j) * dim * laneWidth);
}
template <int dim, int order>
void scatterLine(HalfLanes, const LinesInLoop<dim, order>& in, int n, const double* tensor,
		 double* force)
{
	const auto line = in.line[n];
	const double* across = in.acrossLine(n);
	double* first = firstRow<dim>(force, line);
	const int rows = in.point[line.end - 1].row + order + 1;
	int begin = line.begin, end = line.begin; // of the points that meet the row
	for (int r = 0; r < rows; ++r) {
		while (end < line.end && in.point[end].row <= r)
			++end;
		while (in.point[begin].row + order < r)
			++begin;
		RowSums<dim, HalfLanes> sums = {};
		for (int i = begin; i < end; ++i) {
			const int j = r - in.point[i].row;
			scatterPoint(in.along[i].value[j], in.along[i].slope[j],
				     tensor + (i - line.begin) * tensorStep<dim>, sums);
		}
		spreadRow(in, across, sums, first + r * dim * laneWidth);
	}
}

/// F at the points of a strip. The fields begin with the first lane that is worked on.
template <int dim, int order, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherGrains(const PointLines<dim>& lines, LineRange range,
						     const double* x, double* tensor)
{
	const LinesInLoop<dim, order> in(lines);
	for (int n = range.begin; n < range.end; ++n)
		tensor = gatherLine(Part {}, in, n, x, tensor);
}

/// Forces of the stresses of a strip.
template <int dim, int order, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterGrains(const PointLines<dim>& lines, LineRange range,
						      const double* tensor, double* force)
{
	const LinesInLoop<dim, order> in(lines);
	for (int n = range.begin; n < range.end; ++n) {
		scatterLine(Part {}, in, n, tensor, force);
		tensor += (in.line[n].end - in.line[n].begin) * tensorStep<dim>;
	}
}

} // namespace softgrain::detail
