// One grain between two frictionless planes, against converged finite elements (same law, quadratic
// elements, three meshes, Richardson's extrapolation; good to 0.02 % in 2D and 0.05 % in 3D).
#include "step/Scene.hpp"

#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

struct Reference {
	double approach; ///< of the planes, over D
	double force;    ///< over E D (2D: per unit thickness) or E D^2 (3D)
};

struct Compression {
	std::vector<double> error; ///< relative, of the mean force of both planes
	double imbalance = 0;      ///< of the energy, over the work of the planes
	double kineticShare = 0;   ///< kinetic over elastic energy at the end
	double deepest = 0;        ///< overlap, in dr
	double pressure = 0;       ///< root mean square over the points at the end, over E
	int steps = 0;
};

/// Both planes close in at `speed`/2; the force is the mean over a window of approaches about each
/// reference, wide enough for the grain to bounce at least once to and fro.
template <int dim>
Compression compress(const TemplateRecipe& r, double speed,
		     const std::vector<Reference>& references,
		     Condition condition = usualCondition<dim>,
		     const GrainParameters<dim>& grain = paperGrain<dim>())
{
	const double R = 0.01, D = 2 * R, E = 1e6, window = 0.006;
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(singleGrain<dim>(r, grain, condition));
	const Vec<dim> up = Vec<dim>::Unit(dim - 1);
	scene.addPlane(0, -R * up, up, 0.5 * speed * up);
	scene.addPlane(0, R * up, -up, -0.5 * speed * up);
	Compression result;
	for (const Reference& reference : references) {
		double impulse = 0, span = 0;
		for (;;) {
			const double start = scene.time, approach = speed * start / D;
			if (approach > reference.approach + window) break;
			scene.advance();
			if (approach < reference.approach - window) continue;
			span += scene.time - start;
			for (const ContactList<dim>& list : scene.lists)
				for (const Contact<dim>& c : list.contacts)
					impulse += 0.5 * c.impulse.norm();
		}
		result.error.push_back(
			impulse / span / (E * std::pow(D, dim - 1)) / reference.force - 1);
	}
	const EnergyBalance& e = scene.system.energy();
	result.imbalance = (e.walls - e.impact - e.friction - e.kinetic - e.elastic) / e.walls;
	result.kineticShare = e.kinetic / e.elastic;
	result.deepest = scene.deepest;
	result.steps = scene.steps;
	double squares = 0;
	const auto points = scene.system.setOf(0).points(0);
	for (const PointResponse<dim>& point : points)
		squares += std::pow((point.cauchy.trace() + point.cauchy33) / (3 * E), 2);
	result.pressure = std::sqrt(squares / points.size());
	CHECK(e.friction == 0);
	CHECK(e.loads == 0);
	return result;
}

} // namespace

TEST_CASE("Compression: disk between planes, plane strain", "[step]")
{
	const auto c = compress<2>(recipe(0.1), 0.05, { { 0.05, 0.01989 }, { 0.1, 0.04921 } });
	CAPTURE(c.error[0], c.error[1], c.imbalance, c.kineticShare, c.deepest, c.steps);
	CHECK(std::abs(c.error[0]) < 0.02);
	CHECK(std::abs(c.error[1]) < 0.02);
	CHECK(std::abs(c.imbalance) < 0.01);
	CHECK(c.kineticShare < 0.01);
	CHECK(c.deepest < 0.1);
}

namespace {

/// Errors of the force on the walls of a closing box that four disks, turned anyhow, fill as a
/// square lattice would: half of their contacts are with each other. References over D and E D.
std::vector<double> closeBox(double zeta, const std::vector<Reference>& references)
{
	const double R = 0.01, D = 2 * R, E = 1e6, speed = 0.02, window = 0.0015;
	Random random(1);
	std::vector<GrainParameters<2>> grains(4, paperGrain<2>());
	for (int g = 0; g < 4; ++g)
		grains[g].origin = { g % 2 ? R : -R, g / 2 ? R : -R };
	Batch<2> batch(makeGrainTemplate<2>(recipe(zeta, 3, 1.25)), Law::neoHookean,
		       Condition::planeStrain, grains);
	for (int g = 0; g < 4; ++g) // closing in already
		batch.place(g, random.rotation<2>(), -speed / D * grains[g].origin, Mat<2>::Zero());
	Scene<2> scene;
	scene.settings.solver.tolerance = 1e-3;
	scene.add(std::move(batch));
	scene.addPairs(0);
	for (int wall = 0; wall < 4; ++wall) {
		const Vec<2> normal = (wall % 2 ? -1. : 1.) * Vec<2>::Unit(wall / 2);
		for (int g = 0; g < 4; ++g)
			if (grains[g].origin.dot(normal) < 0)
				scene.addPlane(g, -D * normal, normal, speed * normal).second =
					-1 - wall;
	}
	std::vector<double> errors;
	for (const Reference& reference : references) {
		double impulse = 0, span = 0;
		for (;;) { // walls move twice as far as one disk would have them
			const double start = scene.time, w = 0.5 * speed * start / D;
			if (w > reference.approach + window) break;
			scene.advance();
			if (w < reference.approach - window) continue;
			span += scene.time - start;
			for (const ContactList<2>& list : scene.lists)
				for (const Contact<2>& c : list.contacts)
					if (list.second < 0) impulse += c.impulse.norm() / 8;
		}
		errors.push_back(impulse / span / (E * D) / reference.force - 1);
	}
	return errors;
}

} // namespace

TEST_CASE("Compression: contacts between disks are as good as those with walls", "[step]")
{
	const auto errors = closeBox(
		0.1, { { 0.01, 0.0099028636 }, { 0.015, 0.017221068 }, { 0.02, 0.026025199 } });
	CAPTURE(errors[0], errors[1], errors[2]);
	for (double error : errors)
		CHECK(std::abs(error) < 0.006);
}

TEST_CASE("Compression: ball between planes", "[step]")
{
	const auto c = compress<3>(recipe(0.2), 0.1, { { 0.05, 0.0051316 }, { 0.1, 0.015291 } });
	CAPTURE(c.error[0], c.error[1], c.imbalance, c.kineticShare, c.deepest, c.steps);
	CHECK(std::abs(c.error[0]) < 0.12);
	CHECK(std::abs(c.error[1]) < 0.03);
	CHECK(std::abs(c.imbalance) < 0.01);
	CHECK(c.deepest < 0.1);
}

TEST_CASE("Compression: nearly incompressible disk, volumetric strain projected", "[step]")
{
	GrainParameters<2> grain = paperGrain<2>();
	grain.constants.poisson = 0.499;
	const std::vector<Reference> references { { 0.05, 0.02132 } };
	TemplateRecipe r = recipe(0.1, 3, 1.25);
	const auto pointwise = compress<2>(r, 0.1, references, Condition::planeStrain, grain);
	r.volumetric = VolumetricStrain::projected;
	const auto projected = compress<2>(r, 0.1, references, Condition::planeStrain, grain);
	CAPTURE(projected.error[0], pointwise.error[0], projected.pressure, pointwise.pressure);
	CHECK(std::abs(projected.error[0]) < 0.015);
	CHECK(std::abs(projected.imbalance) < 0.001);
	CHECK(pointwise.pressure > 1.5 * projected.pressure); // it oscillates from point to point
}
