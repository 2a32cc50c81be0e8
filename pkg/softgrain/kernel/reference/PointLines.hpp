// The material points of a grain in the order in which the bulk pass meets them: in lines.
//
// Shape functions are products of B-splines of one coordinate each. Points that differ in the last
// coordinate only share the factors of all others, so that the sums over the nodes across the line
// are made once for each row of nodes, and only a sum over order + 1 rows is left to every point.
// The nodes are taken as a full box of the grid, where the nodes of a stencil need no table. The
// tied nodes are in it, too, so that every stencil is a full one: they get their positions from the
// nodes that they follow, and hand them their forces.
#pragma once

#include "reference/BSpline.hpp"
#include "reference/BackgroundGrid.hpp"

namespace softgrain {

template <int dim> struct PointLines {
	/// Longer ones are cut, so that what is kept for a line has a bounded size.
	static constexpr int maxPoints = 16;

	struct Line {
		int begin, end; ///< its points
		int firstRun;   ///< the others follow
		int place;      ///< in the box: first node of the first row
	};
	/// Points of a line that meet the same rows.
	struct Run {
		int begin, end; ///< its points
		int place;      ///< in the box: first node of the first row
		int line;
	};
	struct Point {
		int number;    ///< as in GrainTemplate::pointPosition
		int row;       ///< first one that it meets
		double volume; ///< Vp0, in radii^dim
		double t;      ///< place along the line, as `splineFactors` takes it
	};
	/// B-splines along the line at a point, and their derivatives, 1/radius.
	struct Factors {
		SplineFactors value, slope;
	};

	std::array<int, dim> size {};   ///< of the box, in nodes
	std::array<int, dim> stride {}; ///< of a step along each axis in the box; the last is 1
	int places = 0;                 ///< nodes in the box
	std::vector<int> nodePlace;     ///< of the nodes that carry unknowns
	std::vector<int> tiePlace;      ///< of the tied nodes
	SparseRows<double> ties;        ///< row: tied node, column: node that it follows

	int nodes() const { return static_cast<int>(nodePlace.size()); }
	/// The lines are mere lists of points, whose stencils are the rows of
	/// GrainTemplate::pointShapes; places are nodes.
	bool isTable() const { return run.empty(); }
	/// Calls `use(place of a tied node, forEachFollowed)`, where `forEachFollowed(visit)` calls
	/// `visit(place, weight)` for the nodes that it follows.
	template <class Use> void forEachTied(Use&& use) const
	{
		for (int t = 0; t < ties.rows(); ++t)
			use(tiePlace[t], [&](auto&& visit) {
				for (int k = ties.begin(t); k < ties.end(t); ++k)
					visit(nodePlace[ties.column[k]], ties.value[k]);
			});
	}

	std::vector<Line> line;
	std::vector<Run> run;
	std::vector<Point> point;
	/// Of every point; empty where the lines are a table. For grains that share it: where each
	/// grain has lines of its own, memory is slower than the polynomials
	/// (doc/decisions/0013-bulk-pass.md).
	std::vector<Factors> along;
	double spacing = 1; ///< of the grid along the lines, in radii
	/// For each line the products of the B-splines across it, at every node of a row: first of
	/// their values, then with the derivative along axis 0, 1 ... instead. The axis before the
	/// last runs fastest.
	std::vector<double> across;
};

/// Lines `begin` to `end`.
struct LineRange {
	int begin, end;
};
template <int dim> int runsBegin(const PointLines<dim>& lines, int line)
{
	return line < static_cast<int>(lines.line.size()) ? lines.line[line].firstRun
							  : static_cast<int>(lines.run.size());
}
/// The next lines from `begin` on that have at most `points` points together.
template <int dim> LineRange nextStrip(const PointLines<dim>& lines, int begin, int points)
{
	const int limit = lines.line[begin].begin + points;
	int end = begin + 1;
	while (end < static_cast<int>(lines.line.size()) && lines.line[end].end <= limit)
		++end;
	return { begin, end };
}

template <int dim>
PointLines<dim> makePointLines(const BackgroundGrid<dim>& grid, const Quadrature<dim>& quadrature);
/// Where shape functions are no products: PointLines::isTable.
template <int dim> PointLines<dim> makePointTable(int nodes, const Quadrature<dim>& quadrature);

} // namespace softgrain
