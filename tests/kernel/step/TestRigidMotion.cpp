// Grains that are undeformed and untouched move as rigid bodies.
#include "Threads.hpp"
#include "step/Batches.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Congruent templates, radii and materials of their own.
template <int dim> Batch<dim> motleyAt(const TemplateRecipe& r, const std::vector<Vec<dim>>& places)
{
	return grainsAt<dim>(r, places, [](GrainParameters<dim>& grain, std::size_t g) {
		grain.radius *= 1 - 0.1 * (g % 3);
	});
}

template <int dim> Spin<dim> spinOf(double rate)
{
	Spin<dim> omega = Spin<dim>::Zero();
	omega[omega.size() - 1] = rate;
	if (dim == 3) omega[0] = 0.6 * rate;
	return omega;
}

template <int dim> Mat<dim> turnOf(const Spin<dim>& angle)
{
	if constexpr (dim == 2)
		return Eigen::Rotation2Dd(angle[0]).toRotationMatrix();
	else
		return Eigen::AngleAxisd(angle.norm(), angle.normalized()).toRotationMatrix();
}

template <int dim> Mat<dim> rotationBy(double angle)
{
	return turnOf<dim>(angle * spinOf<dim>(1).normalized());
}

template <int dim>
void launch(Batch<dim>& batch, int g, const Vec<dim>& velocity, double rate, double turn = 0)
{
	batch.place(g, rotationBy<dim>(turn), velocity, spinMatrix<dim>(spinOf<dim>(rate)));
}

TemplateRecipe brick(int dim, double zeta)
{
	TemplateRecipe r = recipe(zeta);
	r.form.form = Form::block;
	r.form.aspect = { 2.3, 1, dim == 2 ? 1. : 1.4 };
	return r;
}

/// Three grains in a row, the outer ones thrown at the one in the middle, obliquely; or several
/// such rows. With velocities at points the nodal cycle loses spin, so there is nothing to compare
/// with: no spin.
template <int dim> Scene<dim> threeThatMeet(bool rigid, const Scheme& scheme = {}, int rows = 1)
{
	const Vec<dim> apart = 0.021 * Vec<dim>::Unit(0), up = 0.004 * Vec<dim>::Unit(1);
	TemplateRecipe r = recipe(dim == 2 ? 0.2 : 0.35);
	r.lumping = scheme.lumping();
	std::vector<Vec<dim>> places;
	for (int row = 0; row < rows; ++row) {
		const Vec<dim> middle = 0.04 * row * Vec<dim>::Unit(dim - 1);
		places.insert(places.end(), { middle, middle + apart, middle - apart + up });
	}
	auto batch = motleyAt<dim>(r, places);
	const double spin = scheme.hasPointVelocities() ? 0 : 1;
	for (int g = 0; g < 3 * rows; g += 3) {
		launch<dim>(batch, g, Vec<dim>::Zero(), 3 * spin);
		launch<dim>(batch, g + 1, -1.0 * Vec<dim>::Unit(0), -20 * spin);
		launch<dim>(batch, g + 2, 0.8 * Vec<dim>::Unit(0), 10 * spin);
	}
	Scene<dim> scene;
	scene.settings.rigidMotion = rigid;
	scene.settings.trackEnergy = true;
	scene.add(std::make_unique<TotalLagrangian<dim>>(std::move(batch), scheme));
	scene.addPairs(0.3, [](int a, int b) { return a / 3 == b / 3; });
	return scene;
}

/// Angular momentum of all grains about the origin of space.
template <int dim> Spin<dim> angularMomentum(const Scene<dim>& scene)
{
	Spin<dim> sum = Spin<dim>::Zero();
	for (int g = 0; g < scene.system.grains(); ++g) {
		const auto w = scene.whole(g);
		const Vec<dim> place =
			scene.system.setOf(g).parameters(scene.laneOf(g)).origin + w.centre;
		sum += w.angularMomentum + w.mass * moment<dim>(place, w.velocity);
	}
	return sum;
}

template <int dim> int rigidGrains(const Scene<dim>& scene)
{
	int count = 0;
	for (int g = 0; g < scene.system.grains(); ++g)
		count += scene.system.isRigid(g);
	return count;
}

template <int dim>
double largestDifference(const std::vector<Vec<dim>>& a, const std::vector<Vec<dim>>& b)
{
	double largest = 0;
	for (std::size_t k = 0; k < a.size(); ++k)
		largest = std::max(largest, (a[k] - b[k]).norm());
	return largest;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Rigid motion: free flight is exact and costs no grain-step", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	auto batch = motleyAt<dim>(recipe(0.35), { Vec<dim>::Zero() });
	const Vec<dim> velocity = Vec<dim>::LinSpaced(1, 2);
	const double rate = 20;
	launch<dim>(batch, 0, velocity, rate, 0.3);
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(std::move(batch));
	const auto before = scene.whole(0);
	int active = 0;
	for (int n = 0; n < 2000; ++n)
		active += scene.advance(3e-5).activeGrains;
	CHECK(active == 0);
	const auto after = scene.whole(0);
	CHECK((after.centre - before.centre - scene.time * velocity).norm() <
	      1e-12 * scene.time * velocity.norm());
	CHECK((after.velocity - velocity).norm() < 1e-12);
	CHECK((after.angularMomentum - before.angularMomentum).norm() <
	      1e-12 * before.angularMomentum.norm());
	CHECK(std::abs(after.mass / before.mass - 1) < 1e-12);
	CHECK((after.inertia - before.inertia).norm() < 1e-9 * before.inertia.norm());
	// what it shows is what its nodes say
	const Mat<dim> turn = turnOf<dim>(scene.time * spinOf<dim>(rate)) * rotationBy<dim>(0.3);
	CHECK((after.rotation - turn).norm() < 1e-9);
	const double R = 0.01;
	const auto& reference = scene.system.setOf(0).reference();
	const auto nodes = scene.system.setOf(0).nodePositions(0);
	const auto velocities = scene.system.setOf(0).nodeVelocities(0);
	double away = 0, faster = 0;
	for (int I = 0; I < reference.nodes(); ++I) {
		const Vec<dim> arm = R * (turn * reference.nodePosition[I]);
		away = std::max(away, (nodes[I] - scene.time * velocity - arm).norm());
		const Vec<dim> v = velocity + spinMatrix<dim>(spinOf<dim>(rate)) * arm;
		faster = std::max(faster, (velocities[I] - v).norm());
	}
	CHECK(away < 1e-9 * R);
	CHECK(faster < 1e-9 * rate * R);
	std::vector<Vec<dim>> surface;
	for (const Vec<dim>& X : reference.contactMesh.vertex)
		surface.push_back(scene.time * velocity + R * (turn * X));
	CHECK(largestDifference<dim>(scene.system.body(0).position, surface) < 1e-9 * R);
	for (const auto& point : scene.system.setOf(0).points(0))
		CHECK((point.F - turn).norm() < 1e-9);
	const double kinetic = 0.5 * before.mass * velocity.squaredNorm() +
			       0.5 * before.angularMomentum.dot(before.angularVelocity);
	CHECK(std::abs(scene.system.energy().kinetic / kinetic - 1) < 1e-9);
	CHECK(scene.system.energy().elastic == 0);
}

TEST_CASE("Rigid motion: a tumbling brick keeps angular momentum and energy", "[rigid]")
{
	auto run = [](double dt) {
		auto batch = motleyAt<3>(brick(3, 0.4), { Vec<3>::Zero() });
		batch.place(0, Mat<3>::Identity(), Vec<3>::Zero(), spinMatrix<3>({ 5, 12, 8 }));
		Scene<3> scene;
		scene.settings.trackEnergy = true;
		scene.add(std::move(batch));
		const auto before = scene.whole(0);
		double first = 0, drift = 0;
		for (int n = 0; n < std::lround(1 / dt); ++n) { // some two turns
			scene.advance(dt);
			const double energy = scene.system.energy().kinetic;
			if (scene.steps == 1) first = energy;
			drift = std::max(drift, std::abs(energy / first - 1));
		}
		const auto after = scene.whole(0);
		CHECK((after.angularMomentum - before.angularMomentum).norm() <
		      1e-12 * before.angularMomentum.norm());
		CHECK((after.angularVelocity - before.angularVelocity).norm() >
		      0.3); // it does tumble
		CHECK((after.rotation.transpose() * after.rotation - Mat<3>::Identity()).norm() <
		      1e-13);
		CHECK(rigidGrains(scene) == 1);
		return std::make_pair(drift, after.rotation);
	};
	const auto coarse = run(4e-3), middle = run(2e-3), fine = run(5e-4);
	CAPTURE(coarse.first, middle.first, fine.first);
	CHECK(coarse.first < 1e-3);
	CHECK(middle.first < 0.3 * coarse.first); // second order
	const double error = (coarse.second - fine.second).norm(),
		     half = (middle.second - fine.second).norm();
	CAPTURE(error, half);
	CHECK(half < 0.3 * error);
}

TEMPLATE_TEST_CASE_SIG("Rigid motion: body loads, and the energy they bring", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.add(motleyAt<dim>(brick(dim, 0.35), { Vec<dim>::Zero() }));
	const Vec<dim> g = -9.81 * Vec<dim>::Unit(1);
	Spin<dim> alpha = Spin<dim>::Zero();
	alpha[alpha.size() - 1] = 50; // about a principal axis
	scene.system.loads()[0] = { g, spinMatrix<dim>(alpha) };
	for (int n = 0; n < 300; ++n)
		CHECK(scene.advance(3e-5).activeGrains == 0);
	const auto whole = scene.whole(0);
	CHECK((whole.velocity - scene.time * g).norm() < 1e-12 * scene.time * g.norm());
	CHECK((whole.angularVelocity - scene.time * alpha).norm() <
	      1e-9 * scene.time * alpha.norm());
	const EnergyBalance& e = scene.system.energy();
	CHECK(e.loads > 0);
	CHECK(std::abs(e.kinetic - e.loads) < 1e-9 * e.loads);
}

TEMPLATE_TEST_CASE_SIG(
	"Rigid motion: woken before the first contact, momenta kept, results as without", "[rigid]",
	((int dim), dim), 2, 3)
{
	for (const Scheme& scheme :
	     { Scheme {}, Scheme { Formulation::total, VelocityUpdate::flip, 0 } }) {
		Scene<dim> with = threeThatMeet<dim>(true, scheme),
			   without = threeThatMeet<dim>(false, scheme);
		const Vec<dim> momentum = with.momentum();
		const auto angular = angularMomentum(with);
		const double dt = 0.4 * with.system.criticalTimeStep();
		int activeWith = 0, activeWithout = 0;
		double firstGap = -1;
		const bool flip = scheme.hasPointVelocities();
		const int steps = flip ? 240 : 160;
		for (int n = 0; n < steps; ++n) {
			const int rigidBefore = rigidGrains(with);
			activeWith += with.advance(dt).activeGrains;
			activeWithout += without.advance(dt).activeGrains;
			if (n > 0 && rigidGrains(with) < rigidBefore && firstGap < 0)
				for (const auto& list : with.lists)
					for (const auto& contact : list.contacts) {
						firstGap = contact.gap;
						CHECK(contact.gap > 0);
					}
			if (n == 0) CHECK(rigidGrains(with) == 3);
		}
		CHECK(firstGap > 0); // woken by a contact in reach, not yet closed
		CHECK(rigidGrains(with) == 0);
		CHECK(rigidGrains(without) == 0);
		CHECK(activeWithout == 3 * steps);
		CHECK(activeWith < 2.6 * steps);
		CHECK(activeWith > 30);
		CHECK((with.momentum() - momentum).norm() < 1e-12 * momentum.norm());
		// to what contact itself keeps; the mappings of 'flip' keep none
		const double scale = 0.03 * with.whole(1).mass;
		if (!flip) CHECK((angularMomentum(with) - angular).norm() < 1e-3 * scale);
		// a nodal step turns a spinning grain along the tangent, and stretches it
		const double tolerance = flip ? 1e-10 : 1e-3;
		for (int g = 0; g < 3; ++g) {
			const double away = largestDifference<dim>(
				with.system.setOf(g).nodePositions(with.laneOf(g)),
				without.system.setOf(g).nodePositions(without.laneOf(g)));
			CAPTURE(g, away, dim, scheme.picShare);
			CHECK(away < tolerance * 0.01);
			CHECK((with.whole(g).velocity - without.whole(g).velocity).norm() <
			      tolerance);
		}
		const EnergyBalance& e = with.system.energy();
		const EnergyBalance& f = without.system.energy();
		CHECK(std::abs(conserved(e) / conserved(f) - 1) < 1e-3);
	}
}

TEMPLATE_TEST_CASE_SIG("Rigid motion: the same bits whoever asks, with any number of threads",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	constexpr int rows = 12; // enough for two threads and more
	auto run = [](int threads, bool ask) {
		Scene<dim> scene = threeThatMeet<dim>(true, {}, rows);
		scene.settings.threads = threads;
		REQUIRE(threadsFor(scene.system.grains(), threads) == threads);
		const double dt = 0.4 * scene.system.criticalTimeStep();
		for (int n = 0; n < 80; ++n) {
			scene.advance(dt);
			if (n == 0) CHECK(rigidGrains(scene) == 3 * rows);
			if (!ask) continue;
			for (int g = 0; g < 3 * rows; ++g) {
				scene.system.body(g);
				scene.system.setOf(g).points(scene.laneOf(g));
			}
			scene.state();
		}
		CHECK(rigidGrains(scene) <= rows);
		return scene.state();
	};
	const auto bits = run(1, false);
	CHECK(run(3, false) == bits);
	CHECK(run(1, true) == bits);
}

TEMPLATE_TEST_CASE_SIG("Rigid motion: goes on from its saved state with the same bits", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	for (const Scheme& scheme :
	     { Scheme {}, Scheme { Formulation::total, VelocityUpdate::flip, 0 } }) {
		Scene<dim> whole = threeThatMeet<dim>(true, scheme);
		const double dt = 0.4 * whole.system.criticalTimeStep();
		auto run = [dt](Scene<dim>& scene, int steps) {
			for (int n = 0; n < steps; ++n)
				scene.advance(dt);
		};
		run(whole, 20);
		Scene<dim> second = threeThatMeet<dim>(true, scheme);
		for (int g = 0; g < 3; ++g)
			second.system.setOf(g).setState(
				second.laneOf(g), whole.system.setOf(g).state(whole.laneOf(g)));
		second.lists = whole.lists;
		second.system.continueFrom(whole.system.continuation());
		second.system.updateSurfaces(1);
		CHECK(rigidGrains(second) == rigidGrains(whole));
		CHECK(rigidGrains(second) > 0);
		run(whole, 60);
		run(second, 60);
		CHECK(second.state() == whole.state());
	}
}

TEST_CASE("Rigid motion: what does not move rigidly", "[rigid]")
{
	auto stepOf = [](auto&& change, bool rigid = true) {
		auto batch = motleyAt<2>(recipe(0.3), { Vec<2>::Zero(), { 0.05, 0 } });
		change(batch);
		Scene<2> scene;
		scene.settings.rigidMotion = rigid;
		scene.add(std::move(batch));
		scene.advance(1e-6);
		return scene.advance(1e-6).activeGrains;
	};
	auto nothing = [](Batch<2>&) {};
	CHECK(stepOf(nothing) == 0);
	CHECK(stepOf(nothing, false) == 2);
	CHECK(stepOf([](Batch<2>& b) { deform<2>(b, 1, 1.00001 * Mat<2>::Identity()); }) == 1);
	CHECK(stepOf([](Batch<2>& b) { b.v.set(1, 0, Vec<2>(1, 0)); }) == 1); // one node moves
	// at its rim a hundredth of the wave speed, 0.61 m/s: 61/s
	CHECK(stepOf([](Batch<2>& b) { launch<2>(b, 0, Vec<2>::Zero(), 55); }) == 0);
	CHECK(stepOf([](Batch<2>& b) { launch<2>(b, 0, Vec<2>::Zero(), 70); }) == 1);
}

TEST_CASE("Rigid motion: a torque that spins a grain too fast wakes it", "[rigid]")
{
	Scene<2> scene;
	scene.add(motleyAt<2>(recipe(0.3), { Vec<2>::Zero() }));
	scene.system.loads()[0].angular = spinMatrix<2>(Spin<2>(1e4));
	int active = 0;
	while (scene.time < 1e-2) // to 100/s
		active += scene.advance(2e-5).activeGrains;
	CHECK(active > 0.2 * scene.steps);
	CHECK(active < 0.6 * scene.steps);
	CHECK(std::abs(scene.whole(0).angularVelocity[0] / (1e4 * scene.time) - 1) < 1e-3);
}

TEST_CASE("Rigid motion: motions that are added by hand", "[rigid]")
{
	Scene<2> scene;
	auto batch = motleyAt<2>(brick(2, 0.3), { Vec<2>::Zero() });
	launch<2>(batch, 0, { 1, 0 }, 5);
	scene.add(std::move(batch));
	scene.advance(1e-5);
	CHECK(rigidGrains(scene) == 1);
	const auto before = scene.whole(0);
	const Mat<2> turn = rotationBy<2>(0.4);
	scene.system.setOf(0).moveRigidly(0, turn, { 0.1, 0.2 }, { -3, 4 },
					  spinMatrix<2>(Spin<2>(7)));
	scene.system.surfaces().update(0);
	const auto after = scene.whole(0);
	CHECK((after.centre - before.centre - Vec<2>(0.1, 0.2)).norm() < 1e-14);
	CHECK((after.velocity - turn * before.velocity - Vec<2>(-3, 4)).norm() < 1e-13);
	CHECK(std::abs(after.angularVelocity[0] - 12) < 1e-9);
	CHECK((after.rotation - turn * before.rotation).norm() < 1e-13);
	CHECK(scene.system.body(0).box.contains(after.centre));
	CHECK(scene.advance(1e-5).activeGrains == 0);
}

TEST_CASE("Rigid motion: a grain that comes near a plane without touching is rigid again",
	  "[rigid]")
{
	Scene<2> scene;
	auto batch = motleyAt<2>(recipe(0.3), { Vec<2>::Zero() });
	scene.add(std::move(batch));
	const double reach = 0.05 * 0.3 * 0.01;
	auto& list = scene.addPlane(0, { 0, -0.01 - 0.5 * reach }, { 0, 1 });
	CHECK(scene.advance(1e-5).activeGrains == 1);
	CHECK(!list.contacts.empty());
	list.plane.point[1] -= 5 * reach;
	CHECK(scene.advance(1e-5).activeGrains == 0);
	CHECK(scene.whole(0).velocity.norm() < 1e-12);
}

TEST_CASE("Rigid motion: grains in any blocks have the forces they have alone", "[rigid]")
{
	std::vector<Vec<2>> places(21);
	for (std::size_t g = 0; g < places.size(); ++g)
		places[g] = { 0.03 * g, 0 };
	auto batch = motleyAt<2>(recipe(0.25), places);
	Random random(3);
	for (int g = 0; g < batch.grains(); ++g)
		deform<2>(batch, g, random.deformation<2>(0.2));
	computeInternalForce(batch, 1);
	const auto force = batch.force;
	std::vector<int> active, others;
	for (int g = 0; g < batch.grains(); ++g)
		(g % 3 == 1 || g == 20 ? active : others).push_back(g);
	for (int g = 0; g < batch.grains(); ++g)
		std::fill_n(batch.force.of(g), batch.reference->nodes(), Vec<2>(7, 7));
	batch.arrange(active, others);
	CHECK(batch.activeBlocks() == 1);
	CHECK(batch.blocks() == 3);
	computeInternalForce(batch, 2);
	for (int g : active)
		for (int I = 0; I < batch.reference->nodes(); ++I)
			CHECK(batch.force.get(g, I) == force.get(g, I));
	for (int g : others) // left alone, and still to be asked for their points
		CHECK(batch.force.get(g, 3) == Vec<2>(7, 7));
	auto alone = singleGrain<2>(recipe(0.25), batch.grain[2]);
	std::copy_n(batch.x.of(2), batch.reference->nodes(), alone.x.of(0));
	const auto found = pointResponses(batch, 2), expected = pointResponses(alone, 0);
	for (std::size_t p = 0; p < found.size(); ++p)
		CHECK(found[p].cauchy == expected[p].cauchy);
}
