#include "grain/TotalLagrangian.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "grain/HighestFrequency.hpp"

#include <algorithm>
#include <numeric>

namespace softgrain {

namespace {

/// Strain below which a grain counts as undeformed: the energy dropped when it becomes rigid, its
/// square times that of a wave of unit strain, is lost in the rounding of the energy of any motion.
constexpr double undeformedStrain = 1e-8;
/// A step so many times as long as it has to be is known well enough by few iterations
/// (highestFrequencies): what they may lack in grains of far more nodes is in it.
constexpr double amply = 1.05;
/// Of the stiffening reported, which counts at least where forces are held: it is that of another
/// shape than the nodes', and near their critical step held forces are worse at keeping energy
/// (doc/decisions/0018-multirate.md).
constexpr double heldShare = 0.75;
/// Strain by centrifugal forces, (omega R/c)^2, that rigid motion may leave out.
constexpr double spinStrain = 1e-4;
/// Period of the slowest vibration of a disk, times the speed of shear waves over its radius
/// (Lamb; a ball's is within a tenth). Slender grains: times the square of their slenderness, as of
/// a beam.
constexpr double slowestPeriod = 2.7;
/// How far the outline may lie out of its facets, over the longest edge: a triangle of a ball,
/// with room to spare.
constexpr double bulgeShare = 0.3;

} // namespace

template <int dim>
TotalLagrangian<dim>::TotalLagrangian(Batch<dim> batch, const Scheme& scheme)
	: batch_(std::move(batch))
	, ownNodes_(batch_.grains())
	, holder_(batch_.grains())
	, computed_(batch_.grains())
	, criticalTimeStep_(criticalTimeSteps(*batch_.reference, batch_.condition, batch_.grain))
	, stiffening_(batch_.grains())
	, rigid_(batch_.grains())
	, isRigid_(batch_.grains(), 0)
	, nodesWritten_(batch_.grains(), 1)
{
	std::iota(computed_.begin(), computed_.end(), 0);
	findIsochoricShares(batch_);
	batch_.arrange(computed_, {});
	if (scheme.hasPointVelocities()) {
		pointVelocities_.emplace(batch_, scheme.picShare);
		for (double& step : criticalTimeStep_)
			step *= pointVelocityTimeStepShare;
	}
	if (Damper<dim>::isNeeded(batch_)) damper_.emplace(batch_);
	measureShapes();
}

/// Mass, centre and inertia of what carries the velocity: nodes or points.
template <int dim> void TotalLagrangian<dim>::measureShapes()
{
	const GrainTemplate<dim>& reference = *batch_.reference;
	const auto& position = pointVelocities_ ? reference.pointPosition : reference.nodePosition;
	const auto& mass = pointVelocities_ ? reference.pointVolume : reference.nodeMass;
	const WholeGrain<dim> unit = wholeOf<dim>(static_cast<int>(mass.size()), [&](int i) {
		return Particle<dim> { mass[i], position[i], Vec<dim>::Zero(), position[i] };
	});
	for (int g = 0; g < grains(); ++g) {
		const double R = batch_.grain[g].radius;
		shape_.push_back({ batch_.massScale[g] * unit.mass, R * unit.centre,
				   R * R / unit.mass * unit.inertia });
	}
	for (const Vec<dim>& X : reference.contactMesh.vertex)
		outlineRadius_ = std::max(outlineRadius_, (X - unit.centre).norm());
	outlineRadius_ += reference.contactRadius;
	for (const auto& facet : reference.contactMesh.facet)
		for (int i = 0; i < dim; ++i)
			outlineBulge_ = std::max(
				outlineBulge_,
				bulgeShare * (reference.contactMesh.vertex[facet[i]] -
					      reference.contactMesh.vertex[facet[(i + 1) % dim]])
						     .norm());
	for (int g = 0; g < grains(); ++g) {
		const GrainParameters<dim>& own = batch_.grain[g];
		const double wave = own.constants.waveSpeed(batch_.condition);
		const double rim = rimOf(g);
		limits_.push_back(
			{ spinStrain * wave * wave / (rim * rim),
			  undeformedStrain * undeformedStrain * shape_[g].mass * wave * wave });
		const double shear = std::sqrt(own.constants.mu() / own.constants.density);
		rest_.emplace_back(own.damping, slowestPeriod * rim * outlineRadius_ /
							(reference.inradius * shear));
	}
	watchedFrom_.assign(grains(), Momenta::Zero());
}

template <int dim>
template <class Visit>
void TotalLagrangian<dim>::forEachSlow(int threads, Visit&& visit)
{
	const int count = static_cast<int>(computed_.size());
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int k = 0; k < count; ++k)
		if (holder_.rate(computed_[k]) > 1) visit(computed_[k]);
}

template <int dim> int TotalLagrangian<dim>::updateForces(const ForceSchedule& schedule)
{
	const int threads = schedule.threads;
	if (holder_.isNeeded()) {
		std::vector<int> due;
		for (int g = 0; g < grains(); ++g)
			if (!isRigid_[g] && !isAsleep(g) && holder_.isDue(g, schedule))
				due.push_back(g);
			else if (holder_.holds(g))
				holder_.report(batch_, g);
		if (due != computed_) computeFirst(std::move(due));
		forEachSlow(threads, [&](int g) { holder_.lookAhead(batch_, g, schedule); });
	}
	computeInternalForce(batch_, threads);
	if (damper_) damper_->updateForces(batch_, threads);
	if (holder_.isNeeded())
		forEachSlow(threads, [&](int g) { holder_.hold(batch_, g, schedule); });
	return static_cast<int>(computed_.size());
}

/// Square of a frequency over that of the undeformed grain, as far as it is to be believed.
template <int dim> double TotalLagrangian<dim>::stiffeningOf(int g, double frequency) const
{
	const double ofNodes = // critical step of the undeformed grain
		criticalTimeStep_[g] / (pointVelocities_ ? pointVelocityTimeStepShare : 1);
	const double ratio = 0.5 * ofNodes * frequency, squared = ratio * ratio;
	return holder_.rate(g) > 1 ? std::max(squared, heldShare * batch_.report[g].stiffening)
				   : squared;
}

template <int dim>
int TotalLagrangian<dim>::measureStiffening(const std::vector<DueMeasurement>& due)
{
	std::vector<int> grains;
	for (const DueMeasurement& one : due)
		grains.push_back(one.grain);
	const auto suffices = [&](std::size_t k, double frequency) {
		const auto [g, enough] = due[k];
		return dampedTimeStep(criticalTimeStep_[g], batch_.grain[g].damping,
				      stiffeningOf(g, frequency),
				      rateStiffening(g)) >= amply * enough;
	};
	const std::vector<MeasuredFrequency> measured =
		highestFrequencies(batch_, grains, suffices);
	int forces = 0;
	for (std::size_t k = 0; k < due.size(); ++k) {
		const int g = grains[k];
		stiffening_[g].set(batch_.report[g], stiffeningOf(g, measured[k].frequency));
		forces += measured[k].forces;
	}
	return forces;
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

template <int dim> WholeGrain<dim> TotalLagrangian<dim>::whole(int g) const
{
	return isRigid_[g] ? rigid_[g].whole(shape_[g]) : wholeOfParticles(g);
}

template <int dim> WholeGrain<dim> TotalLagrangian<dim>::wholeOfParticles(int g) const
{
	if (!pointVelocities_) return wholeGrain(batch_, g);
	const GrainTemplate<dim>& reference = *batch_.reference;
	return wholeOf<dim>(reference.points(), [&](int p) {
		return Particle<dim> { batch_.massScale[g] * reference.pointVolume[p],
				       pointAt(g, p), pointVelocities_->get(g, p),
				       reference.pointPosition[p] };
	});
}

namespace {

/// To the new velocities of the nodes.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void addVelocities(Batch<dim>& batch, int g,
						      const RigidVelocities<dim>& added)
{
	const int nodes = batch.reference->nodes();
	const Vec<dim>* x = batch.x.of(g);
	Vec<dim>* vNext = batch.vNext.of(g);
	if (added.spin.isZero(0))
		for (int I = 0; I < nodes; ++I)
			addScaled<dim>(vNext[I], 1, added.velocity);
	else
		for (int I = 0; I < nodes; ++I)
			vNext[I] += added.at(x[I]);
}

} // namespace

template <int dim>
void TotalLagrangian<dim>::predictVelocities(int g, double kick, const BodyLoad<dim>& load)
{
	if (isRigid_[g]) {
		rigid_[g].accelerate(kick, load.acceleration, load.angular, shape_[g]);
		return;
	}
	const std::vector<double>& inverseMass = batch_.reference->inverseNodeMass;
	const double scale = kick / batch_.massScale[g];
	const Vec<dim>*v = batch_.v.of(g), *force = batch_.force.of(g);
	Vec<dim>* vNext = batch_.vNext.of(g);
	for (int I = 0, count = nodes(); I < count; ++I)
		setToSum<dim>(vNext[I], v[I], scale * inverseMass[I], force[I]);
	if (damper_ && damper_->acts(batch_, g)) damper_->addImpulses(batch_, g, kick);
	if (!load.isZero()) addVelocities(batch_, g, this->kickOf(g, load, kick));
}

namespace {

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void interpolate(const NodeRows<dim>& rows,
						    const Vec<dim>* field, Vec<dim>* at)
{
	for (int s = 0; s < rows.rows(); ++s)
		at[s] = rows.sum(s, field);
}

template <int dim>
void interpolate(const NodeRows<dim>& rows, const Vec<dim>* field, std::vector<Vec<dim>>& at)
{
	at.resize(rows.rows());
	interpolate<dim>(rows, field, at.data());
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
applyImpulses(const NodeRows<dim>& kicks, const Vec<dim>* impulse, double scale, Vec<dim>* velocity)
{
	for (int s = 0; s < kicks.rows(); ++s)
		if (!impulse[s].isZero(0)) kicks.spread(s, Vec<dim>(scale * impulse[s]), velocity);
}

} // namespace

template <int dim>
void TotalLagrangian<dim>::contactVelocities(int g, std::vector<Vec<dim>>& at) const
{
	interpolate<dim>(contactValues(g), batch_.vNext.of(g), at);
}

template <int dim>
void TotalLagrangian<dim>::contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const
{
	interpolate<dim>(contactValues(g), batch_.v.of(g), at);
}

template <int dim>
void TotalLagrangian<dim>::applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse)
{
	const NodeRows<dim>& kicks =
		usesOwnNodes(g) ? ownNodes_[g].kicks : batch_.reference->contactKicks;
	applyImpulses<dim>(kicks, impulse.data(), 1 / batch_.massScale[g], batch_.vNext.of(g));
}

template <int dim> bool TotalLagrangian<dim>::hasFiniteVelocities(int g) const
{
	if (isRigid_[g]) return rigid_[g].hasFiniteVelocities();
	return isFinite(batch_.vNext, g, nodes());
}

template <int dim> double TotalLagrangian<dim>::kineticEnergy(int g) const
{
	if (isRigid_[g]) return rigid_[g].kineticEnergy(shape_[g]);
	return softgrain::kineticEnergy(batch_, batch_.v, batch_.vNext, g);
}

template <int dim>
void TotalLagrangian<dim>::addLoadWork(int g, double kick, const BodyLoad<dim>& load,
				       double& before, double& after) const
{
	if (isRigid_[g]) {
		const double share = 0.5 * kick * shape_[g].mass;
		const RigidMotion<dim>& motion = rigid_[g];
		before += share * motion.power(motion.velocity, motion.momentum, load.acceleration,
					       load.angular);
		after += share * motion.power(motion.velocityNext, motion.momentumNext,
					      load.acceleration, load.angular);
		return;
	}
	before += 0.5 * kick * load.acceleration.dot(momentum(batch_, batch_.v, g));
	after += 0.5 * kick * load.acceleration.dot(momentum(batch_, batch_.vNext, g));
	if (load.angular.isZero(0)) return;
	const RigidVelocities<dim> added =
		this->kickOf(g, { Vec<dim>::Zero(), load.angular }, kick);
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> impulse = batch_.nodeMass(g, I) * added.at(batch_.x.get(g, I));
		before += 0.5 * impulse.dot(batch_.v.get(g, I));
		after += 0.5 * impulse.dot(batch_.vNext.get(g, I));
	}
}

template <int dim>
void TotalLagrangian<dim>::addDampingLoss(int g, double kick, double& before, double& after) const
{
	if (damper_ && !isRigid_[g] && damper_->acts(batch_, g))
		damper_->addLoss(batch_, g, kick, before, after);
}

template <int dim> void TotalLagrangian<dim>::prepareMove(int threads)
{
	if (pointVelocities_) pointVelocities_->update(batch_, threads);
}

template <int dim> void TotalLagrangian<dim>::move(int g, double dt)
{
	if (isRigid_[g]) {
		rigid_[g].move(dt, shape_[g]);
		nodesWritten_[g] = 0;
	} else
		moveNodes(g, dt);
}

template <int dim> void TotalLagrangian<dim>::moveNodes(int g, double dt)
{
	holder_.followMove(batch_, g, dt);
	const Vec<dim>* vNext = batch_.vNext.of(g);
	Vec<dim>* x = batch_.x.of(g);
	for (int I = 0, count = nodes(); I < count; ++I)
		addScaled<dim>(x[I], dt, vNext[I]);
	if (!pointVelocities_) batch_.v.exchange(g, batch_.vNext);
}

template <int dim> VectorRange<dim> TotalLagrangian<dim>::contactVelocityRange(int g) const
{
	if (isRigid_[g]) return rigidBounds(g).velocities;
	std::vector<Vec<dim>> v;
	interpolate<dim>(batch_.reference->contactValues, batch_.v.of(g), v);
	return rangeOf<dim>(v);
}

template <int dim>
void TotalLagrangian<dim>::contactPositions(int g, std::vector<Vec<dim>>& at) const
{
	if (isRigid_[g]) {
		at.resize(batch_.reference->contactNodes());
		for (std::size_t s = 0; s < at.size(); ++s)
			at[s] = batch_.grain[g].origin +
				rigid_[g].positionOf(
					batch_.grain[g].radius *
						batch_.reference->contactMesh.vertex[s],
					shape_[g]);
		return;
	}
	interpolate<dim>(batch_.reference->contactValues, batch_.x.of(g), at);
	for (Vec<dim>& x : at)
		x += batch_.grain[g].origin;
}

template <int dim>
void TotalLagrangian<dim>::massPoints(int g, std::vector<Vec<dim>>& position,
				      std::vector<double>& mass) const
{
	const auto& reference = *batch_.reference;
	for (int p = 0; p < reference.points(); ++p) {
		position.push_back(
			batch_.grain[g].origin +
			(isRigid_[g] ? rigid_[g].positionOf(batch_.grain[g].radius *
								    reference.pointPosition[p],
							    shape_[g])
				     : pointAt(g, p)));
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
	const GrainTemplate<dim>& reference = *batch_.reference;
	ownNodes_[g] = { NodeRows<dim>(rows, nodes()),
			 kickRows<dim>(rows, reference.inverseNodeMass),
			 delassusTable(rows, reference.nodeMass) };
}

template <int dim> double TotalLagrangian<dim>::presentKineticEnergy(int g) const
{
	writeNodes(g);
	if (!pointVelocities_) return softgrain::kineticEnergy(batch_, batch_.v, batch_.v, g);
	double sum = 0;
	for (int p = 0; p < batch_.reference->points(); ++p)
		sum += batch_.reference->pointVolume[p] * pointVelocities_->get(g, p).squaredNorm();
	return 0.5 * batch_.massScale[g] * sum;
}

template class TotalLagrangian<2>;
template class TotalLagrangian<3>;

} // namespace softgrain
