#include "grain/TotalLagrangian.hpp"
#include "grain/CriticalTimeStep.hpp"

#include <algorithm>

namespace softgrain {

template <int dim>
TotalLagrangian<dim>::TotalLagrangian(Batch<dim> batch, const Scheme& scheme)
	: batch_(std::move(batch))
	, ownNodes_(batch_.grains())
	, criticalTimeStep_(criticalTimeSteps(*batch_.reference, batch_.condition, batch_.grain))
{
	if (!scheme.hasPointVelocities()) return;
	pointVelocities_.emplace(batch_, scheme.picShare);
	for (double& step : criticalTimeStep_)
		step *= pointVelocityTimeStepShare;
}

template <int dim> WholeGrain<dim> TotalLagrangian<dim>::whole(int g) const
{
	if (!pointVelocities_) return wholeGrain(batch_, g);
	const GrainTemplate<dim>& reference = *batch_.reference;
	return wholeOf<dim>(reference.points(), [&](int p) {
		return Particle<dim> { batch_.massScale[g] * reference.pointVolume[p],
				       pointAt(g, p), pointVelocities_->get(g, p),
				       reference.pointPosition[p] };
	});
}

template <int dim>
void TotalLagrangian<dim>::predictVelocities(int g, double kick, const BodyLoad<dim>& load)
{
	const bool loaded = !load.isZero();
	const Vec<dim> centre = loaded ? whole(g).centre : Vec<dim>(Vec<dim>::Zero());
	const std::vector<double>& inverseMass = batch_.reference->inverseNodeMass;
	const double scale = kick / batch_.massScale[g];
	const Vec<dim>*v = batch_.v.of(g), *force = batch_.force.of(g);
	Vec<dim>* vNext = batch_.vNext.of(g);
	for (int I = 0; I < nodes(); ++I) {
		vNext[I] = v[I];
		addScaled<dim>(vNext[I], scale * inverseMass[I], force[I]);
	}
	if (!loaded) return;
	for (int I = 0; I < nodes(); ++I)
		vNext[I] += kick * (load.acceleration +
				    load.angular * (batch_.x.get(g, I) - centre));
}

namespace {

template <int dim>
void interpolate(const SparseRows<double>& shapes, int g, const NodalField<dim>& field,
		 std::vector<Vec<dim>>& at)
{
	const Vec<dim>* own = field.of(g);
	at.resize(shapes.rows());
	for (int s = 0; s < shapes.rows(); ++s) {
		Vec<dim> sum = Vec<dim>::Zero();
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			addScaled<dim>(sum, shapes.value[k], own[shapes.column[k]]);
		at[s] = sum;
	}
}

} // namespace

template <int dim>
void TotalLagrangian<dim>::contactVelocities(int g, std::vector<Vec<dim>>& at) const
{
	interpolate(contactShapes(g), g, batch_.vNext, at);
}

template <int dim>
void TotalLagrangian<dim>::contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const
{
	interpolate(contactShapes(g), g, batch_.v, at);
}

template <int dim>
void TotalLagrangian<dim>::applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse)
{
	const SparseRows<double>& shapes = contactShapes(g);
	const std::vector<double>& inverseMass = batch_.reference->inverseNodeMass;
	Vec<dim>* vNext = batch_.vNext.of(g);
	for (int s = 0; s < shapes.rows(); ++s) {
		if (impulse[s].isZero(0)) continue;
		const Vec<dim> r = impulse[s] / batch_.massScale[g];
		for (int k = shapes.begin(s); k < shapes.end(s); ++k) {
			const int I = shapes.column[k];
			addScaled<dim>(vNext[I], shapes.value[k] * inverseMass[I], r);
		}
	}
}

template <int dim> bool TotalLagrangian<dim>::hasFiniteVelocities(int g) const
{
	// What is not finite leaves no zero.
	const Vec<dim>* v = batch_.vNext.of(g);
	Vec<dim> sum = Vec<dim>::Zero();
	for (int I = 0; I < nodes(); ++I)
		addScaled<dim>(sum, 0, v[I]);
	return sum.isZero(0);
}

template <int dim> double TotalLagrangian<dim>::kineticEnergy(int g) const
{
	return softgrain::kineticEnergy(batch_, batch_.v, batch_.vNext, g);
}

template <int dim>
void TotalLagrangian<dim>::addLoadWork(int g, double kick, const BodyLoad<dim>& load,
				       double& before, double& after) const
{
	const Vec<dim> centre = whole(g).centre;
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> impulse =
			kick * batch_.nodeMass(g, I) *
			(load.acceleration + load.angular * (batch_.x.get(g, I) - centre));
		before += 0.5 * impulse.dot(batch_.v.get(g, I));
		after += 0.5 * impulse.dot(batch_.vNext.get(g, I));
	}
}

template <int dim> void TotalLagrangian<dim>::move(double dt, int threads)
{
	if (pointVelocities_)
		pointVelocities_->update(batch_, threads);
	else
		batch_.v.swap(batch_.vNext);
	const NodalField<dim>& v = pointVelocities_ ? batch_.vNext : batch_.v;
	const int count = grains();
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int g = 0; g < count; ++g) {
		Vec<dim>* x = batch_.x.of(g);
		const Vec<dim>* own = v.of(g);
		for (int I = 0; I < nodes(); ++I)
			addScaled<dim>(x[I], dt, own[I]);
	}
}

template <int dim>
void TotalLagrangian<dim>::contactPositions(int g, std::vector<Vec<dim>>& at) const
{
	interpolate(batch_.reference->contactShapes, g, batch_.x, at);
	for (Vec<dim>& x : at)
		x += batch_.grain[g].origin;
}

template <int dim>
void TotalLagrangian<dim>::massPoints(int g, std::vector<Vec<dim>>& position,
				      std::vector<double>& mass) const
{
	const auto& shapes = batch_.reference->pointShapes;
	for (int p = 0; p < shapes.rows(); ++p) {
		Vec<dim> x = batch_.grain[g].origin;
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			x += shapes.value[k].N * batch_.x.get(g, shapes.column[k]);
		position.push_back(x);
		mass.push_back(batch_.massScale[g] * batch_.reference->pointVolume[p]);
	}
}

template <int dim>
void TotalLagrangian<dim>::useContactNodes(int g, const SparseRows<double>& pointShares)
{
	const auto& points = batch_.reference->pointShapes;
	SparseRows<double> rows;
	std::vector<double> sum(nodes(), 0.);
	for (int s = 0; s < pointShares.rows(); ++s) {
		std::vector<int> met;
		for (int j = pointShares.begin(s); j < pointShares.end(s); ++j) {
			const int p = pointShares.column[j];
			for (int k = points.begin(p); k < points.end(p); ++k) {
				met.push_back(points.column[k]);
				sum[points.column[k]] += pointShares.value[j] * points.value[k].N;
			}
		}
		std::sort(met.begin(), met.end());
		met.erase(std::unique(met.begin(), met.end()), met.end());
		for (int I : met) {
			rows.append(I, sum[I]);
			sum[I] = 0;
		}
		rows.closeRow();
	}
	ownNodes_[g].delassus = delassusTable(rows, batch_.reference->nodeMass);
	ownNodes_[g].shapes = std::move(rows);
}

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodePositions(int g) const
{
	std::vector<Vec<dim>> x;
	for (int I = 0; I < nodes(); ++I)
		x.push_back(batch_.position(g, I));
	return x;
}

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodeVelocities(int g) const
{
	std::vector<Vec<dim>> v;
	for (int I = 0; I < nodes(); ++I)
		v.push_back(batch_.v.get(g, I));
	return v;
}

/// Relative to the grain's origin.
template <int dim> Vec<dim> TotalLagrangian<dim>::pointAt(int g, int p) const
{
	const auto& shapes = batch_.reference->pointShapes;
	Vec<dim> x = Vec<dim>::Zero();
	for (int k = shapes.begin(p); k < shapes.end(p); ++k)
		x += shapes.value[k].N * batch_.x.get(g, shapes.column[k]);
	return x;
}

template <int dim>
void TotalLagrangian<dim>::place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
				 const Mat<dim>& spin)
{
	batch_.place(g, rotation, velocity, spin);
	if (!pointVelocities_) return;
	pointVelocities_->takeFromNodes(batch_, g);
	pointVelocities_->mapToNodes(batch_, g);
}

template <int dim>
void TotalLagrangian<dim>::moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
				       const Vec<dim>& velocity, const Mat<dim>& spin)
{
	const Vec<dim> centre = whole(g).centre;
	batch_.moveRigidly(g, centre, rotation, shift, velocity, spin);
	if (!pointVelocities_) return;
	for (int p = 0; p < batch_.reference->points(); ++p)
		pointVelocities_->set(g, p,
				      rotation * pointVelocities_->get(g, p) + velocity +
					      spin * (pointAt(g, p) - centre - shift));
	pointVelocities_->mapToNodes(batch_, g);
}

template <int dim> GrainState TotalLagrangian<dim>::state(int g) const
{
	GrainState s;
	auto append = [](std::vector<double>& list, const Vec<dim>& value) {
		list.insert(list.end(), value.data(), value.data() + dim);
	};
	for (int I = 0; I < nodes(); ++I)
		append(s.x, batch_.x.get(g, I));
	if (pointVelocities_)
		for (int p = 0; p < batch_.reference->points(); ++p)
			append(s.v, pointVelocities_->get(g, p));
	else
		for (int I = 0; I < nodes(); ++I)
			append(s.v, batch_.v.get(g, I));
	return s;
}

template <int dim> void TotalLagrangian<dim>::setState(int g, const GrainState& s)
{
	const int velocities = pointVelocities_ ? batch_.reference->points() : nodes();
	requireSize("positions", s.x, nodes() * dim);
	requireSize("velocities", s.v, velocities * dim);
	requireSize("deformation gradients", s.F, 0);
	for (int I = 0; I < nodes(); ++I)
		batch_.x.set(g, I, Eigen::Map<const Vec<dim>>(&s.x[I * dim]));
	for (int k = 0; k < velocities; ++k) {
		const Vec<dim> v = Eigen::Map<const Vec<dim>>(&s.v[k * dim]);
		if (pointVelocities_)
			pointVelocities_->set(g, k, v);
		else
			batch_.v.set(g, k, v);
	}
	if (pointVelocities_) pointVelocities_->mapToNodes(batch_, g);
}

template class TotalLagrangian<2>;
template class TotalLagrangian<3>;

} // namespace softgrain
