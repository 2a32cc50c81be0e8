// The formulations beside the default one: velocities at the points ('flip') and updated
// Lagrangian. What they conserve and what they lose is written down in
// doc/decisions/0005-formulations.md.
#include "step/Scene.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

const Scheme nodal {}, flip { Formulation::total, VelocityUpdate::flip, 0 },
	updated { Formulation::updated, VelocityUpdate::nodal, 0 };

template <int dim>
std::unique_ptr<GrainSet<dim>>
grainsOf(const Scheme& scheme, const TemplateRecipe& r,
	 const std::vector<GrainParameters<dim>>& grains = { paperGrain<dim>() })
{
	return makeGrainSet<dim>(makeGrainTemplate<dim>(r), Law::neoHookean, usualCondition<dim>,
				 grains, scheme);
}

template <int dim> Mat<dim> spinAbout(double rate)
{
	Mat<dim> spin = Mat<dim>::Zero();
	spin(0, 1) = -rate;
	spin(1, 0) = rate;
	return spin;
}

/// Whatever the formulation keeps, as a field of velocities of the present places.
template <int dim, class Field> void setVelocities(GrainSet<dim>& set, const Field& field)
{
	GrainState s = set.state(0);
	std::vector<Vec<dim>> places;
	const bool atNodes =
		s.F.empty() && s.v.size() == s.x.size(); // else at the points, then contact nodes
	if (atNodes)
		places = set.nodePositions(0);
	else
		for (const auto& point : set.points(0))
			places.push_back(point.position);
	for (std::size_t k = places.size(); k < s.v.size() / dim; ++k)
		places.push_back(Eigen::Map<const Vec<dim>>(&s.x[k * dim]));
	for (std::size_t k = 0; k < places.size(); ++k)
		Eigen::Map<Vec<dim>>(&s.v[k * dim]) = field(places[k]);
	set.setState(0, s);
}

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
		if (scene.steps == 1) start = e.kinetic + e.elastic;
		result.kept = (e.kinetic + e.elastic) / start;
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

TEST_CASE("Formulations: what they lose in free vibration", "[step]")
{
	const Vibration a = vibrate(nodal), b = vibrate(flip), c = vibrate(updated),
			d = vibrate(updated, 0.4);
	CAPTURE(a.kept, a.frequency, b.kept, b.frequency, c.kept, c.frequency, d.kept, d.frequency);
	CHECK(std::abs(a.kept - 1) < 1e-4);
	CHECK(std::abs(a.frequency + 0.04) < 0.01); // lumped mass
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

TEMPLATE_TEST_CASE_SIG("Formulations: contact velocities answer to impulses as W_ss' says",
		       "[step]", ((int dim), dim), 2, 3)
{
	Random random(3);
	auto set = grainsOf<dim>(updated, recipe(dim == 2 ? 0.2 : 0.45));
	set->place(0, random.rotation<dim>(), random.vector<dim>(), Mat<dim>::Zero());
	set->moveRigidly(0, Mat<dim>::Identity(), random.vector<dim>(0.01), Vec<dim>::Zero(),
			 Mat<dim>::Zero());
	set->updateForces({});
	set->predictVelocities(0, 1e-5, {});
	const ContactMobility<dim> W = set->contactMobility(0);
	std::vector<Vec<dim>> before, after;
	set->contactVelocities(0, before);
	const int nodes = set->reference().contactNodes();
	std::vector<Vec<dim>> impulse(nodes, Vec<dim>::Zero()), expected(nodes, Vec<dim>::Zero());
	for (int n = 0; n < 5; ++n) {
		const int s = random.index(nodes);
		const Vec<dim> J = random.vector<dim>(1e-4);
		impulse[s] += J;
		for (int k = W.table->begin(s); k < W.table->end(s); ++k)
			expected[W.table->column[k]] += W.scale * W.table->value[k] * J;
	}
	set->applyContactImpulses(0, impulse);
	set->contactVelocities(0, after);
	double error = 0, largest = 0;
	for (int s = 0; s < nodes; ++s) {
		error = std::max(error, (after[s] - before[s] - expected[s]).norm());
		largest = std::max(largest, expected[s].norm());
	}
	CHECK(largest > 0);
	CHECK(error < 1e-12 * largest);
}

TEST_CASE("Formulations: mobility of contact nodes stays bounded wherever the grid lies", "[step]")
{
	const auto reference = makeGrainTemplate<2>(recipe(0.1));
	double usual = 0;
	for (int s = 0; s < reference->contactNodes(); ++s)
		for (int k = reference->delassus.begin(s); k < reference->delassus.end(s); ++k)
			if (reference->delassus.column[k] == s)
				usual = std::max(usual, reference->delassus.value[k]);
	usual /= 1000 * 1e-4; // of the total-Lagrangian grain
	Random random(4);
	double largest = 0;
	for (int n = 0; n < 200; ++n) {
		auto set = grainsOf<2>(updated, recipe(0.1));
		set->place(0, random.rotation<2>(), Vec<2>::Zero(), Mat<2>::Zero());
		set->moveRigidly(0, Mat<2>::Identity(), random.vector<2>(0.01), Vec<2>::Zero(),
				 Mat<2>::Zero());
		set->updateForces({});
		const ContactMobility<2> W = set->contactMobility(0);
		for (int s = 0; s < W.table->rows(); ++s)
			for (int k = W.table->begin(s); k < W.table->end(s); ++k)
				if (W.table->column[k] == s) {
					CHECK(W.table->value[k] > 0);
					largest = std::max(largest, W.table->value[k]);
				}
	}
	CAPTURE(largest / usual);
	CHECK(largest < 3 * usual);
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
		const double lost = (e.planes - e.impact - e.kinetic - e.elastic) / e.planes;
		CAPTURE(static_cast<int>(scheme.formulation), error, lost, scene.deepest);
		CHECK(std::abs(error) < 0.02);
		CHECK(std::abs(lost) < 0.02);
		CHECK(scene.deepest < 0.1);
		CHECK(scene.failures == 0);
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: same bits with any number of threads, and after a save",
		       "[step]", ((int dim), dim), 2, 3)
{
	const int count = dim == 2 ? 11 : 3; // in 2D more than a block of lanes
	std::vector<GrainParameters<dim>> grains(count, paperGrain<dim>());
	for (int g = 0; g < count; ++g)
		grains[g].origin = 0.0195 * g * Vec<dim>::Unit(0);
	for (const Scheme& scheme : { flip, updated }) {
		auto start = [&](int threads) {
			Scene<dim> scene;
			scene.settings.threads = threads;
			auto set = grainsOf<dim>(scheme, recipe(dim == 2 ? 0.25 : 0.45), grains);
			set->place(0, Mat<dim>::Identity(), Vec<dim>::Unit(0), spinAbout<dim>(50));
			scene.add(std::move(set));
			scene.addPairs(0.3);
			return scene;
		};
		Scene<dim> one = start(1), two = start(2), loaded = start(1);
		for (int n = 0; n < 40; ++n) {
			one.advance(2e-5);
			two.advance(2e-5);
			if (n != 19) continue;
			for (int g = 0; g < count; ++g)
				loaded.system.setOf(g).setState(g, one.system.setOf(g).state(g));
			loaded.lists = one.lists;
			loaded.system.continueFrom(one.system.continuation());
			loaded.system.updateSurfaces(1);
		}
		for (int n = 0; n < 20; ++n)
			loaded.advance(2e-5);
		CHECK(two.state() == one.state());
		CHECK(loaded.state() == one.state());
		CHECK(one.whole(1).velocity.norm() > 0.01); // they did meet
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: moving a grain rigidly moves all of it", "[step]",
		       ((int dim), dim), 2, 3)
{
	Random random(5);
	for (const Scheme& scheme : { nodal, flip, updated }) {
		auto set = grainsOf<dim>(scheme, recipe(0.4));
		const Mat<dim> Q = random.rotation<dim>(), turn = random.rotation<dim>();
		const Vec<dim> velocity = random.vector<dim>(), shift = random.vector<dim>(),
			       push = random.vector<dim>();
		set->place(0, Q, velocity, spinAbout<dim>(20));
		std::vector<Vec<dim>> before, after;
		set->contactPositions(0, before);
		const auto whole = set->whole(0);
		set->moveRigidly(0, turn, shift, push, spinAbout<dim>(30));
		set->contactPositions(0, after);
		for (std::size_t s = 0; s < before.size(); ++s)
			CHECK((after[s] - whole.centre - shift - turn * (before[s] - whole.centre))
				      .norm() < 1e-14);
		const auto moved = set->whole(0);
		CHECK((moved.velocity - turn * whole.velocity - push).norm() < 1e-13);
		CHECK((moved.rotation - turn * whole.rotation).norm() < 1e-12);
		CHECK((moved.centre - whole.centre - shift).norm() < 1e-14);
		set->updateForces({});
		CHECK(set->report(0).elasticEnergy < 1e-12);
		for (const auto& point : set->points(0))
			CHECK((point.F - turn * Q).norm() < 1e-11);
	}
}

TEMPLATE_TEST_CASE_SIG("Formulations: a load gives its momentum and its torque", "[step]",
		       ((int dim), dim), 2, 3)
{
	for (const Scheme& scheme : { nodal, flip, updated }) {
		Scene<dim> scene;
		scene.settings.trackEnergy = true;
		scene.add(grainsOf<dim>(scheme, recipe(0.3)));
		BodyLoad<dim>& load = scene.system.loads()[0];
		load.acceleration = Vec<dim>::Constant(3);
		load.angular = spinAbout<dim>(50);
		const auto before = scene.whole(0);
		const double dt = 1e-6;
		scene.advance(dt);
		scene.advance(dt);
		const auto after = scene.whole(0);
		const int z = static_cast<int>(after.angularMomentum.size()) - 1;
		const double torque = 50 * before.inertia(z, z);
		CAPTURE(static_cast<int>(scheme.formulation), after.angularMomentum[z],
			2 * torque * dt);
		CHECK((after.velocity - 2 * dt * load.acceleration).norm() < 1e-13);
		CHECK(std::abs(after.angularMomentum[z] / (2 * torque * dt) - 1) < 1e-3);
		CHECK(scene.system.energy().loads > 0);
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

TEST_CASE("Formulations: a grain that has fallen apart stops the step", "[step]")
{
	for (double place : { 1., -1e300, std::numeric_limits<double>::quiet_NaN() }) {
		auto set = grainsOf<2>(updated, recipe(0.3));
		GrainState s = set->state(0);
		s.x[2 * 5 + 1] = place; // of the sixth point
		set->setState(0, s);
		Scene<2> scene;
		scene.add(std::move(set));
		try {
			scene.advance(1e-6);
			FAIL("no StepError");
		} catch (const StepError& error) {
			CHECK(error.grain == 0);
			CHECK(error.point == 5);
		}
	}
}

TEST_CASE("Formulations: inadmissible schemes are named", "[step]")
{
	auto complaint = [](Scheme scheme, int order) {
		return complaintOf([&] { grainsOf<2>(scheme, recipe(0.4, order)); });
	};
	CHECK(complaint(updated, 2) == "");
	CHECK(complaint(updated, 1).find("order = 1 ") == 0);
	Scheme share = flip;
	share.picShare = 1;
	CHECK(complaint(share, 1) == "");
	share.picShare = 1.1;
	CHECK(complaint(share, 3).find("picShare = 1.1 ") == 0);
	share.picShare = std::numeric_limits<double>::quiet_NaN();
	CHECK(complaint(share, 3).find("picShare = nan ") == 0);
	share = nodal;
	share.picShare = 0.1;
	CHECK(complaint(share, 3).find("picShare = 0.1 ") == 0);
	auto set = grainsOf<2>(flip, recipe(0.4));
	const GrainState wrong = grainsOf<2>(nodal, recipe(0.4))->state(0);
	CHECK(complaintOf([&] { set->setState(0, wrong); }).find("saved velocities") !=
	      std::string::npos);
}
