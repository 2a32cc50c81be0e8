#include "reference/Quadrature.hpp"
#include "reference/Outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace softgrain {

namespace {

template <int dim> using Cell = std::array<int, dim>;

/// Cells with a centre less than this inside the outline (in cell sides) are divided at the rim.
constexpr double rimDepth = 1;

/// Cuts are resolved down to 1/2^depth of a cell; there the outline is taken as straight.
/// Chosen so that the area of a disk is met within 1e-5 before the weights are scaled.
template <int dim> constexpr int cutDepth = dim == 2 ? 6 : 4;

/// Parts of a cell below this share of it hold no point.
constexpr double negligibleShare = 1e-9;

/// Points with less than this share of a cell are slivers. (One in the tip of a corner carries
/// nothing, but where the corner is pressed it shortens the time step a thousandfold, and is
/// inverted.)
constexpr double sliverShare = 1e-4;

/// From the centre of a cell to that of one of its 2^dim parts.
template <int dim> Vec<dim> cornerOffset(int corner, const Vec<dim>& sides)
{
	Vec<dim> offset;
	for (int a = 0; a < dim; ++a)
		offset[a] = (corner >> a & 1) ? 0.25 * sides[a] : -0.25 * sides[a];
	return offset;
}

/// Volume and first moment of the part of a cell (centre, sides) inside the outline.
template <int dim>
Moments<dim> momentsInside(const Outline<dim>& outline, const Vec<dim>& centre,
			   const Vec<dim>& sides, int depth)
{
	if (const auto exact = outline.cut(centre, sides)) return *exact;
	const double distance = outline.signedDistance(centre);
	const double halfDiagonal = 0.5 * sides.norm();
	Moments<dim> m;
	if (distance >= halfDiagonal) return m;
	const double volume = sides.prod();
	if (distance <= -halfDiagonal || depth == 0) {
		m.volume = volume * std::clamp(0.5 - distance / sides[0], 0., 1.);
		m.first = m.volume * centre;
		return m;
	}
	for (int corner = 0; corner < (1 << dim); ++corner) {
		const Moments<dim> part = momentsInside<dim>(
			outline, centre + cornerOffset<dim>(corner, sides), 0.5 * sides, depth - 1);
		m.volume += part.volume;
		m.first += part.first;
	}
	return m;
}

template <int dim> Vec<dim> cellCentre(const Cell<dim>& cell, const Vec<dim>& sides)
{
	Vec<dim> X;
	for (int a = 0; a < dim; ++a)
		X[a] = (cell[a] + 0.5) * sides[a];
	return X;
}

/// Cells inside the outline in lexicographic order, with what each of them holds.
template <int dim>
std::map<Cell<dim>, Moments<dim>> occupiedCells(QuadratureRule rule, const Vec<dim>& sides,
						const Outline<dim>& outline)
{
	Cell<dim> reach, cell;
	for (int a = 0; a < dim; ++a) {
		reach[a] = static_cast<int>(std::ceil(outline.halfSides()[a] / sides[a]));
		cell[a] = -reach[a];
	}
	const double negligible = negligibleShare * sides.prod();
	std::map<Cell<dim>, Moments<dim>> cells;
	for (;;) {
		const Vec<dim> centre = cellCentre<dim>(cell, sides);
		Moments<dim> m;
		if (rule == QuadratureRule::cutCell)
			m = momentsInside<dim>(outline, centre, sides, cutDepth<dim>);
		else if (outline.signedDistance(centre) < 0)
			m = { 1, centre };
		if (m.volume > negligible) cells.emplace(cell, m);
		int a = dim - 1;
		while (a >= 0 && ++cell[a] == reach[a]) {
			cell[a] = -reach[a];
			--a;
		}
		if (a < 0) return cells;
	}
}

template <int dim>
bool hasEmptyNeighbour(const std::map<Cell<dim>, Moments<dim>>& cells, const Cell<dim>& cell)
{
	for (int a = 0; a < dim; ++a)
		for (int step : { -1, 1 }) {
			Cell<dim> neighbour = cell;
			neighbour[a] += step;
			if (!cells.count(neighbour)) return true;
		}
	return false;
}

template <int dim> void addPoint(const Moments<dim>& m, Quadrature<dim>& q)
{
	q.point.push_back(m.first / m.volume);
	q.weight.push_back(m.volume);
}

template <int dim> void scaleToExactVolume(double volume, Quadrature<dim>& q)
{
	double sum = 0;
	for (double w : q.weight)
		sum += w;
	for (double& w : q.weight)
		w *= volume / sum;
}

/// Points in the 2^dim parts of a cell at the rim.
template <int dim>
void addRefined(const Outline<dim>& outline, const Vec<dim>& centre, const Vec<dim>& sides,
		Quadrature<dim>& q)
{
	for (int corner = 0; corner < (1 << dim); ++corner) {
		const Moments<dim> part =
			momentsInside<dim>(outline, centre + cornerOffset<dim>(corner, sides),
					   0.5 * sides, cutDepth<dim> - 1);
		if (part.volume > negligibleShare * sides.prod()) addPoint(part, q);
	}
}

/// The nearest of the points that are no slivers; -1 if there is none.
template <int dim> int nearestWhole(const Quadrature<dim>& q, const Vec<dim>& X, double sliver)
{
	auto distance = [&](int p) { return (q.point[p] - X).squaredNorm(); };
	int nearest = -1;
	for (int p = 0; p < static_cast<int>(q.point.size()); ++p)
		if (q.weight[p] >= sliver && (nearest < 0 || distance(p) < distance(nearest)))
			nearest = p;
	return nearest;
}

/// Adds points of less weight than `sliver` to their neighbours, volume and first moment.
template <int dim> void mergeSlivers(double sliver, Quadrature<dim>& q)
{
	const Quadrature<dim> all = std::exchange(q, {});
	std::map<int, Moments<dim>> merged; // by point
	for (std::size_t p = 0; p < all.point.size(); ++p) {
		const int to =
			all.weight[p] < sliver ? nearestWhole(all, all.point[p], sliver) : -1;
		if (to < 0) continue;
		Moments<dim>& m = merged[to];
		m.volume += all.weight[p];
		m.first += all.weight[p] * all.point[p];
	}
	for (std::size_t p = 0; p < all.point.size(); ++p) {
		const auto more = merged.find(static_cast<int>(p));
		if (more != merged.end()) {
			more->second.volume += all.weight[p];
			more->second.first += all.weight[p] * all.point[p];
			addPoint(more->second, q);
		} else if (merged.empty() || all.weight[p] >= sliver) {
			q.point.push_back(all.point[p]);
			q.weight.push_back(all.weight[p]);
		}
	}
}

} // namespace

template <int dim>
Quadrature<dim> makeQuadrature(QuadratureRule rule, double spacing, const Outline<dim>& outline)
{
	const Vec<dim> sides = outline.cellSides(spacing);
	Quadrature<dim> q;
	for (const auto& [cell, m] : occupiedCells<dim>(rule, sides, outline)) {
		const Vec<dim> centre = cellCentre<dim>(cell, sides);
		const bool atRim = outline.signedDistance(centre) > -rimDepth * sides.maxCoeff();
		if (rule == QuadratureRule::cutCell && atRim)
			addRefined(outline, centre, sides, q);
		else
			addPoint(m, q);
	}
	if (dim == 2 && rule == QuadratureRule::cutCell) // in 3D no corner cuts cells
		mergeSlivers<dim>(sliverShare * sides.prod(), q);
	scaleToExactVolume(outline.volume(), q);
	return q;
}

template <int dim>
std::vector<Vec<dim>> boundaryPoints(QuadratureRule rule, double spacing,
				     const Outline<dim>& outline)
{
	const auto cells = occupiedCells<dim>(rule, outline.cellSides(spacing), outline);
	std::vector<Vec<dim>> points;
	for (const auto& [cell, m] : cells)
		if (hasEmptyNeighbour<dim>(cells, cell)) points.push_back(m.first / m.volume);
	return points;
}

template std::vector<Vec<2>> boundaryPoints<2>(QuadratureRule, double, const Outline<2>&);
template std::vector<Vec<3>> boundaryPoints<3>(QuadratureRule, double, const Outline<3>&);
template Quadrature<2> makeQuadrature<2>(QuadratureRule, double, const Outline<2>&);
template Quadrature<3> makeQuadrature<3>(QuadratureRule, double, const Outline<3>&);

} // namespace softgrain
