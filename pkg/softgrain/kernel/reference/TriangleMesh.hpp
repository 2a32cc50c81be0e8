// Linear triangles over a disk: finite elements in place of splines, for comparison.
#pragma once

#include "reference/Outline.hpp"
#include "reference/Quadrature.hpp"
#include "reference/ShapeFunction.hpp"
#include "reference/SparseRows.hpp"

namespace softgrain {

struct TriangleMesh {
	std::vector<Vec<2>> node;
	std::vector<std::array<int, 3>> triangle; ///< nodes, counter-clockwise

	/// A point in the centre of each triangle, with its area.
	Quadrature<2> quadrature() const;
	/// Shape functions at these points.
	SparseRows<ShapeFunction<2>> shapes() const;
	/// A third of the area of its triangles at each node.
	std::vector<double> nodeMass() const;
};

/// Rings of nodes about `spacing` apart; the first nodes are the vertices of `rim`, the outline of
/// the unit disk.
TriangleMesh meshOfDisk(const OutlineMesh<2>& rim, double spacing);

} // namespace softgrain
