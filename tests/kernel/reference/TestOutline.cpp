#include "Helpers.hpp"
#include "reference/Outline.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <map>
#include <numbers>
#include <set>

using namespace softgrain;

namespace {

/// Outward normal times length (area) of a facet.
Vec<2> areaVector(const OutlineMesh<2>& m, int f)
{
	const Vec<2> edge = m.vertex[m.facet[f][1]] - m.vertex[m.facet[f][0]];
	return { edge[1], -edge[0] };
}
Vec<3> areaVector(const OutlineMesh<3>& m, int f)
{
	const Vec<3>&a = m.vertex[m.facet[f][0]], &b = m.vertex[m.facet[f][1]],
	      &c = m.vertex[m.facet[f][2]];
	return 0.5 * (b - a).cross(c - a);
}

template <int dim> Vec<dim> centroid(const OutlineMesh<dim>& m, int f)
{
	Vec<dim> sum = Vec<dim>::Zero();
	for (int v : m.facet[f])
		sum += m.vertex[v];
	return sum / dim;
}

/// Enclosed area (volume) by the divergence theorem.
template <int dim> double enclosed(const OutlineMesh<dim>& m)
{
	double sum = 0;
	for (std::size_t f = 0; f < m.facet.size(); ++f)
		sum += centroid(m, f).dot(areaVector(m, f)) / dim;
	return sum;
}

template <int dim> double meanEdge(const OutlineMesh<dim>& m)
{
	double sum = 0;
	int count = 0;
	for (const auto& f : m.facet)
		for (int i = 0; i < (dim == 2 ? 1 : 3); ++i, ++count)
			sum += (m.vertex[f[(i + 1) % dim]] - m.vertex[f[i]]).norm();
	return sum / count;
}

} // namespace

TEST_CASE("Outline: volume and signed distance of the unit ball", "[reference]")
{
	CHECK(std::abs(UnitBall<2>().volume() - std::numbers::pi) < 1e-15);
	CHECK(std::abs(UnitBall<3>().volume() - 4.1887902047863905) < 1e-14);
	CHECK(UnitBall<2>().signedDistance({ 0, 0 }) == -1);
	CHECK(UnitBall<3>().signedDistance({ 0, 3, 4 }) == 4);
}

TEMPLATE_TEST_CASE_SIG("Outline: vertices on the ball, facets outwards", "[reference]",
		       ((int dim), dim), 2, 3)
{
	for (double spacing : { 0.05, 0.11, 0.3, 1., 2. }) {
		CAPTURE(spacing);
		const auto mesh = UnitBall<dim>().mesh(spacing);
		CHECK(mesh.vertex.size() >= (dim == 2 ? 11 : 12));
		for (const Vec<dim>& X : mesh.vertex)
			CHECK(std::abs(X.norm() - 1) < 1e-14);
		for (std::size_t f = 0; f < mesh.facet.size(); ++f) {
			const Vec<dim> n = areaVector(mesh, f).normalized();
			CHECK(n.dot(centroid(mesh, f).normalized()) > 0.99);
		}
	}
}

TEST_CASE("Outline: contacts at 60 or 90 degrees meet the nodes of a disk at different phases",
	  "[reference]")
{
	for (double spacing : { 0.02, 0.05, 0.07, 0.1, 0.11, 0.14, 0.2, 0.5, 2. }) {
		const std::size_t count = UnitBall<2>().mesh(spacing).vertex.size();
		CAPTURE(spacing, count);
		CHECK(count % 2 != 0);
		CHECK(count % 3 != 0);
		CHECK(std::abs(count - std::max(11., 2 * std::numbers::pi / spacing)) <= 2);
	}
}

TEMPLATE_TEST_CASE_SIG("Outline: closed, every edge once in each direction", "[reference]",
		       ((int dim), dim), 2, 3)
{
	for (double spacing : { 0.07, 0.2, 0.5 }) {
		const auto mesh = UnitBall<dim>().mesh(spacing);
		std::set<int> used;
		for (const auto& f : mesh.facet)
			used.insert(f.begin(), f.end());
		CHECK(used.size() == mesh.vertex.size());
		if constexpr (dim == 2) {
			std::map<int, int> starts, ends;
			for (const auto& f : mesh.facet) {
				++starts[f[0]];
				++ends[f[1]];
			}
			for (int v : used) {
				CHECK(starts[v] == 1);
				CHECK(ends[v] == 1);
			}
		} else {
			std::map<std::pair<int, int>, int> edges;
			for (const auto& f : mesh.facet)
				for (int i = 0; i < 3; ++i)
					++edges[{ f[i], f[(i + 1) % 3] }];
			bool paired = true;
			for (const auto& [edge, count] : edges)
				paired = paired && count == 1 &&
					 edges.count({ edge.second, edge.first });
			CHECK(paired);
			const int V = mesh.vertex.size(), E = edges.size() / 2,
				  F = mesh.facet.size();
			CHECK(V - E + F == 2);
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Outline: enclosed volume converges at second order from below",
		       "[reference]", ((int dim), dim), 2, 3)
{
	double last = 0;
	const int coarsest = dim == 2 ? 1 : 2; // a ball has a least number of vertices
	for (int n : { 1, 2, 4, 8 }) {
		const double spacing =
			0.52575 / (coarsest * n); // halves the edges in 3D too, where they divide
						  // the icosahedron's
		const double error =
			1 - enclosed(UnitBall<dim>().mesh(spacing)) / UnitBall<dim>().volume();
		CAPTURE(spacing, error);
		CHECK(error > 0);
		if (n > 1) {
			CHECK(last / error > 3.6);
			CHECK(last / error < 4.4);
		}
		last = error;
	}
	CHECK(last < 1e-2);
}

TEMPLATE_TEST_CASE_SIG("Outline: mean edge near the spacing asked for", "[reference]",
		       ((int dim), dim), 2, 3)
{
	for (double spacing : { 0.05, 0.11, 0.2, 0.25 }) {
		CAPTURE(spacing);
		const double edge = meanEdge(UnitBall<dim>().mesh(spacing));
		CAPTURE(edge);
		CHECK(std::abs(edge / spacing - 1) < (dim == 2 ? 0.05 : 0.2));
	}
}
