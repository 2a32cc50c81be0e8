// The formulations beside the default one: velocities at the points ('flip') and updated
// Lagrangian. What they conserve and what they lose is written down in
// doc/decisions/0005-formulations.md.
#include "step/Formulations.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

double largestStress(const GrainSet<2>& set)
{
	double largest = 0;
	for (const auto& point : set.points(0))
		largest = std::max(largest, point.cauchy.norm());
	return largest;
}

double meanStress(const GrainSet<2>& set)
{
	double squares = 0, volume = 0;
	for (const auto& point : set.points(0)) {
		squares += point.volume * point.cauchy.squaredNorm();
		volume += point.volume;
	}
	return std::sqrt(squares / volume);
}

/// Angular frequency of the n = 2 mode of the paper's disk by Lamb.
const double lambFrequency = 2.3525 * std::sqrt(paperGrain<2>().constants.mu() / 1000) / 0.01;
const double period = 2 * std::numbers::pi / lambFrequency;

struct Vibration {
	double kept;      ///< energy after four periods over that at the start
	double frequency; ///< over that of Lamb, minus 1
};

Vibration vibrate(const Scheme& scheme, double turn = 0)
{
	auto set = grainsOf<2>(scheme, recipe(0.11));
	const Mat<2> Q = Eigen::Rotation2Dd(turn).toRotationMatrix();
	set->place(0, Q, Vec<2>::Zero(), Mat<2>::Zero());
	setVelocities<2>(*set, [&](const Vec<2>& x) {
		return Vec<2>(1e-3 * lambFrequency * Vec<2>(x[0], -x[1]));
	});
	Scene<2> scene;
	scene.settings.trackEnergy = true;
	scene.add(std::move(set));
	const double dt = 0.5 * scene.system.criticalTimeStep();
	auto stretch = [&] {
		double sum = 0;
		for (const auto& point : scene.system.setOf(0).points(0))
			sum += point.volume * (point.position[0] * point.position[0] -
					       point.position[1] * point.position[1]);
		return sum;
	};
	double start = 0, last = stretch(), crossing = 0;
	int crossings = 0;
	Vibration result {};
	while (scene.time < 4 * period) {
		scene.advance(dt);
		const EnergyBalance& e = scene.system.energy();
		if (scene.steps == 1) start = stored(e);
		result.kept = stored(e) / start;
		const double now = stretch();
		if (last > 0 && now <= 0) { // after 1/2, 3/2 ... periods
			crossing = scene.time - dt * now / (now - last);
			++crossings;
		}
		last = now;
	}
	result.frequency = (crossings - 0.5) * period / crossing - 1;
	return result;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Formulations: a free grain keeps its linear momentum to rounding", "[step]",
		       ((int dim), dim), 2, 3)
{
	for (Scheme scheme : { flip, updated })
		for (double picShare : { 0., 0.2 }) {
			CAPTURE(static_cast<int>(scheme.formulation), picShare);
			scheme.picShare = picShare;
			auto set = grainsOf<dim>(scheme, recipe(dim == 2 ? 0.2 : 0.4));
			Random random(1);
			const Vec<dim> mean = random.vector<dim>();
			setVelocities<dim>(*set, [&](const Vec<dim>&) {
				return Vec<dim>(mean + random.vector<dim>(0.5));
			});
			Scene<dim> scene;
			scene.courant = 0.3; // the noise is a strong motion
			scene.add(std::move(set));
			const auto before = scene.whole(0);
			for (int n = 0; n < 200; ++n)
				scene.advance();
			const auto after = scene.whole(0);
			CHECK((after.velocity - before.velocity).norm() <
			      1e-12 * before.velocity.norm());
			if (scheme.formulation ==
			    Formulation::updated) // its masses are the points'
				CHECK((after.centre - before.centre - scene.time * before.velocity)
					      .norm() < 1e-3 * scene.time * before.velocity.norm());
		}
}

TEMPLATE_TEST_CASE_SIG("Formulations: a rigid translation over several cells is exact", "[step]",
		       ((int dim), dim), 2, 3)
{
	for (const Scheme& scheme : { flip, updated }) {
		auto set = grainsOf<dim>(scheme, recipe(dim == 2 ? 0.2 : 0.4));
		Vec<dim> velocity = Vec<dim>::Constant(0.7);
		velocity[0] = 1.3;
		Random random(2);
		const Mat<dim> Q = random.rotation<dim>();
		set->place(0, Q, velocity, Mat<dim>::Zero());
		const GrainState before = set->state(0);
		Scene<dim> scene;
		scene.add(std::move(set));
		for (int n = 0; n < 600; ++n)
			scene.advance(0.5 * scene.system.criticalTimeStep());
		CHECK(scene.time * velocity[0] > 0.02); // the spacing of nodes is 4 or 8 mm
		const GrainState after = scene.system.setOf(0).state(0);
		double x = 0, v = 0, F = 0;
		for (std::size_t k = 0; k < before.x.size(); ++k)
			x = std::max(x, std::abs(after.x[k] - before.x[k] -
						 scene.time * velocity[k % dim]));
		for (std::size_t k = 0; k < before.v.size(); ++k)
			v = std::max(v, std::abs(after.v[k] - before.v[k]));
		for (std::size_t k = 0; k < before.F.size(); ++k)
			F = std::max(F, std::abs(after.F[k] - before.F[k]));
		CAPTURE(x, v, F);
		CHECK(x < 1e-12);
		CHECK(v < 1e-11);
		CHECK(F < 1e-11);
	}
}

namespace {

/// Updated Lagrangian, anywhere in space, with the velocities L (x - x_c).
template <int dim> Scene<dim> homogeneousMotion(const Mat<dim>& L)
{
	auto set = grainsOf<dim>(updated, recipe(dim == 2 ? 0.05 : 0.12));
	set->moveRigidly(0, Mat<dim>::Identity(), Vec<dim>::LinSpaced(0.002, 0.007),
			 Vec<dim>::Zero(), Mat<dim>::Zero());
	const Vec<dim> centre = set->whole(0).centre;
	setVelocities<dim>(*set, [&](const Vec<dim>& x) { return Vec<dim>(L * (x - centre)); });
	Scene<dim> scene;
	scene.settings.rigidMotion = false;
	scene.settings.trackEnergy = true;
	scene.add(std::move(set));
	return scene;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Formulations: inner points take the gradient of a linear motion", "[step]",
		       ((int dim), dim), 2, 3)
{
	Random random(3);
	for (int n = 0; n < (dim == 2 ? 3 : 1); ++n) {
		const Mat<dim> L = random.matrix<dim>(50);
		Scene<dim> scene = homogeneousMotion<dim>(L);
		const Vec<dim> centre = scene.whole(0).centre;
		const double dt = 0.01 * scene.system.criticalTimeStep();
		scene.advance(dt);
		int inside = 0;
		double worst = 0;
		for (const auto& point : scene.system.setOf(0).points(0)) {
			if ((point.position - centre).norm() > 0.4 * 0.01) continue;
			const Mat<dim> F = Mat<dim>::Identity() + dt * L;
			worst = std::max(worst, (point.F - F).norm());
			++inside;
		}
		CAPTURE(worst / (dt * L.norm()));
		CHECK(inside > 30);
		CHECK(worst < 0.05 * dt * L.norm());
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: a vibration by updated Lagrangian gains no energy", "[step]",
		       ((int dim), dim), 2, 3)
{
	Random random(4);
	Scene<dim> scene = homogeneousMotion<dim>(random.matrix<dim>(50));
	const double dt = 0.5 * scene.system.criticalTimeStep();
	double start = 0, largest = 0, elastic = 0;
	for (int n = 0; n < (dim == 2 ? 300 : 150); ++n) {
		scene.advance(dt);
		const EnergyBalance& e = scene.system.energy();
		if (n == 0) start = stored(e);
		largest = std::max(largest, stored(e));
		elastic = std::max(elastic, e.elastic);
	}
	CAPTURE(largest / start, elastic / start);
	CHECK(elastic > 0.1 * start);
	CHECK(largest < 1.01 * start);
}

TEST_CASE("Formulations: what they lose in free vibration", "[step]")
{
	const Vibration a = vibrate(nodal), b = vibrate(flip), c = vibrate(updated),
			d = vibrate(updated, 0.4);
	CAPTURE(a.kept, a.frequency, b.kept, b.frequency, c.kept, c.frequency, d.kept, d.frequency);
	CHECK(std::abs(a.kept - 1) < 1e-4);
	CHECK(std::abs(a.frequency + 0.027) < 0.005); // diagonal mass
	// Velocities that pass by the points are smoothed in every step: slower, and damped.
	CHECK(std::abs(b.kept - 0.36) < 0.03);
	CHECK(std::abs(b.frequency + 0.09) < 0.01);
	// At small strain both formulations are the same method.
	CHECK(std::abs(c.kept / b.kept - 1) < 1e-2);
	CHECK(std::abs(c.frequency - b.frequency) < 1e-3);
	CHECK(std::abs(d.kept / b.kept - 1) < 0.05); // another place of the grid
	CHECK(std::abs(d.frequency - b.frequency) < 0.02);
}

TEST_CASE("Formulations: a turned grain is not strained, a spinning one hardly", "[step]")
{
	for (const Scheme& scheme : { flip, updated }) {
		auto turned = grainsOf<2>(scheme, recipe(0.2));
		turned->place(0, Eigen::Rotation2Dd(0.7).toRotationMatrix(), Vec<2>::Zero(),
			      Mat<2>::Zero());
		CHECK(largestStress(*turned) < 1e-7);
		// A tenth of a turn; centrifugal stress is 1e-5 E.
		std::vector<double> stress, lost;
		for (double zeta : { 0.2, 0.1, 0.05 }) {
			auto set = grainsOf<2>(scheme, recipe(zeta));
			set->place(0, Mat<2>::Identity(), Vec<2>::Zero(), spinAbout<2>(10));
			Scene<2> scene;
			scene.settings.rigidMotion = false;
			scene.add(std::move(set));
			const double before = scene.whole(0).angularMomentum[0];
			const double dt = 0.5 * scene.system.criticalTimeStep();
			while (scene.time < 0.2 * std::numbers::pi / 10)
				scene.advance(dt);
			stress.push_back(meanStress(scene.system.setOf(0)) / 1e6);
			lost.push_back(1 - scene.whole(0).angularMomentum[0] / before);
		}
		CAPTURE(stress, lost);
		CHECK(stress[0] < 2e-4);
		CHECK(stress[1] < 0.6 * stress[0]);
		CHECK(stress[2] < 0.8 * stress[1]);
		CHECK(lost[0] < 0.2);
		CHECK(lost[1] < 0.5 * lost[0]);
		CHECK(lost[2] < 0.5 * lost[1]);
		CHECK(lost[2] > 0); // these mappings do lose angular momentum
	}
}

TEST_CASE("Formulations: force of a disk between planes", "[step]")
{
	// Against finite elements, at delta/D = 0.1 with the force averaged over a window.
	const double R = 0.01, speed = 0.1, expected = 0.04921 * 1e6 * 2 * R;
	for (const Scheme& scheme : { nodal, flip, updated }) {
		Scene<2> scene;
		scene.settings.trackEnergy = true;
		scene.add(grainsOf<2>(scheme, recipe(0.1)));
		scene.addPlane(0, { 0, -R }, { 0, 1 }, { 0, 0.5 * speed });
		scene.addPlane(0, { 0, R }, { 0, -1 }, { 0, -0.5 * speed });
		double impulse = 0, span = 0;
		while (scene.time * speed < 0.106 * 2 * R) {
			const double start = scene.time;
			scene.advance();
			if (start * speed < 0.094 * 2 * R) continue;
			span += scene.time - start;
			for (const ContactList<2>& list : scene.lists)
				for (const Contact<2>& c : list.contacts)
					impulse += 0.5 * c.impulse.norm();
		}
		const double error = impulse / span / expected - 1;
		const EnergyBalance& e = scene.system.energy();
		const double lost = (e.walls - e.impact - e.kinetic - e.elastic) / e.walls;
		CAPTURE(static_cast<int>(scheme.formulation), error, lost, scene.deepest);
		CHECK(std::abs(error) < 0.02);
		CHECK(std::abs(lost) < 0.02);
		CHECK(scene.deepest < 0.1);
		CHECK(scene.failures == 0);
	}
}

TEST_CASE("Formulations: critical step separates stable from unstable", "[step]")
{
	for (const Scheme& scheme : { flip, updated }) {
		auto grows = [&](double courant) {
			auto set = grainsOf<2>(scheme, recipe(0.2));
			Random random(1);
			setVelocities<2>(*set,
					 [&](const Vec<2>&) { return random.vector<2>(1e-6); });
			Scene<2> scene;
			scene.settings.trackEnergy = true;
			scene.settings.rigidMotion = false; // so little is dropped as rounding
			scene.add(std::move(set));
			const double dt = courant * scene.system.criticalTimeStep();
			try {
				scene.advance(dt);
				const double noise = scene.system.energy().kinetic;
				for (int n = 0; n < 1000; ++n) {
					scene.advance(dt);
					if (scene.system.energy().elastic > 1e4 * noise)
						return true;
				}
			} catch (const StepError&) { // so large that a point is inverted
				return true;
			}
			return false;
		};
		CHECK(!grows(0.98));
		CHECK(grows(1.45));
	}
}
