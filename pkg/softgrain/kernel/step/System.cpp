#include "step/System.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "grain/InternalForce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace softgrain {

template <int dim> void System<dim>::addBatch(Batch<dim> batch)
{
	std::map<double, double>
		frequency; // by Poisson's ratio: the template and the condition are shared
	for (int lane = 0; lane < batch.grains(); ++lane) {
		place_.push_back({ static_cast<int>(batches_.size()), lane });
		const GrainParameters<dim>& grain = batch.grain[lane];
		const auto [known, isNew] = frequency.try_emplace(grain.constants.poisson, 0.);
		if (isNew)
			known->second = highestFrequency(*batch.reference, batch.condition,
							 grain.constants.poisson);
		criticalTimeStep_.push_back(
			2 * grain.radius /
			(known->second * grain.constants.waveSpeed(batch.condition)));

		ContactBody<dim> body;
		body.mesh = &batch.reference->contactMesh;
		body.delassus = &batch.reference->delassus;
		body.delassusScale = 1 / batch.massScale[lane];
		body.nodeRadius = grain.radius * batch.reference->contactRadius;
		body.pointSpacing = grain.radius * batch.reference->pointSpacing();
		body.position.resize(batch.reference->contactNodes());
		body.velocity = body.impulse = body.position;
		bodies_.push_back(std::move(body));
	}
	loads_.resize(place_.size());
	batches_.push_back(std::move(batch));
	forcesFresh_ = false;
}

template <int dim> template <class Phase> void System<dim>::forEachGrain(int threads, Phase&& phase)
{
	const int count = grains();
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int g = 0; g < count; ++g)
		phase(g);
}

template <int dim> double System<dim>::criticalTimeStep() const
{
	return criticalTimeStep_.empty()
		       ? std::numeric_limits<double>::infinity()
		       : *std::min_element(criticalTimeStep_.begin(), criticalTimeStep_.end());
}

template <int dim> void System<dim>::updateSurface(int g)
{
	const Batch<dim>& batch = batchOf(g);
	ContactBody<dim>& body = bodies_[g];
	const SparseRows<double>& shapes = batch.reference->contactShapes;
	double fastest = 0;
	for (int s = 0; s < body.nodes(); ++s) {
		Vec<dim> x = Vec<dim>::Zero(), v = Vec<dim>::Zero();
		for (int k = shapes.begin(s); k < shapes.end(s); ++k) {
			x += shapes.value[k] * batch.x.get(laneOf(g), shapes.column[k]);
			v += shapes.value[k] * batch.v.get(laneOf(g), shapes.column[k]);
		}
		body.position[s] = batch.grain[laneOf(g)].origin + x;
		fastest = std::max(fastest, v.norm());
	}
	body.fastest = fastest;
	body.updateGeometry();
}

template <int dim> void System<dim>::updateSurfaces(int threads)
{
	forEachGrain(threads, [this](int g) { updateSurface(g); });
	forcesFresh_ = false;
}

template <int dim> void System<dim>::updateForces(int threads)
{
	for (Batch<dim>& batch : batches_)
		computeInternalForce(batch, threads);
	for (int g = 0; g < grains(); ++g) {
		const int point = batchOf(g).report[laneOf(g)].invertedPoint;
		if (point >= 0)
			throw StepError(g, point,
					"the material point is inverted (J <= 0 or not finite)");
	}
	forcesFresh_ = true;
}

template <int dim> double System<dim>::stiffening() const
{
	double largest = 1;
	for (int g = 0; g < grains(); ++g)
		largest = std::max(largest, batchOf(g).report[laneOf(g)].stiffening);
	return largest;
}

namespace {

/// Gaps that both bodies together could close in two steps at their present speeds, and never less
/// than a twentieth of the point spacing, for grains that are just being accelerated.
double reachOf(double speed, double dt, double pointSpacing)
{
	return std::max(2 * dt * speed, 0.05 * pointSpacing);
}

} // namespace

template <int dim> double System<dim>::reach(int first, int second, double dt) const
{
	const ContactBody<dim>&a = bodies_[first], &b = bodies_[second];
	return reachOf(a.fastest + b.fastest, dt, std::min(a.pointSpacing, b.pointSpacing));
}

template <int dim> double System<dim>::reach(int g, const Plane<dim>& plane, double dt) const
{
	return reachOf(bodies_[g].fastest + plane.velocity.norm(), dt, bodies_[g].pointSpacing);
}

/// Forces at t_n act from the middle of the last step to the middle of this one. (With the length
/// of this step alone, a step that follows the deformation would pump energy into the vibration it
/// follows.)
template <int dim> double System<dim>::kickTime(double dt) const
{
	return continuation_.lastStep > 0 ? 0.5 * (continuation_.lastStep + dt) : dt;
}

template <int dim> void System<dim>::predictVelocities(const StepSettings& settings)
{
	const double kick = kickTime(settings.dt);
	forEachGrain(settings.threads, [&](int g) {
		Batch<dim>& batch = batchOf(g);
		const int lane = laneOf(g);
		const BodyLoad<dim>& load = loads_[g];
		const bool loaded = !load.acceleration.isZero(0) || !load.angular.isZero(0);
		const Vec<dim> centre =
			loaded ? wholeGrain(batch, lane).centre : Vec<dim>(Vec<dim>::Zero());
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			Vec<dim> acceleration = batch.force.get(lane, I) / batch.nodeMass(lane, I);
			if (loaded)
				acceleration += load.acceleration +
						load.angular * (batch.x.get(lane, I) - centre);
			batch.vNext.set(lane, I, batch.v.get(lane, I) + kick * acceleration);
		}
	});
}

namespace {

template <int dim>
void interpolate(const Batch<dim>& batch, int lane, const NodalField<dim>& field,
		 std::vector<Vec<dim>>& at)
{
	const SparseRows<double>& shapes = batch.reference->contactShapes;
	at.assign(shapes.rows(), Vec<dim>::Zero());
	for (int s = 0; s < shapes.rows(); ++s)
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			at[s] += shapes.value[k] * field.get(lane, shapes.column[k]);
}

} // namespace

template <int dim>
void System<dim>::gatherContactVelocities(const std::vector<char>& touched,
					  const StepSettings& settings)
{
	forEachGrain(settings.threads, [&](int g) {
		if (!touched[g]) return;
		ContactBody<dim>& body = bodies_[g];
		interpolate(batchOf(g), laneOf(g), batchOf(g).vNext, body.velocity);
		if (settings.trackEnergy)
			interpolate(batchOf(g), laneOf(g), batchOf(g).v, body.velocityBefore);
		body.impulse.assign(body.nodes(), Vec<dim>::Zero());
	});
}

template <int dim>
void System<dim>::applyContactImpulses(const std::vector<char>& touched,
				       const StepSettings& settings)
{
	forEachGrain(settings.threads, [&](int g) {
		if (!touched[g]) return;
		Batch<dim>& batch = batchOf(g);
		const int lane = laneOf(g);
		const SparseRows<double>& shapes = batch.reference->contactShapes;
		for (int s = 0; s < bodies_[g].nodes(); ++s) {
			const Vec<dim>& r = bodies_[g].impulse[s];
			if (r.isZero(0)) continue;
			for (int k = shapes.begin(s); k < shapes.end(s); ++k) {
				const int I = shapes.column[k];
				batch.vNext.set(lane, I,
						batch.vNext.get(lane, I) +
							shapes.value[k] / batch.nodeMass(lane, I) *
								r);
			}
		}
	});
}

template <int dim> void System<dim>::checkVelocities() const
{
	for (int g = 0; g < grains(); ++g)
		for (int I = 0; I < batchOf(g).reference->nodes(); ++I)
			if (!batchOf(g).vNext.get(laneOf(g), I).allFinite())
				throw StepError(g, -1, "a nodal velocity is not finite");
}

template <int dim> void System<dim>::balanceEnergy(const ContactWork& work, double kick)
{
	energy_ = continuation_.sums;
	energy_.kinetic = energy_.elastic = 0;
	for (int g = 0; g < grains(); ++g) {
		const Batch<dim>& batch = batchOf(g);
		energy_.kinetic += kineticEnergy(batch, batch.v, batch.vNext, laneOf(g));
		energy_.elastic += batch.report[laneOf(g)].elasticEnergy;
	}
	ContactWork::Halves loads;
	for (int g = 0; g < grains(); ++g) {
		const BodyLoad<dim>& load = loads_[g];
		if (load.acceleration.isZero(0) && load.angular.isZero(0)) continue;
		const Batch<dim>& batch = batchOf(g);
		const int lane = laneOf(g);
		const Vec<dim> centre = wholeGrain(batch, lane).centre;
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			const Vec<dim> impulse = kick * batch.nodeMass(lane, I) *
						 (load.acceleration +
						  load.angular * (batch.x.get(lane, I) - centre));
			loads.before += 0.5 * impulse.dot(batch.v.get(lane, I));
			loads.after += 0.5 * impulse.dot(batch.vNext.get(lane, I));
		}
	}
	auto book = [this](double EnergyBalance::* sum, const ContactWork::Halves& halves) {
		energy_.*sum += halves.before; // the first half is done when t_n is reached
		continuation_.sums.*sum += halves.before + halves.after;
	};
	book(&EnergyBalance::impact, work.impact);
	book(&EnergyBalance::friction, work.friction);
	book(&EnergyBalance::planes, work.planes);
	book(&EnergyBalance::loads, loads);
}

template <int dim> void System<dim>::move(const StepSettings& settings)
{
	for (Batch<dim>& batch : batches_)
		batch.v.swap(batch.vNext);
	forEachGrain(settings.threads, [&](int g) {
		Batch<dim>& batch = batchOf(g);
		for (int I = 0; I < batch.reference->nodes(); ++I)
			batch.x.set(laneOf(g), I,
				    batch.x.get(laneOf(g), I) +
					    settings.dt * batch.v.get(laneOf(g), I));
	});
}

template <int dim>
StepReport System<dim>::step(const StepSettings& settings, std::vector<ContactList<dim>*> lists)
{
	StepReport report;
	if (!forcesFresh_) updateForces(settings.threads);
	report.stiffening = stiffening();
	report.kick = kickTime(settings.dt);

	// The sweep order is part of the result: it must not depend on who found which contact
	// when.
	std::stable_sort(lists.begin(), lists.end(),
			 [](const ContactList<dim>* a, const ContactList<dim>* b) {
				 return a->sweepOrder() < b->sweepOrder();
			 });
	std::vector<char> touched(grains(), 0);
	for (const ContactList<dim>* list : lists) {
		report.deepest = std::max(report.deepest, list->deepest);
		if (list->contacts.empty()) continue;
		touched[list->first] = 1;
		if (list->second >= 0) touched[list->second] = 1;
	}

	predictVelocities(settings);
	gatherContactVelocities(touched, settings);
	solver_.prepare(bodies_, lists, settings.dt, settings.solver);
	solver_.warmStart();
	report.solver = solver_.solve();
	if (settings.measureResidual) report.residual = solver_.residual();
	solver_.collectImpulses();
	applyContactImpulses(touched, settings);
	checkVelocities();
	if (settings.trackEnergy) balanceEnergy(solver_.work(), kickTime(settings.dt));
	move(settings);
	continuation_.lastStep = settings.dt;
	updateSurfaces(settings.threads);
	return report;
}

template class System<2>;
template class System<3>;

} // namespace softgrain
