#include "reference/Outline.hpp"
#include "Require.hpp"
#include "reference/RingOutline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace softgrain {

template <> double UnitBall<2>::volume() const { return std::numbers::pi; }
template <> double UnitBall<3>::volume() const { return 4 * std::numbers::pi / 3; }

void closeOutline(OutlineMesh<2>& mesh, const std::vector<int>& corners)
{
	const int count = static_cast<int>(mesh.vertex.size());
	for (int s = 0; s < count; ++s)
		mesh.facet.push_back({ s, (s + 1) % count });
	if (corners.empty()) return;
	mesh.sharp.assign(count, false);
	for (int s : corners)
		mesh.sharp[s] = true;
}

template <> OutlineMesh<2> UnitBall<2>::mesh(double spacing) const
{
	const int count =
		nearestWithoutSmallDivisors(std::max(11., 2 * std::numbers::pi / spacing));
	OutlineMesh<2> mesh;
	for (int s = 0; s < count; ++s) {
		const double angle = 2 * std::numbers::pi * s / count;
		mesh.vertex.emplace_back(std::cos(angle), std::sin(angle));
	}
	closeOutline(mesh, {});
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

template <> OutlineMesh<3> UnitBall<3>::mesh(double spacing) const
{
	const double icosahedronEdge = 1.0515; // of an icosahedron with circumradius 1
	constexpr int least = 4;               // with three parts an edge contacts sink in by half
	const int n = std::max(least, static_cast<int>(std::lround(icosahedronEdge / spacing)));
	return subdivided(icosahedron(), n);
}

template <int dim> double Block<dim>::signedDistance(const Vec<dim>& X) const
{
	const Vec<dim> beyond = X.cwiseAbs() - half_;
	return beyond.cwiseMax(0.).norm() + std::min(beyond.maxCoeff(), 0.);
}

namespace {

/// Number of equal parts of a side, each about `spacing` long.
int partsOf(double side, double spacing, int least)
{
	return std::max(least, static_cast<int>(std::lround(side / spacing)));
}

} // namespace

/// Halves are divided, so that a corner of a cell lies at the centre.
template <int dim> Vec<dim> Block<dim>::cellSides(double spacing) const
{
	Vec<dim> sides;
	for (int a = 0; a < dim; ++a)
		sides[a] = half_[a] / partsOf(half_[a], spacing, 1);
	return sides;
}

template <int dim> Vec<dim> Block<dim>::gridSteps(double spacing, double ratio) const
{
	constexpr double rounding = 1e-9;
	const Vec<dim> cells = half_.cwiseQuotient(cellSides(spacing)); // whole numbers
	const Vec<dim> wide = (half_ / spacing).cwiseMin(cells) / ratio;
	Vec<dim> steps;
	for (int a = 0; a < dim; ++a)
		steps[a] = half_[a] / std::max(1., std::floor(wide[a] + rounding));
	return steps;
}

template <int dim>
std::optional<Moments<dim>> Block<dim>::cut(const Vec<dim>& centre, const Vec<dim>& sides) const
{
	const Vec<dim> low = (centre - 0.5 * sides).cwiseMax(-half_);
	const Vec<dim> high = (centre + 0.5 * sides).cwiseMin(half_);
	Moments<dim> inside;
	if ((low.array() >= high.array()).any()) return inside;
	inside.volume = (high - low).prod();
	inside.first = inside.volume * 0.5 * (low + high);
	return inside;
}

namespace {

OutlineMesh<2> meshOfBlock(const Vec<2>& half, double spacing)
{
	OutlineMesh<2> mesh;
	const std::array<Vec<2>, 4> corner { Vec<2>(-half[0], -half[1]), Vec<2>(half[0], -half[1]),
					     Vec<2>(half[0], half[1]), Vec<2>(-half[0], half[1]) };
	std::vector<int> cornerVertex;
	for (int side = 0; side < 4; ++side) {
		const Vec<2>&from = corner[side], &to = corner[(side + 1) % 4];
		const int parts = partsOf((to - from).norm(), spacing, 2);
		cornerVertex.push_back(static_cast<int>(mesh.vertex.size()));
		for (int k = 0; k < parts; ++k)
			mesh.vertex.push_back(from + double(k) / parts * (to - from));
	}
	closeOutline(mesh, cornerVertex);
	return mesh;
}

Vec<3> normalOf(const OutlineMesh<3>& mesh, int facet)
{
	const auto& [a, b, c] = mesh.facet[facet];
	const Vec<3> from = mesh.vertex[a];
	return (mesh.vertex[b] - from).cross(mesh.vertex[c] - from).normalized();
}

/// SharpEdge::next of all: where two pieces lie in a row.
void joinSharpEdges(OutlineMesh<3>& mesh)
{
	constexpr double straight = 0.9;                                        // cosine
	std::vector<std::vector<std::pair<int, int>>> ends(mesh.vertex.size()); // piece, which end
	for (int k = 0; k < static_cast<int>(mesh.sharpEdge.size()); ++k) {
		ends[mesh.sharpEdge[k].from].push_back({ k, 0 });
		ends[mesh.sharpEdge[k].to].push_back({ k, 1 });
	}
	auto wayOff = [&](int k, int end) {
		const SharpEdge& edge = mesh.sharpEdge[k];
		const Vec<3> way = mesh.vertex[edge.to] - mesh.vertex[edge.from];
		return Vec<3>((end == 0 ? 1 : -1) * way.normalized());
	};
	for (const auto& here : ends)
		for (const auto& [k, end] : here)
			for (const auto& [other, otherEnd] : here)
				if (wayOff(k, end).dot(wayOff(other, otherEnd)) < -straight)
					mesh.sharpEdge[k].next[end] = other;
}

/// OutlineMesh::sharpEdge of the facets that there are.
void findSharpEdges(OutlineMesh<3>& mesh)
{
	constexpr double flat = 0.9; // cosine between the normals of two facets that are one side
	struct Half {
		int facet, opposite;
	};
	std::map<std::pair<int, int>, Half> known; // by the ends, the other way round in its mate
	for (int f = 0; f < static_cast<int>(mesh.facet.size()); ++f)
		for (int i = 0; i < 3; ++i) {
			const auto& vertex = mesh.facet[f];
			const int from = vertex[i], to = vertex[(i + 1) % 3],
				  opposite = vertex[(i + 2) % 3];
			const auto mate = known.find({ to, from });
			if (mate == known.end())
				known[{ from, to }] = { f, opposite };
			else if (normalOf(mesh, f).dot(normalOf(mesh, mate->second.facet)) < flat)
				mesh.sharpEdge.push_back({ to,
							   from,
							   { mate->second.facet, f },
							   { mate->second.opposite, opposite } });
		}
	joinSharpEdges(mesh);
}

/// Rectangles of each face, in two triangles each; faces share the vertices on their edges.
OutlineMesh<3> meshOfBlock(const Vec<3>& half, double spacing)
{
	OutlineMesh<3> mesh;
	std::array<int, 3> parts;
	for (int a = 0; a < 3; ++a)
		parts[a] = partsOf(2 * half[a], spacing, 2);
	using Index = std::array<int, 3>;
	std::map<Index, int> known;
	auto vertexIndex = [&](const Index& index) {
		const auto [place, isNew] =
			known.try_emplace(index, static_cast<int>(mesh.vertex.size()));
		if (isNew) {
			Vec<3> X;
			for (int a = 0; a < 3; ++a)
				X[a] = (2. * index[a] / parts[a] - 1) * half[a];
			mesh.vertex.push_back(X);
		}
		return place->second;
	};
	for (int axis = 0; axis < 3; ++axis)
		for (int end : { 0, parts[axis] }) {
			const int u = (axis + 1) % 3, v = (axis + 2) % 3;
			auto at = [&](int i, int j) {
				Index index;
				index[axis] = end;
				index[u] = i;
				index[v] = j;
				return vertexIndex(index);
			};
			for (int i = 0; i < parts[u]; ++i)
				for (int j = 0; j < parts[v]; ++j) {
					std::array<int, 4> loop { at(i, j), at(i + 1, j),
								  at(i + 1, j + 1), at(i, j + 1) };
					if (end == 0) std::swap(loop[1], loop[3]);
					mesh.facet.push_back({ loop[0], loop[1], loop[2] });
					mesh.facet.push_back({ loop[0], loop[2], loop[3] });
				}
		}
	mesh.sharp.assign(mesh.vertex.size(), false);
	for (const auto& [index, vertex] : known) {
		int ends = 0;
		for (int a = 0; a < 3; ++a)
			ends += index[a] == 0 || index[a] == parts[a];
		mesh.sharp[vertex] = ends > 1;
	}
	findSharpEdges(mesh);
	return mesh;
}

} // namespace

template <int dim> OutlineMesh<dim> Block<dim>::mesh(double spacing) const
{
	return meshOfBlock(half_, spacing);
}

void GrainForm::validate() const
{
	for (double component : aspect)
		require(component >= 1 && component <= 100, "aspect (component)", component,
			"[1, 100]");
	const double shortest = *std::min_element(aspect.begin(), aspect.end());
	require(shortest == 1, "aspect (smallest component)", shortest,
		"1: the radius is half the shortest side");
	require(exponent >= 1.25 && exponent <= 20, "exponent", exponent, "[1.25, 20]");
	if (form != Form::polygon) return;
	if (!ring) throw std::invalid_argument("vertices: a polygon has at least three");
	ring->validate();
}

bool GrainForm::operator<(const GrainForm& o) const
{
	if (form != o.form) return form < o.form;
	if (aspect != o.aspect) return aspect < o.aspect;
	if (exponent != o.exponent) return exponent < o.exponent;
	if (ring == o.ring) return false;
	return ring && o.ring ? *ring < *o.ring : !ring;
}

template <int dim> std::unique_ptr<const Outline<dim>> makeOutline(const GrainForm& form)
{
	if (form.form == Form::ball) return std::make_unique<UnitBall<dim>>();
	if (form.form == Form::block)
		return std::make_unique<Block<dim>>(Vec<dim>(form.aspect.data()));
	if constexpr (dim == 2) {
		if (form.form == Form::superdisk)
			return std::make_unique<RingOutline>(
				superdisk(form.aspect[0], form.aspect[1], form.exponent));
		return std::make_unique<RingOutline>(*form.ring);
	} else
		throw std::invalid_argument("form: polygons and superdisks are for dim = 2");
}

template class UnitBall<2>;
template class UnitBall<3>;
template class Block<2>;
template class Block<3>;
template std::unique_ptr<const Outline<2>> makeOutline<2>(const GrainForm&);
template std::unique_ptr<const Outline<3>> makeOutline<3>(const GrainForm&);

} // namespace softgrain
