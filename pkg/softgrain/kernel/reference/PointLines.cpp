#include "reference/PointLines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace softgrain {

namespace {

template <int dim> using Index = typename BackgroundGrid<dim>::Index;
template <int dim> using Stencil = std::array<SplineStencil, dim>;

/// Coordinates closer than this, in grid steps, are the same.
constexpr double sameCoordinate = 1e-9;

template <int dim> Stencil<dim> stencilAt(const BackgroundGrid<dim>& grid, const Vec<dim>& X)
{
	Stencil<dim> stencil;
	for (int a = 0; a < dim; ++a)
		stencil[a] = splineStencil(grid.order(), X[a] / grid.spacing()[a]);
	return stencil;
}

/// Points sorted by all coordinates but the last, then by that.
template <int dim>
std::vector<int> lineOrder(const BackgroundGrid<dim>& grid, const Quadrature<dim>& quadrature)
{
	using Key = std::array<double, dim>;
	std::vector<std::pair<Key, int>> keys;
	for (std::size_t p = 0; p < quadrature.point.size(); ++p) {
		Key key;
		for (int a = 0; a < dim; ++a)
			key[a] = std::round(quadrature.point[p][a] / grid.spacing()[a] /
					    sameCoordinate);
		keys.emplace_back(key, static_cast<int>(p));
	}
	std::sort(keys.begin(), keys.end());
	std::vector<int> order;
	for (const auto& [key, p] : keys)
		order.push_back(p);
	return order;
}

template <int dim>
bool onOneLine(const BackgroundGrid<dim>& grid, const Vec<dim>& X, const Vec<dim>& Y)
{
	return (X - Y).cwiseQuotient(grid.spacing())
		       .template head<dim - 1>()
		       .cwiseAbs()
		       .maxCoeff() < 2 * sameCoordinate;
}

template <int dim>
void layBox(const std::vector<Stencil<dim>>& stencils, int width, Index<dim>& low,
	    PointLines<dim>& lines)
{
	Index<dim> high;
	low.fill(std::numeric_limits<int>::max());
	high.fill(std::numeric_limits<int>::min());
	for (const Stencil<dim>& stencil : stencils)
		for (int a = 0; a < dim; ++a) {
			low[a] = std::min(low[a], stencil[a].first);
			high[a] = std::max(high[a], stencil[a].first + width);
		}
	lines.places = 1;
	for (int a = dim - 1; a >= 0; --a) {
		lines.size[a] = high[a] - low[a];
		lines.stride[a] = lines.places;
		lines.places *= lines.size[a];
	}
}

template <int dim>
int placeOf(const PointLines<dim>& lines, const Index<dim>& low, const Index<dim>& index)
{
	int place = 0;
	for (int a = 0; a < dim; ++a)
		place += (index[a] - low[a]) * lines.stride[a];
	return place;
}

template <int dim>
void numberNodes(const BackgroundGrid<dim>& grid, const Quadrature<dim>& quadrature,
		 const Index<dim>& low, PointLines<dim>& lines)
{
	std::set<Index<dim>> tied;
	for (const Vec<dim>& X : quadrature.point)
		for (const auto& [index, shape] : grid.shapesWithTied(X))
			if (!grid.number().count(index)) tied.insert(index);
	lines.nodePlace.resize(grid.number().size());
	for (const auto& [index, node] : grid.number())
		lines.nodePlace[node] = placeOf(lines, low, index);
	for (const Index<dim>& index : tied) {
		lines.tiePlace.push_back(placeOf(lines, low, index));
		for (const auto& [node, weight] : grid.extrapolation(index))
			lines.ties.append(node, weight);
		lines.ties.closeRow();
	}
}

/// The products across a line; see PointLines::across.
template <int dim>
void appendAcross(const Stencil<dim>& stencil, int width, const Vec<dim>& spacing,
		  std::vector<double>& across)
{
	for (int derivative = -1; derivative < dim - 1; ++derivative) {
		auto factor = [&](int axis, int i) {
			return axis == derivative ? stencil[axis].gradient[i] / spacing[axis]
						  : stencil[axis].value[i];
		};
		for (int i = 0; i < width; ++i)
			if constexpr (dim == 2)
				across.push_back(factor(0, i));
			else
				for (int j = 0; j < width; ++j)
					across.push_back(factor(0, i) * factor(1, j));
	}
}

/// The numbers of the points of each line.
template <int dim>
std::vector<std::vector<int>> pointsOfLines(const BackgroundGrid<dim>& grid,
					    const Quadrature<dim>& quadrature,
					    const std::vector<Stencil<dim>>& stencils)
{
	std::vector<std::vector<int>> lines;
	int last = -1; // point before, if there is one
	for (int p : lineOrder(grid, quadrature)) {
		// of two lines that rounding takes for one the rows may fall, too
		const int rows =
			last >= 0 ? stencils[p][dim - 1].first - stencils[last][dim - 1].first : -1;
		const bool goesOn = rows >= 0 && rows <= grid.order() &&
				    onOneLine(grid, quadrature.point[p], quadrature.point[last]) &&
				    lines.back().size() < PointLines<dim>::maxPoints;
		if (!goesOn) lines.emplace_back();
		lines.back().push_back(p);
		last = p;
	}
	return lines;
}

template <int dim>
void appendLine(const std::vector<int>& points, const std::vector<Stencil<dim>>& stencils,
		const BackgroundGrid<dim>& grid, const Quadrature<dim>& quadrature,
		const Index<dim>& low, PointLines<dim>& lines)
{
	const int width = grid.order() + 1, begin = static_cast<int>(lines.point.size());
	Index<dim> first;
	for (int a = 0; a < dim; ++a)
		first[a] = stencils[points[0]][a].first;
	const int place = placeOf(lines, low, first), line = static_cast<int>(lines.line.size());
	lines.line.push_back({ begin, begin, static_cast<int>(lines.run.size()), place });
	for (int p : points) {
		const SplineStencil& along = stencils[p][dim - 1];
		const typename PointLines<dim>::Point point { p, along.first - first[dim - 1],
							      quadrature.weight[p], along.t };
		lines.along.push_back({ along.value, along.gradient });
		for (double& slope : lines.along.back().slope)
			slope /= lines.spacing;
		int& end = lines.line.back().end;
		if (end == begin || point.row != lines.point.back().row)
			lines.run.push_back({ end, end, place + point.row, line });
		lines.point.push_back(point);
		lines.run.back().end = ++end;
	}
	appendAcross<dim>(stencils[points[0]], width, grid.spacing(), lines.across);
}

} // namespace

template <int dim>
PointLines<dim> makePointLines(const BackgroundGrid<dim>& grid, const Quadrature<dim>& quadrature)
{
	std::vector<Stencil<dim>> stencils;
	for (const Vec<dim>& X : quadrature.point)
		stencils.push_back(stencilAt(grid, X));
	PointLines<dim> lines;
	lines.spacing = grid.spacing()[dim - 1];
	Index<dim> low;
	layBox<dim>(stencils, grid.order() + 1, low, lines);
	numberNodes<dim>(grid, quadrature, low, lines);
	for (const auto& own : pointsOfLines<dim>(grid, quadrature, stencils))
		appendLine<dim>(own, stencils, grid, quadrature, low, lines);
	return lines;
}

template <int dim> PointLines<dim> makePointTable(int nodes, const Quadrature<dim>& quadrature)
{
	PointLines<dim> lines;
	lines.places = nodes;
	lines.nodePlace.resize(nodes);
	std::iota(lines.nodePlace.begin(), lines.nodePlace.end(), 0);
	const int points = static_cast<int>(quadrature.point.size());
	for (int begin = 0; begin < points; begin += PointLines<dim>::maxPoints)
		lines.line.push_back(
			{ begin, std::min(begin + PointLines<dim>::maxPoints, points), 0, 0 });
	for (int p = 0; p < points; ++p)
		lines.point.push_back({ p, 0, quadrature.weight[p], 0 });
	return lines;
}

template PointLines<2> makePointTable<2>(int, const Quadrature<2>&);
template PointLines<3> makePointTable<3>(int, const Quadrature<3>&);
template PointLines<2> makePointLines<2>(const BackgroundGrid<2>&, const Quadrature<2>&);
template PointLines<3> makePointLines<3>(const BackgroundGrid<3>&, const Quadrature<3>&);

} // namespace softgrain
