#include "reference/Quadrature.hpp"
#include "reference/Outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace softgrain {

namespace {

template <int dim> using Cell = std::array<int, dim>;

template <int dim> struct Moments {
	double volume = 0;
	Vec<dim> first = Vec<dim>::Zero();
};

/// Cuts are resolved down to 1/2^depth of a cell; there the outline is taken as straight.
/// Chosen so that the area of a disk is met within 1e-5 before the weights are scaled.
template <int dim> constexpr int cutDepth = dim == 2 ? 6 : 4;

/// Parts of a cell below this share of it hold no point.
constexpr double negligibleShare = 1e-9;

/// From the centre of a cell to that of one of its 2^dim parts.
template <int dim> Vec<dim> cornerOffset(int corner, double side)
{
	Vec<dim> offset;
	for (int a = 0; a < dim; ++a)
		offset[a] = (corner >> a & 1) ? 0.25 * side : -0.25 * side;
	return offset;
}

/// Volume and first moment of the part of a cube (centre, side) inside the outline.
template <int dim> Moments<dim> momentsInside(const Vec<dim>& centre, double side, int depth)
{
	const double distance = UnitBall<dim>::signedDistance(centre);
	const double halfDiagonal = 0.5 * side * std::sqrt(double(dim));
	Moments<dim> m;
	if (distance >= halfDiagonal) return m;
	const double volume = std::pow(side, dim);
	if (distance <= -halfDiagonal || depth == 0) {
		m.volume = volume * std::clamp(0.5 - distance / side, 0., 1.);
		m.first = m.volume * centre;
		return m;
	}
	for (int corner = 0; corner < (1 << dim); ++corner) {
		const Moments<dim> part = momentsInside<dim>(
			centre + cornerOffset<dim>(corner, side), 0.5 * side, depth - 1);
		m.volume += part.volume;
		m.first += part.first;
	}
	return m;
}

template <int dim> Vec<dim> cellCentre(const Cell<dim>& cell, double spacing)
{
	Vec<dim> X;
	for (int a = 0; a < dim; ++a)
		X[a] = (cell[a] + 0.5) * spacing;
	return X;
}

/// Cells inside the outline in lexicographic order, with what each of them holds.
template <int dim>
std::map<Cell<dim>, Moments<dim>> occupiedCells(QuadratureRule rule, double spacing)
{
	const int reach = static_cast<int>(std::ceil(1 / spacing));
	const double negligible = negligibleShare * std::pow(spacing, dim);
	std::map<Cell<dim>, Moments<dim>> cells;
	Cell<dim> cell;
	cell.fill(-reach);
	for (;;) {
		const Vec<dim> centre = cellCentre<dim>(cell, spacing);
		Moments<dim> m;
		if (rule == QuadratureRule::cutCell)
			m = momentsInside<dim>(centre, spacing, cutDepth<dim>);
		else if (UnitBall<dim>::signedDistance(centre) < 0)
			m = { 1, centre };
		if (m.volume > negligible) cells.emplace(cell, m);
		int a = dim - 1;
		while (a >= 0 && ++cell[a] == reach)
			cell[a--] = -reach;
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

template <int dim> void scaleToExactVolume(Quadrature<dim>& q)
{
	double sum = 0;
	for (double w : q.weight)
		sum += w;
	for (double& w : q.weight)
		w *= UnitBall<dim>::volume() / sum;
}

/// Points in the 2^dim parts of a cell at the rim.
template <int dim> void addRefined(const Vec<dim>& centre, double side, Quadrature<dim>& q)
{
	for (int corner = 0; corner < (1 << dim); ++corner) {
		const Moments<dim> part = momentsInside<dim>(
			centre + cornerOffset<dim>(corner, side), 0.5 * side, cutDepth<dim> - 1);
		if (part.volume > negligibleShare * std::pow(side, dim)) addPoint(part, q);
	}
}

} // namespace

template <int dim> Quadrature<dim> makeQuadrature(QuadratureRule rule, double spacing)
{
	Quadrature<dim> q;
	for (const auto& [cell, m] : occupiedCells<dim>(rule, spacing)) {
		const Vec<dim> centre = cellCentre<dim>(cell, spacing);
		const bool atRim = UnitBall<dim>::signedDistance(centre) > -0.5 * spacing;
		if (rule == QuadratureRule::cutCell && atRim)
			addRefined(centre, spacing, q);
		else
			addPoint(m, q);
	}
	scaleToExactVolume(q);
	return q;
}

template <int dim> std::vector<Vec<dim>> boundaryPoints(QuadratureRule rule, double spacing)
{
	const auto cells = occupiedCells<dim>(rule, spacing);
	std::vector<Vec<dim>> points;
	for (const auto& [cell, m] : cells)
		if (hasEmptyNeighbour<dim>(cells, cell)) points.push_back(m.first / m.volume);
	return points;
}

template std::vector<Vec<2>> boundaryPoints<2>(QuadratureRule, double);
template std::vector<Vec<3>> boundaryPoints<3>(QuadratureRule, double);
template Quadrature<2> makeQuadrature<2>(QuadratureRule, double);
template Quadrature<3> makeQuadrature<3>(QuadratureRule, double);

} // namespace softgrain
