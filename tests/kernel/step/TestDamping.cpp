#include "step/Formulations.hpp"
#include "step/Scene.hpp"

#include "grain/BulkPass.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "grain/Damper.hpp"
#include "grain/Vibrations.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>
#include <memory>
#include <utility>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> GrainParameters<dim> dampedGrain(const Damping& damping, double poisson = 0.45)
{
	GrainParameters<dim> grain = paperGrain<dim>();
	grain.constants.poisson = poisson;
	grain.damping = damping;
	return grain;
}

/// Largest deviation of a small vibration in mode `index` (negative: from the last) of a free disk
/// from what damping makes of it, over its amplitude (theory.md):
/// y_(n+1) = (1 + D - w^2 dt^2) y_n - D y_(n-1), D = exp(-alpha dt) - beta w^2 dt.
double deviation(const Damping& damping, const TemplateRecipe& r, int index)
{
	auto grain = std::make_shared<GrainTemplate<2>>(*makeGrainTemplate<2>(r));
	grain->hourglass.clear(); // stiffness damping does not act on these forces
	Batch<2> batch(grain, Law::neoHookean, usualCondition<2>, { dampedGrain<2>(damping) });
	const int components = 2 * batch.reference->nodes();
	const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(dynamicMatrix(batch));
	const int chosen = index < 0 ? components + index : index;
	const double squared = modes.eigenvalues()[chosen];
	Eigen::VectorXd mode = modes.eigenvectors().col(chosen); // times the roots of the masses
	auto rootMass = [&](int i) { return std::sqrt(batch.nodeMass(0, i / 2)); };
	double largest = 0;
	for (int i = 0; i < components; ++i)
		largest = std::max(largest, std::abs(mode[i] / rootMass(i)));
	for (int i = 0; i < components; ++i)
		batch.x.of(0)[i / 2][i % 2] += 1e-7 * mode[i] / rootMass(i) / largest;
	Scene<2> scene;
	scene.settings.rigidMotion = false;
	scene.add(batch);
	const double dt = 0.5 * scene.system.criticalTimeStep();
	std::vector<double> y;
	for (int n = 0; n < 60; ++n) {
		y.push_back(0);
		for (int i = 0; i < components; ++i)
			y.back() += mode[i] * rootMass(i) *
				    (scene.batchOf(0).x.of(0)[i / 2][i % 2] -
				     0.01 * batch.reference->nodePosition[i / 2][i % 2]);
		scene.advance(dt);
	}
	const double D = std::exp(-damping.mass * dt) - damping.stiffness * squared * dt;
	double worst = 0;
	for (std::size_t n = 1; n + 1 < y.size(); ++n)
		worst = std::max(worst, std::abs(y[n + 1] - (1 + D - squared * dt * dt) * y[n] +
						 D * y[n - 1]));
	return worst / y[0];
}

/// A noisy, spinning, flying grain.
template <int dim> Scene<dim> noisyGrain(const Damping& damping, const TemplateRecipe& r)
{
	Random random(1);
	auto batch = singleGrain<dim>(r, dampedGrain<dim>(damping));
	makeNoisy(batch, random);
	Scene<dim> scene;
	scene.settings.trackEnergy = true;
	scene.settings.rigidMotion = false;
	scene.add(std::move(batch));
	return scene;
}

} // namespace

TEST_CASE("Damping: each mode of a disk decays as the formula says", "[damping]")
{
	const double time = 0.01 / paperGrain<2>().constants.waveSpeed(Condition::planeStrain);
	for (const TemplateRecipe& r : { coarse<2>(), projectedRecipe(0.25) })
		for (const Damping& damping :
		     { Damping { 0.5 / time, 0 }, Damping { 0, 0.02 * time },
		       Damping { 2 / time, 0.05 * time } })
			for (int mode : { 3, 10, 40, -1 }) { // the first three are rigid
				CAPTURE(damping.mass, damping.stiffness, mode);
				CHECK(deviation(damping, r, mode) < 1e-8);
			}
}

TEMPLATE_TEST_CASE_SIG("Damping: momenta stay, energy closes, motion becomes rigid", "[damping]",
		       ((int dim), dim), 2, 3)
{
	const double time = 0.01 / paperGrain<dim>().constants.waveSpeed(usualCondition<dim>);
	const Damping both { 0.05 / time, 0.05 * time };
	for (const TemplateRecipe& r : { coarse<dim>(), projectedRecipe(dim == 2 ? 0.25 : 0.4) }) {
		Scene<dim> scene = noisyGrain<dim>(both, r);
		const double dt = 0.1 * scene.system.criticalTimeStep();
		const auto before = scene.whole(0);
		scene.advance(dt);
		const double start = conserved(scene.system.energy());
		double last = 0, worst = 0;
		for (int n = 0; n < 3000; ++n) {
			scene.advance(dt);
			const EnergyBalance& e = scene.system.energy();
			worst = std::max(worst, std::abs(conserved(e) - start));
			CHECK(e.damping >= last - 1e-3 * start);
			last = e.damping;
		}
		const auto after = scene.whole(0);
		CHECK((after.velocity - before.velocity).norm() < 1e-11 * before.velocity.norm());
		CHECK((after.angularMomentum - before.angularMomentum).norm() <
		      1e-11 * before.angularMomentum.norm());
		const double rigid = 0.5 * after.mass * after.velocity.squaredNorm() +
				     0.5 * after.angularVelocity.dot(after.angularMomentum);
		const double vibrating = scene.system.setOf(0).presentKineticEnergy(0) - rigid;
		CAPTURE(worst / start, last / start, vibrating / start);
		CHECK(worst < 5e-3 * start);
		CHECK(last > 0.3 * start);
		CHECK(vibrating < 1e-3 * start);
	}
}

TEMPLATE_TEST_CASE_SIG("Damping: rigid motion goes on as without", "[damping]", ((int dim), dim), 2,
		       3)
{
	auto run = [](const Damping& damping, bool rigidMotion) {
		auto batch = singleGrain<dim>(coarse<dim>(), dampedGrain<dim>(damping));
		Spin<dim> omega;
		omega.setZero();
		omega[omega.size() - 1] = 1;
		batch.place(0, Mat<dim>::Identity(), Vec<dim>::Constant(3), spinMatrix<dim>(omega));
		Scene<dim> scene;
		scene.settings.trackEnergy = true;
		scene.settings.rigidMotion = rigidMotion;
		scene.add(std::move(batch));
		for (int n = 0; n < 200; ++n)
			scene.advance(2e-5);
		return scene;
	};
	for (bool rigidMotion : { false, true }) {
		const auto damped = run({ 1e4, 1e-5 }, rigidMotion);
		const EnergyBalance& e = damped.system.energy();
		CHECK(std::abs(e.damping) < 1e-6 * e.kinetic);
		const auto a = damped.whole(0), b = run({}, false).whole(0);
		CHECK((a.velocity - b.velocity).norm() < 1e-12 * b.velocity.norm());
		CHECK((a.angularVelocity - b.angularVelocity).norm() <
		      1e-6 * b.angularVelocity.norm());
	}
}

TEST_CASE("Damping: a squeezed disk at rest carries the force it carries without", "[damping]")
{
	auto force = [](const Damping& damping) {
		Scene<2> scene;
		scene.add(singleGrain<2>(coarse<2>(), dampedGrain<2>(damping)));
		scene.addPlane(0, Vec<2>(0, -0.01), Vec<2>(0, 1));
		ContactList<2>& top =
			scene.addPlane(0, Vec<2>(0, 0.01), Vec<2>(0, -1), Vec<2>(0, -0.5));
		double sum = 0;
		int steps = 0;
		while (scene.time < 0.05) {
			if (scene.time > 0.002) top.plane.velocity.setZero();
			const StepReport report = scene.advance(1e-5);
			if (scene.time < 0.04) continue;
			for (const Contact<2>& c : top.contacts)
				sum -= c.impulse[1] / report.kick;
			++steps;
		}
		return sum / steps;
	};
	const double plain = force({}), mass = force({ 1e4, 0 }), stiffness = force({ 0, 2e-5 });
	CAPTURE(plain, mass, stiffness);
	CHECK(plain > 0);
	CHECK(std::abs(mass / plain - 1) < 0.01);
	CHECK(std::abs(stiffness / plain - 1) < 0.01);
}

TEST_CASE("Damping: critical step by the formulas of one mode", "[damping]")
{
	const double T = 1e-5, omega = 2 / T;
	CHECK(dampedTimeStep(T, {}, 4, 1) == T / 2);
	// Belytschko: 2/omega (sqrt(1 + xi^2) - xi), xi = beta omega/2
	const double beta = 0.6 / omega, xi = 0.3;
	CHECK(std::abs(dampedTimeStep(T, { 0, beta }, 1, 1) / (T * (std::sqrt(1 + xi * xi) - xi)) -
		       1) < 1e-14);
	// very strong mass damping: a step from rest to rest
	CHECK(std::abs(dampedTimeStep(T, { 1e9, 0 }, 1, 1) / (T / std::sqrt(2.)) - 1) < 1e-14);
	const Damping both { 3e4, 2e-6 };
	for (double s : { 1., 3. })
		for (double q : { 1., 2. }) {
			const double dt = dampedTimeStep(T, both, s, q);
			const double left = s * dt * dt + 2 * both.stiffness * q * dt,
				     right = 0.5 * T * T * (1 + std::exp(-both.mass * dt));
			CHECK(left <= right);
			CHECK(left > 0.95 * right);
		}
}

TEST_CASE("Damping: stable at the critical step, not far above", "[damping]")
{
	const double time = 0.01 / paperGrain<2>().constants.waveSpeed(Condition::planeStrain);
	auto growth = [&](const Damping& damping, double share) {
		auto batch = singleGrain<2>(coarse<2>(), dampedGrain<2>(damping));
		Random random(1);
		shake(batch, 0, 1e-9, random);
		Scene<2> scene;
		scene.settings.rigidMotion = false;
		scene.add(std::move(batch));
		const double dt = share * scene.system.criticalTimeStep();
		try {
			for (int n = 0; n < 200; ++n)
				scene.advance(dt);
		} catch (const StepError&) {
			return std::numeric_limits<double>::infinity();
		}
		double largest = 0;
		for (int I = 0; I < scene.batchOf(0).reference->nodes(); ++I)
			largest = std::max(largest, (scene.batchOf(0).x.get(0, I) / 0.01 -
						     scene.batchOf(0).reference->nodePosition[I])
							    .norm());
		return largest / 1e-9;
	};
	for (const Damping& damping : { Damping { 30 / time, 0 }, Damping { 0, 0.3 * time },
					Damping { 30 / time, 0.3 * time } }) {
		CAPTURE(damping.mass, damping.stiffness);
		CHECK(growth(damping, 1) < 100);
		CHECK(growth(damping, 1.1) > 1e4);
	}
}

TEST_CASE("Damping: stable while strongly stretched", "[damping]")
{
	const double time = 0.01 / paperGrain<2>().constants.waveSpeed(Condition::planeStrain);
	for (const auto& [a, b] : { std::pair { 1.6, 1.2 }, { 1.5, 0.6 }, { 0.7, 0.7 } }) {
		auto batch = singleGrain<2>(coarse<2>(), dampedGrain<2>({ 0, 0.5 * time }));
		deform<2>(batch, 0, Vec<2>(a, b).asDiagonal());
		Scene<2> scene;
		scene.add(std::move(batch));
		scene.settings.rigidMotion = false;
		for (int n = 0; n < 500; ++n) {
			scene.system.updateForces(1); // the step is that of this deformation
			scene.advance(0.98 * scene.system.presentCriticalTimeStep());
		}
		CHECK((scene.whole(0).velocity).norm() < 1e-9);
		scene.system.updateForces(1);
		CHECK(scene.system.setOf(0).report(0).elasticEnergy < 1e-3);
	}
}

TEST_CASE("Damping: grains with and without in one set do not disturb each other", "[damping]")
{
	const Damping both { 500, 1e-6 };
	auto run = [](const std::vector<Damping>& dampings, int watched) {
		std::vector<GrainParameters<2>> grains;
		for (const Damping& damping : dampings)
			grains.push_back(dampedGrain<2>(damping));
		Batch<2> batch(makeGrainTemplate<2>(coarse<2>()), Law::neoHookean,
			       Condition::planeStrain, grains);
		Random random(1);
		Mat<2> F = random.deformation<2>(0.1);
		for (std::size_t g = 0; g < grains.size(); ++g)
			deform<2>(batch, static_cast<int>(g), F);
		Scene<2> scene;
		scene.add(std::move(batch));
		for (int n = 0; n < 50; ++n)
			scene.advance(1e-5);
		const GrainState s = scene.system.setOf(watched).state(scene.laneOf(watched));
		return std::pair { s.x, s.v };
	};
	CHECK(run({ {}, both }, 0) == run({ {} }, 0));
	CHECK(run({ {}, both }, 1) == run({ both }, 0));
	CHECK(run({ both }, 0) != run({ {} }, 0));
}

TEMPLATE_TEST_CASE_SIG("Damping: grains side by side have the forces that each has alone",
		       "[damping]", ((int dim), dim), 2, 3)
{
	constexpr int count = fullBlock + 1;
	std::vector<TemplateRecipe> recipes { projectedRecipe(dim == 2 ? 0.25 : 0.4) };
	for (int order : { 1, 2, 3 })
		recipes.push_back(recipe(dim == 2 ? 0.25 : 0.4, order));
	recipes.push_back(recipes.back());
	recipes.back().basis = Basis::triangles;
	if (dim == 3) recipes.pop_back();
	for (const TemplateRecipe& r : recipes) {
		Random random(1);
		std::vector<GrainParameters<dim>> grains;
		std::vector<Batch<dim>> alone;
		for (int g = 0; g < count; ++g) {
			grains.push_back(
				dampedGrain<dim>({ 0, g == 1 ? 0 : 1e-6 * (1 + g) }, 0.1 * g));
			grains.back().radius *= 1 + 0.1 * g;
			alone.push_back(singleGrain<dim>(r, grains[g]));
			makeNoisy(alone[g], random);
		}
		Batch<dim> all(alone[0].reference, Law::neoHookean, usualCondition<dim>, grains);
		const int nodes = all.reference->nodes();
		for (int g = 0; g < count; ++g)
			for (int I = 0; I < nodes; ++I) {
				all.x.set(g, I, alone[g].x.get(0, I));
				all.v.set(g, I, alone[g].v.get(0, I));
			}
		auto numbersOf = [](const Batch<dim>& batch, int g) {
			Damper<dim> damper(batch);
			damper.updateForces(batch, 1);
			return damper.numbers(g);
		};
		for (int g = 0; g < count; ++g) {
			const std::vector<double> own = numbersOf(alone[g], 0),
						  among = numbersOf(all, g);
			double size = 0, largest = 0, power = 0;
			for (std::size_t k = 1; k < own.size(); ++k) {
				size = std::max(size, std::abs(own[k]));
				largest = std::max(largest, std::abs(among[k] - own[k]));
				power += own[k] * all.v.of(g)[(k - 1) / dim][(k - 1) % dim];
			}
			CAPTURE(r.order, g, size);
			CHECK(largest <= 1e-12 * size);
			if (g == 1) {
				CHECK(size == 0);
				continue;
			}
			CHECK(power < 0);
			if (g == 0) CHECK(own[0] > 1); // largest squared stretch
			CHECK(std::abs(among[0] / own[0] - 1) < 1e-12);
		}
	}
}

TEST_CASE("Damping: energies and critical step have the same bits with any number of threads",
	  "[damping]")
{
	constexpr int count = 70; // enough for two threads and more
	auto run = [](int threads) {
		std::vector<GrainParameters<2>> grains;
		for (int g = 0; g < count; ++g) {
			grains.push_back(dampedGrain<2>({ 500. * (g % 3), 1e-6 * (g % 2) }));
			grains.back().origin[0] = 0.05 * g;
		}
		Batch<2> batch(makeGrainTemplate<2>(coarse<2>()), Law::neoHookean,
			       Condition::planeStrain, grains);
		Random random(1);
		for (int g = 0; g < count; ++g)
			deform<2>(batch, g, random.deformation<2>(0.2));
		Scene<2> scene;
		scene.settings.threads = threads;
		scene.settings.trackEnergy = true;
		scene.add(std::move(batch));
		for (int g = 0; g < count; ++g) {
			scene.system.loads()[g].acceleration = random.vector<2>(10);
			scene.system.loads()[g].angular =
				spinMatrix<2>(Spin<2>(random.uniform(-100, 100)));
		}
		std::vector<double> found;
		for (int n = 0; n < 5; ++n) {
			scene.advance(1e-6);
			scene.system.updateForces(threads);
			const EnergyBalance& e = scene.system.energy();
			found.insert(found.end(),
				     { e.kinetic, e.elastic, e.loads, e.damping,
				       scene.system.presentCriticalTimeStep(n * 1e-4, threads) });
		}
		for (int g = 0; g < count; ++g)
			for (double number :
			     scene.system.setOf(g).state(scene.laneOf(g)).stiffening)
				found.push_back(number);
		return found;
	};
	const auto found = run(1);
	CHECK(found.size() > 25 + 3 * 10); // some were measured
	CHECK(run(2) == found);
	CHECK(run(3) == found);
}

TEST_CASE("Damping: inadmissible values and formulations are named", "[damping]")
{
	auto complaint = [](const Damping& damping, const Scheme& scheme = {}) {
		return complaintOf(
			[&] { grainsOf<2>(scheme, coarse<2>(), { dampedGrain<2>(damping) }); });
	};
	CHECK(complaint({ -1, 0 }).find("massDamping = -1") != std::string::npos);
	CHECK(complaint({ 0, -2 }).find("stiffnessDamping = -2") != std::string::npos);
	CHECK(complaint({ 1, 1 }).empty());
	Scheme flip;
	flip.velocityUpdate = VelocityUpdate::flip;
	CHECK(complaint({ 1, 0 }, flip).find("velocityUpdate = 'nodal'") != std::string::npos);
	CHECK(complaint({}, flip).empty());
}
