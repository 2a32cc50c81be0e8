#include "reference/Outline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace softgrain {

template <> double UnitBall<2>::volume() { return std::numbers::pi; }
template <> double UnitBall<3>::volume() { return 4 * std::numbers::pi / 3; }

template <> OutlineMesh<2> UnitBall<2>::mesh(double spacing)
{
	const int count =
		std::max(8, static_cast<int>(std::lround(2 * std::numbers::pi / spacing)));
	OutlineMesh<2> mesh;
	for (int s = 0; s < count; ++s) {
		const double angle = 2 * std::numbers::pi * s / count;
		mesh.vertex.emplace_back(std::cos(angle), std::sin(angle));
		mesh.facet.push_back({ s, (s + 1) % count });
	}
	return mesh;
}

namespace {

OutlineMesh<3> icosahedron()
{
	const double g = std::numbers::phi;
	OutlineMesh<3> mesh;
	mesh.vertex = { { -1, g, 0 }, { 1, g, 0 }, { -1, -g, 0 }, { 1, -g, 0 },
			{ 0, -1, g }, { 0, 1, g }, { 0, -1, -g }, { 0, 1, -g },
			{ g, 0, -1 }, { g, 0, 1 }, { -g, 0, -1 }, { -g, 0, 1 } };
	mesh.facet = { { 0, 11, 5 }, { 0, 5, 1 },  { 0, 1, 7 },   { 0, 7, 10 }, { 0, 10, 11 },
		       { 1, 5, 9 },  { 5, 11, 4 }, { 11, 10, 2 }, { 10, 7, 6 }, { 7, 1, 8 },
		       { 3, 9, 4 },  { 3, 4, 2 },  { 3, 2, 6 },   { 3, 6, 8 },  { 3, 8, 9 },
		       { 4, 9, 5 },  { 2, 4, 11 }, { 6, 2, 10 },  { 8, 6, 7 },  { 9, 8, 1 } };
	for (Vec<3>& X : mesh.vertex)
		X.normalize();
	return mesh;
}

/// Every triangle into n x n, the new vertices projected onto the sphere and shared by neighbours.
OutlineMesh<3> subdivided(const OutlineMesh<3>& coarse, int n)
{
	OutlineMesh<3> fine;
	std::map<std::array<long, 3>, int> known;
	auto vertexIndex = [&](Vec<3> X) {
		X.normalize();
		const double grain = 1e7; // vertices closer than 1e-7 radii are the same one
		const std::array<long, 3> key { std::lround(X[0] * grain),
						std::lround(X[1] * grain),
						std::lround(X[2] * grain) };
		const auto [place, isNew] =
			known.try_emplace(key, static_cast<int>(fine.vertex.size()));
		if (isNew) fine.vertex.push_back(X);
		return place->second;
	};
	for (const auto& [a, b, c] : coarse.facet) {
		auto at = [&](int i, int j) {
			return vertexIndex(((n - i - j) * coarse.vertex[a] + i * coarse.vertex[b] +
					    j * coarse.vertex[c]));
		};
		for (int i = 0; i < n; ++i)
			for (int j = 0; i + j < n; ++j) {
				fine.facet.push_back({ at(i, j), at(i + 1, j), at(i, j + 1) });
				if (i + j < n - 1)
					fine.facet.push_back(
						{ at(i + 1, j), at(i + 1, j + 1), at(i, j + 1) });
			}
	}
	return fine;
}

} // namespace

template <> OutlineMesh<3> UnitBall<3>::mesh(double spacing)
{
	const double icosahedronEdge = 1.0515; // of an icosahedron with circumradius 1
	const int n = std::max(1, static_cast<int>(std::lround(icosahedronEdge / spacing)));
	return subdivided(icosahedron(), n);
}

template struct UnitBall<2>;
template struct UnitBall<3>;

} // namespace softgrain
