#include "reference/TriangleMesh.hpp"

#include <cmath>
#include <numbers>

namespace softgrain {

namespace {

/// Fewer nodes on a ring would make needles of its triangles.
constexpr int fewestOnRing = 6;

/// Nodes side by side on a circle.
struct NodeRing {
	int first, count;
	double start; ///< angle of the first node

	int at(int i) const { return first + i % count; }
	double angle(int i) const { return start + 2 * std::numbers::pi * i / count; }
};

NodeRing appendRing(double radius, int count, double start, TriangleMesh& mesh)
{
	const NodeRing ring { static_cast<int>(mesh.node.size()), count, start };
	for (int i = 0; i < count; ++i)
		mesh.node.emplace_back(radius * std::cos(ring.angle(i)),
				       radius * std::sin(ring.angle(i)));
	return ring;
}

/// Triangles between two rings: once around both, from whichever is behind.
void stitch(const NodeRing& outer, const NodeRing& inner, TriangleMesh& mesh)
{
	int i = 0, j = 0;
	while (i < outer.count || j < inner.count) {
		const bool outwards = j == inner.count ||
				      (i < outer.count && outer.angle(i + 1) <= inner.angle(j + 1));
		if (outwards) {
			mesh.triangle.push_back({ outer.at(i), outer.at(i + 1), inner.at(j) });
			++i;
		} else {
			mesh.triangle.push_back({ outer.at(i), inner.at(j + 1), inner.at(j) });
			++j;
		}
	}
}

double areaOf(const TriangleMesh& mesh, const std::array<int, 3>& corner)
{
	const Vec<2>& a = mesh.node[corner[0]];
	return 0.5 * cross(mesh.node[corner[1]] - a, mesh.node[corner[2]] - a);
}

} // namespace

TriangleMesh meshOfDisk(const OutlineMesh<2>& rim, double spacing)
{
	TriangleMesh mesh;
	mesh.node = rim.vertex;
	const int onRim = static_cast<int>(rim.vertex.size());
	const int rings = std::max(static_cast<int>(std::lround(1 / spacing)), 2);
	NodeRing outer { 0, onRim, std::atan2(rim.vertex[0][1], rim.vertex[0][0]) };
	for (int k = 1; k < rings; ++k) {
		const double radius = 1 - static_cast<double>(k) / rings;
		const int count =
			std::max(static_cast<int>(std::lround(radius * onRim)), fewestOnRing);
		const double half = std::numbers::pi / count; // rings out of step: no needles
		const NodeRing inner =
			appendRing(radius, count, outer.start + (k % 2 ? half : -half), mesh);
		stitch(outer, inner, mesh);
		outer = inner;
	}
	const NodeRing centre = appendRing(0, 1, outer.start, mesh);
	for (int i = 0; i < outer.count; ++i)
		mesh.triangle.push_back({ outer.at(i), outer.at(i + 1), centre.first });
	return mesh;
}

Quadrature<2> TriangleMesh::quadrature() const
{
	Quadrature<2> quadrature;
	for (const auto& corner : triangle) {
		quadrature.point.push_back((node[corner[0]] + node[corner[1]] + node[corner[2]]) /
					   3);
		quadrature.weight.push_back(areaOf(*this, corner));
	}
	return quadrature;
}

SparseRows<ShapeFunction<2>> TriangleMesh::shapes() const
{
	SparseRows<ShapeFunction<2>> rows;
	for (const auto& corner : triangle) {
		const double area = areaOf(*this, corner);
		for (int k = 0; k < 3; ++k) {
			const Vec<2> edge = node[corner[(k + 2) % 3]] - node[corner[(k + 1) % 3]];
			rows.append(corner[k], { 1. / 3, Vec<2>(-edge[1], edge[0]) / (2 * area) });
		}
		rows.closeRow();
	}
	return rows;
}

std::vector<double> TriangleMesh::nodeMass() const
{
	std::vector<double> mass(node.size(), 0.);
	for (const auto& corner : triangle)
		for (int I : corner)
			mass[I] += areaOf(*this, corner) / 3;
	return mass;
}

} // namespace softgrain
