// Grains with a long critical step beside grains with a short one: their forces act for several
// steps.
#include "step/Formulations.hpp"
#include "step/Scene.hpp"

#include "Threads.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "grain/Vibrations.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <utility>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

constexpr double R = 0.01, E = 1e6;
constexpr int ratio = 8; ///< of the radii

template <int dim>
GrainParameters<dim> grainAt(const Vec<dim>& place, double radius, const Damping& damping = {})
{
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.radius = radius;
	grain.origin = place;
	grain.damping = damping;
	return grain;
}

/// Congruent grains in one set, all computed.
template <int dim>
Scene<dim> sceneOf(const std::vector<GrainParameters<dim>>& grains, bool multirate,
		   const TemplateRecipe& r = coarse<dim>())
{
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.settings.rigidMotion = false;
	scene.add(Batch<dim>(makeGrainTemplate<dim>(r), Law::neoHookean, usualCondition<dim>,
			     grains));
	scene.system.setMultirate(multirate);
	return scene;
}

/// A grain, and a small one far away that makes it a slow one.
template <int dim>
Scene<dim> slowGrain(const Damping& damping = {}, const TemplateRecipe& r = coarse<dim>())
{
	return sceneOf<dim>({ grainAt<dim>(Vec<dim>::Zero(), R, damping),
			      grainAt<dim>(Vec<dim>::Unit(0), R / ratio) },
			    true, r);
}

/// Largest deviation of a small vibration of a slow disk from what the step of n dt makes of it,
/// over its amplitude: TestDamping's, y_(m+1) = (1 + D - w^2 (n dt)^2) y_m - D y_(m-1).
double deviation(double stiffnessDamping, int index)
{
	const Damping damping { 0, stiffnessDamping };
	Scene<2> scene = slowGrain<2>(damping);
	auto alone = singleGrain<2>(coarse<2>(), grainAt<2>(Vec<2>::Zero(), R));
	const int components = 2 * alone.reference->nodes();
	const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(dynamicMatrix(alone));
	const int chosen = index < 0 ? components + index : index;
	const double squared = modes.eigenvalues()[chosen];
	const Eigen::VectorXd mode = modes.eigenvectors().col(chosen);
	auto rootMass = [&](int i) { return std::sqrt(alone.nodeMass(0, i / 2)); };
	Vec<2>* x = scene.batchOf(0).x.of(0);
	for (int i = 0; i < components; ++i)
		x[i / 2][i % 2] +=
			1e-7 * R * mode[i] / rootMass(i) / mode.lpNorm<Eigen::Infinity>();
	scene.system.invalidateForces();
	const int n = scene.system.timeSteps().rate(0);
	const double dt = 0.8 * scene.system.criticalTimeStep();
	std::vector<double> y;
	for (int step = 0; step <= 40 * n; ++step) {
		if (step > 0 && step % n == 0) { // in the first step nothing is held yet
			y.push_back(0);
			for (int i = 0; i < components; ++i)
				y.back() += mode[i] * rootMass(i) *
					    (x[i / 2][i % 2] -
					     R * alone.reference->nodePosition[i / 2][i % 2]);
		}
		scene.advance(dt);
	}
	const double D = 1 - stiffnessDamping * squared * n * dt;
	double worst = 0, size = 0;
	for (std::size_t m = 1; m + 1 < y.size(); ++m) {
		worst = std::max(worst,
				 std::abs(y[m + 1] - (1 + D - squared * n * n * dt * dt) * y[m] +
					  D * y[m - 1]));
		size = std::max(size, std::abs(y[m]));
	}
	return worst / size;
}

/// A slow disk between two planes that close in, a fast one far away.
struct Squeeze {
	std::vector<double> force; ///< of the upper plane, N/m, by tenths of the run
	double noise = 0;     ///< root mean square of its changes from step to step, over the mean
	double imbalance = 0; ///< of energy, over the work of the planes
	long points = 0;
};

Squeeze squeeze(bool multirate)
{
	Scene<2> scene = sceneOf<2>(
		{ grainAt<2>(Vec<2>::Zero(), R), grainAt<2>(Vec<2>(1, 0), R / ratio) }, multirate);
	scene.addPlane(0, Vec<2>(0, -R), Vec<2>(0, 1), Vec<2>(0, 0.25), 0.3);
	auto& top = scene.addPlane(0, Vec<2>(0, R), Vec<2>(0, -1), Vec<2>(0, -0.25), 0.3);
	const double end = 0.01;
	Squeeze result;
	double last = 0, changes = 0, sum = 0;
	int window = 0;
	scene.settings.rigidMotion = true; // of the fast one
	while (scene.time < end) {
		const StepReport report = scene.advance();
		result.points += report.work.points;
		double force = 0;
		for (const Contact<2>& c : top.contacts)
			force -= c.impulse[1] / report.kick;
		sum += force;
		++window;
		if (scene.time > 0.5 * end) changes += std::pow(force - last, 2) / (force * force);
		last = force;
		if (scene.time < 0.1 * end * (result.force.size() + 1)) continue;
		result.force.push_back(sum / window);
		sum = window = 0;
	}
	result.noise = std::sqrt(changes / (0.5 * scene.steps));
	const EnergyBalance& e = scene.system.energy();
	result.imbalance = conserved(e) / e.walls;
	return result;
}

/// Two slow grains and two fast ones in a heap that flies together, or several such heaps.
template <int dim> Scene<dim> heap(bool multirate, int heaps = 1)
{
	const double q = R / ratio;
	auto at = [](double x, double y, double z = 0) {
		Vec<dim> place = Vec<dim>::Zero();
		place[0] = x;
		place[1] = y;
		place[dim - 1] += z;
		return place;
	};
	std::vector<GrainParameters<dim>> grains;
	for (int h = 0; h < heaps; ++h) {
		const double aside = 10 * R * h;
		grains.push_back(grainAt<dim>(at(0, 0, aside), R));
		grains.push_back(grainAt<dim>(at(R + q, 0.1 * q, aside), q));
		grains.push_back(grainAt<dim>(at(2 * (R + q), 0, aside), R));
		grains.push_back(grainAt<dim>(at(R + 0.2 * q, -4 * q, aside), q));
		grains.push_back(grainAt<dim>(at(0, 2.01 * R, aside), 0.95 * R));
	}
	Scene<dim> scene = sceneOf<dim>(grains, multirate);
	auto& batch = scene.batchOf(0);
	const double speed[] = { 0.5, 0, -0.5, 0, 0 };
	for (int g = 0; g < 5 * heaps; ++g)
		batch.place(g, Mat<dim>::Identity(), at(speed[g % 5], g % 5 == 4 ? -0.5 : 0),
			    Mat<dim>::Zero());
	scene.system.updateSurfaces(1);
	scene.addPairs(0.3, [](int a, int b) { return a / 5 == b / 5; });
	return scene;
}

} // namespace

TEST_CASE("Multirate: each mode of a slow disk moves as with the long step", "[multirate]")
{
	const double time = R / paperGrain<2>().constants.waveSpeed(Condition::planeStrain);
	for (double damping : { 0., 0.02 * time })
		for (int mode : { 3, 10, 40, -1 }) { // the first three are rigid
			CAPTURE(damping, mode);
			CHECK(deviation(damping, mode) < 1e-6);
		}
}

TEMPLATE_TEST_CASE_SIG("Multirate: momenta and energy of a free grain stay", "[multirate]",
		       ((int dim), dim), 2, 3)
{
	Random random(1);
	Scene<dim> scene = slowGrain<dim>();
	const Mat<dim> spin = random.matrix<dim>(20);
	deform<dim>(scene.batchOf(0), 0, Mat<dim>::Identity() + random.matrix<dim>(0.05));
	scene.batchOf(0).moveRigidly(0, Vec<dim>::Zero(), Mat<dim>::Identity(), Vec<dim>::Zero(),
				     random.vector<dim>(), spin - spin.transpose());
	scene.system.invalidateForces();
	const int n = scene.system.timeSteps().rate(0);
	REQUIRE(n == ratio);
	const double dt = 0.4 * scene.system.criticalTimeStep();
	for (int k = 0; k < n; ++k)
		scene.advance(dt);
	const auto before = scene.whole(0);
	const double start = stored(scene.system.energy());
	double worst = 0, mean[2] = { 0, 0 };
	constexpr int half = 200 * ratio;
	for (int k = 0; k < 2 * half; ++k) {
		scene.advance(dt);
		const double now = stored(scene.system.energy());
		worst = std::max(worst, std::abs(now - start));
		mean[k / half] += now / half;
	}
	const auto after = scene.whole(0);
	CHECK((after.velocity - before.velocity).norm() < 1e-12 * before.velocity.norm());
	CHECK((after.angularMomentum - before.angularMomentum).norm() <
	      1e-11 * before.angularMomentum.norm());
	CAPTURE(worst / start, mean[0] / start, mean[1] / start);
	CHECK(worst < 0.02 * start);
	CHECK(std::abs(mean[1] - mean[0]) < 1e-3 * start);
}

TEST_CASE("Multirate: a squeezed disk bears what it bears with short steps", "[multirate]")
{
	const Squeeze plain = squeeze(false), multi = squeeze(true);
	REQUIRE(plain.force.size() == multi.force.size());
	for (std::size_t k = 1; k < plain.force.size(); ++k) {
		CAPTURE(k, plain.force[k], multi.force[k]);
		CHECK(std::abs(multi.force[k] / plain.force[k] - 1) < 0.02);
	}
	CAPTURE(plain.noise, multi.noise, multi.imbalance);
	CHECK(multi.noise < 2 * plain.noise + 1e-3);
	CHECK(std::abs(multi.imbalance) < 2e-3);
	CHECK(multi.points < plain.points / (ratio - 1.));
}

TEMPLATE_TEST_CASE_SIG("Multirate: a heap of slow and fast grains", "[multirate]", ((int dim), dim),
		       2, 3)
{
	Scene<dim> scene = heap<dim>(true), plain = heap<dim>(false);
	const double dt = 0.5 * scene.system.criticalTimeStep();
	const Vec<dim> before = scene.momentum();
	const int steps = (dim == 2 ? 150 : 40) * ratio;
	long points = 0;
	double start = 0, worst = 0, largest = 0;
	for (int k = 0; k < steps; ++k) {
		points += scene.advance(dt).work.points;
		plain.advance(dt);
		const double now = conserved(scene.system.energy());
		if (k == 1) start = now;
		if (k > 0) worst = std::max(worst, std::abs(now - start));
		largest = std::max(largest, scene.system.energy().elastic);
	}
	const double size = scene.whole(0).mass * 0.5;
	CHECK((scene.momentum() - before).norm() < 1e-12 * size);
	CHECK(largest > 0.01 * start); // they have met
	CHECK(scene.failures == 0);
	CAPTURE(worst / start);
	CHECK(worst < 0.02 * start);
	const int n = scene.system.timeSteps().rate(0); // 7, that of the smallest of the slow ones
	CHECK(scene.system.timeSteps().rate(4) == n);
	const int computed = 2 + (steps - 1) / n; // in the first two steps, then in every n-th
	CHECK(points == scene.batchOf(0).reference->points() * (2 * steps + 3 * computed));
	for (int g : { 0, 2, 4 }) {
		CAPTURE(g, scene.whole(g).velocity, plain.whole(g).velocity);
		CHECK((scene.whole(g).velocity - plain.whole(g).velocity).norm() < 0.02);
		CHECK((scene.whole(g).centre - plain.whole(g).centre).norm() < 5e-4 * R);
	}
}

TEST_CASE("Multirate: the same bits for any number of threads", "[multirate]")
{
	constexpr int heaps = 8; // enough for two threads and more
	Scene<2> one = heap<2>(true, heaps), four = heap<2>(true, heaps);
	four.settings.threads = 4;
	REQUIRE(threadsFor(four.system.grains(), 4) == 4);
	const double dt = 0.5 * one.system.criticalTimeStep();
	for (int k = 0; k < 500; ++k) {
		one.advance(dt);
		four.advance(dt);
	}
	CHECK(one.whole(0).velocity[0] < 0.45); // they have met
	CHECK(one.state() == four.state());
	CHECK(conserved(one.system.energy()) == conserved(four.system.energy()));
}

TEST_CASE("Multirate: grains with equal critical steps move as without, bit for bit", "[multirate]")
{
	auto run = [](bool multirate) {
		Scene<2> scene = sceneOf<2>({ grainAt<2>(Vec<2>(0, 0), R),
					      grainAt<2>(Vec<2>(1.9 * R, 0), 0.95 * R),
					      grainAt<2>(Vec<2>(R, 1.7 * R), 0.9 * R) },
					    multirate);
		scene.addPairs(0.3);
		for (int k = 0; k < 300; ++k)
			scene.advance();
		return scene.state();
	};
	CHECK(run(true) == run(false));
}

TEST_CASE("Multirate: rates fit into the critical steps and into each other", "[multirate]")
{
	std::vector<GrainParameters<2>> grains;
	Random random(4);
	for (int g = 0; g < 30; ++g) {
		const Damping damping { g % 3 ? 0. : 3000., g % 4 ? 0. : 1e-6 };
		grains.push_back(
			grainAt<2>(Vec<2>(g, 0), R * std::pow(30, random.uniform(-1, 0)), damping));
	}
	Scene<2> scene = sceneOf<2>(grains, false);
	const double dt = scene.system.criticalTimeStep();
	scene.system.setMultirate(true);
	CHECK(std::abs(scene.system.criticalTimeStep() / dt - 1) < 1e-8);
	int largest = 1;
	for (int g = 0; g < 30; ++g) {
		const double own =
			dampedTimeStep(scene.system.setOf(g).criticalTimeStep(scene.laneOf(g)),
				       grains[g].damping, 1, 1);
		const int rate = scene.system.timeSteps().rate(g);
		largest = std::max(largest, rate);
		CHECK(rate * dt <= own * (1 + 1e-8));
		CHECK(3 * rate * dt > own); // no more than the next multiple is left
		for (int h = 0; h < g; ++h) {
			const int other = scene.system.timeSteps().rate(h);
			CHECK(std::max(rate, other) % std::min(rate, other) == 0);
		}
	}
	CHECK(largest > 10);
	scene.system.setMultirate(false);
	for (int g = 0; g < 30; ++g)
		CHECK(scene.system.timeSteps().rate(g) == 1);
}

TEST_CASE("Multirate: velocities at the points are updated in every step", "[multirate]")
{
	for (const Scheme& scheme : { Scheme { Formulation::total, VelocityUpdate::flip },
				      Scheme { Formulation::updated } }) {
		Scene<2> scene;
		scene.add(grainsOf<2>(
			scheme, recipe(0.25),
			{ grainAt<2>(Vec<2>(0, 0), R), grainAt<2>(Vec<2>(1, 0), R / ratio) }));
		scene.system.setMultirate(true);
		CHECK(scene.system.timeSteps().rate(0) == 1);
		scene.advance();
	}
}

TEST_CASE("Multirate: goes on from its state in the middle of a long step", "[multirate]")
{
	for (const Damping& damping : { Damping {}, Damping { 300, 1e-6 } })
		for (int pause : { 1, 3, ratio, ratio + 5 }) {
			Random random(2);
			Scene<2> scene = slowGrain<2>(damping);
			makeNoisy(scene.batchOf(0), random);
			scene.system.invalidateForces();
			const double dt = 0.3 * scene.system.criticalTimeStep();
			for (int k = 0; k < pause; ++k)
				scene.advance(dt);
			Scene<2> next = slowGrain<2>(damping);
			for (int g = 0; g < 2; ++g)
				next.system.setOf(g).setState(g, scene.system.setOf(g).state(g));
			next.system.continueFrom(scene.system.continuation());
			for (int k = 0; k < 2 * ratio; ++k) {
				scene.advance(dt);
				next.advance(dt);
				CHECK(scene.state() == next.state());
				CHECK(conserved(scene.system.energy()) ==
				      conserved(next.system.energy()));
			}
		}
}

TEST_CASE("Multirate: forces turn with a grain that is turned", "[multirate]")
{
	Scene<2> scene = slowGrain<2>();
	deform<2>(scene.batchOf(0), 0, (Mat<2>() << 1.1, 0, 0, 0.9).finished());
	scene.system.invalidateForces();
	const double dt = 0.5 * scene.system.criticalTimeStep();
	for (int k = 0; k < ratio + 3; ++k)
		scene.advance(dt);
	const Mat<2> turn = Eigen::Rotation2Dd(0.7).toRotationMatrix();
	scene.system.setOf(0).moveRigidly(0, turn, Vec<2>::Zero(), Vec<2>::Zero(), Mat<2>::Zero());
	scene.system.invalidateForces();
	const double before = scene.whole(0).angularMomentum[0];
	for (int k = ratio + 3; k < 3 * ratio; ++k)
		scene.advance(dt);
	const auto whole = scene.whole(0);
	const double size = whole.mass * R * 60; // a vibration at some per cent of the wave speed
	CHECK(std::abs(whole.angularMomentum[0] - before) < 1e-12 * size);
}

TEST_CASE("Multirate: switched off in the middle of a long step", "[multirate]")
{
	Scene<2> scene = heap<2>(true), plain = heap<2>(false);
	const double dt = 0.5 * scene.system.criticalTimeStep();
	for (int k = 0; k < 2 * ratio + 3; ++k)
		scene.advance(dt);
	scene.system.setMultirate(false);
	const long points = plain.advance(dt).work.points;
	for (int k = 0; k < 3; ++k)
		CHECK(scene.advance(dt).work.points == points);
}
