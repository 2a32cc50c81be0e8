#include "Helpers.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "reference/TriangleMesh.hpp"

#include <catch2/catch_test_macros.hpp>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

TriangleMesh meshOf(double spacing) { return meshOfDisk(UnitBall<2>().mesh(spacing), spacing); }

double areaOf(const TriangleMesh& mesh)
{
	double area = 0;
	for (double weight : mesh.quadrature().weight)
		area += weight;
	return area;
}

} // namespace

TEST_CASE("Triangles: they fill the disk up to second order, none is thin", "[reference]")
{
	double last = 0;
	for (double spacing : { 0.2, 0.1, 0.05 }) {
		const TriangleMesh mesh = meshOf(spacing);
		for (double weight : mesh.quadrature().weight) {
			CHECK(weight > 0.15 * spacing * spacing);
			CHECK(weight < 0.9 * spacing * spacing);
		}
		const double missing = std::numbers::pi - areaOf(mesh);
		CHECK(missing > 0);
		if (last > 0) CHECK(missing < last / 3);
		last = missing;
		// Euler: nodes - edges + triangles = 1, and every edge but those of the rim has two
		const int rim = static_cast<int>(UnitBall<2>().mesh(spacing).vertex.size());
		const int triangles = static_cast<int>(mesh.triangle.size());
		CHECK(static_cast<int>(mesh.node.size()) - (3 * triangles + rim) / 2 + triangles ==
		      1);
	}
}

TEST_CASE("Triangles: shape functions are exact for affine fields", "[reference]")
{
	const TriangleMesh mesh = meshOf(0.15);
	const auto shapes = mesh.shapes();
	const auto quadrature = mesh.quadrature();
	Random random(1);
	const Mat<2> A = random.matrix<2>();
	const Vec<2> b = random.vector<2>();
	for (int p = 0; p < shapes.rows(); ++p) {
		Vec<2> value = Vec<2>::Zero();
		Mat<2> gradient = Mat<2>::Zero();
		for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
			const Vec<2> u = A * mesh.node[shapes.column[k]] + b;
			value += shapes.value[k].N * u;
			gradient += u * shapes.value[k].G.transpose();
		}
		CHECK((value - A * quadrature.point[p] - b).norm() < 1e-14);
		CHECK((gradient - A).norm() < 1e-12);
	}
}

TEST_CASE("Triangles: the template of a disk", "[reference]")
{
	TemplateRecipe own = recipe(0.1);
	own.basis = Basis::triangles;
	const auto grain = makeGrainTemplate<2>(own);
	double mass = 0;
	for (double m : grain->nodeMass)
		mass += m;
	CHECK(std::abs(mass / grain->volume - 1) < 1e-14);
	REQUIRE(grain->contactNodes() > 60);
	for (int s = 0; s < grain->contactNodes(); ++s) {
		CHECK(grain->nodePosition[s] == grain->contactMesh.vertex[s]);
		CHECK(std::abs(grain->delassus.value[s] * grain->nodeMass[s] - 1) < 1e-14);
	}
	// of the order of the smallest height of a triangle over the speed of waves
	const GrainParameters<2> disk = paperGrain<2>();
	const double step = criticalTimeStep(*grain, Condition::planeStrain, disk) *
			    disk.constants.waveSpeed(Condition::planeStrain) / disk.radius;
	CHECK(step > 0.02);
	CHECK(step < 0.1);
}

TEST_CASE("Triangles: what they are not made for is refused", "[reference]")
{
	TemplateRecipe own = recipe(0.2);
	own.basis = Basis::triangles;
	CHECK(complaintOf([&] { makeGrainTemplate<3>(own); }).find("dim = 2") != std::string::npos);
	own.contact = ContactGeometry::points;
	CHECK(complaintOf([&] { makeGrainTemplate<2>(own); }).find("basis = 'triangles'") !=
	      std::string::npos);
}
