#include "grain/TotalLagrangian.hpp"
#include "grain/CriticalTimeStep.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace softgrain {

namespace {

/// Strain below which a grain counts as undeformed: the energy dropped when it becomes rigid, its
/// square times that of a wave of unit strain, is lost in the rounding of the energy of any motion.
constexpr double undeformedStrain = 1e-8;
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

namespace {

/// A contact node is no faster than this times the fastest background node.
template <int dim> double largestShareSum(const GrainTemplate<dim>& reference)
{
	const SparseRows<double>& shapes = reference.contactShapes;
	double largest = 0;
	for (int s = 0; s < shapes.rows(); ++s) {
		double sum = 0;
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			sum += std::abs(shapes.value[k]);
		largest = std::max(largest, sum);
	}
	return largest;
}

} // namespace

template <int dim>
TotalLagrangian<dim>::TotalLagrangian(Batch<dim> batch, const Scheme& scheme)
	: batch_(std::move(batch))
	, ownNodes_(batch_.grains())
	, holder_(batch_.grains())
	, computed_(batch_.grains())
	, criticalTimeStep_(criticalTimeSteps(*batch_.reference, batch_.condition, batch_.grain))
	, shareSum_(largestShareSum(*batch_.reference))
	, rigid_(batch_.grains())
	, isRigid_(batch_.grains(), 0)
	, nodesWritten_(batch_.grains(), 1)
{
	std::iota(computed_.begin(), computed_.end(), 0);
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
		const double rim = outlineRadius_ * own.radius;
		limits_.push_back(
			{ spinStrain * wave * wave / (rim * rim),
			  undeformedStrain * undeformedStrain * shape_[g].mass * wave * wave });
		const double shear = std::sqrt(own.constants.mu() / own.constants.density);
		rest_.emplace_back(own.damping, slowestPeriod * rim * outlineRadius_ /
							(reference.inradius * shear));
	}
}

template <int dim>
double TotalLagrangian<dim>::vibrationEnergy(int g, const WholeGrain<dim>& whole) const
{
	const Mat<dim> spin = spinMatrix<dim>(whole.angularVelocity);
	double sum = 0;
	auto add = [&](double mass, const Vec<dim>& x, const Vec<dim>& v) {
		sum += 0.5 * mass * (v - whole.velocity - spin * (x - whole.centre)).squaredNorm();
	};
	if (pointVelocities_)
		for (int p = 0; p < batch_.reference->points(); ++p)
			add(batch_.massScale[g] * batch_.reference->pointVolume[p], pointAt(g, p),
			    pointVelocities_->get(g, p));
	else
		for (int I = 0; I < nodes(); ++I)
			add(batch_.nodeMass(g, I), batch_.x.get(g, I), batch_.v.get(g, I));
	return sum;
}

template <int dim> bool TotalLagrangian<dim>::mayMoveRigidly(int g) const
{
	const RigidLimits& limits = limits_[g];
	if (isRigid_[g])
		return rigid_[g].angularVelocity(shape_[g]).squaredNorm() <= limits.squaredSpin;
	if (!(batch_.report[g].elasticEnergy <= limits.energy)) return false; // most often
	const WholeGrain<dim> whole = wholeOfParticles(g);
	return whole.angularVelocity.squaredNorm() <= limits.squaredSpin &&
	       vibrationEnergy(g, whole) <= limits.energy;
}

template <int dim> void TotalLagrangian<dim>::beginRigidMotion(int g)
{
	rigid_[g] = rigidMotionOf<dim>(wholeOfParticles(g));
	isRigid_[g] = 1;
	++this->changesOfActivity_;
	nodesWritten_[g] = 0;
	batch_.report[g] = {};
	holder_.forget(g);
}

template <int dim> void TotalLagrangian<dim>::endRigidMotion(int g)
{
	writeNodes(g);
	isRigid_[g] = 0;
	++this->changesOfActivity_;
	std::fill_n(batch_.force.of(g), nodes(), Vec<dim>::Zero());
	if (damper_) damper_->forget(g);
}

template <int dim> void TotalLagrangian<dim>::arrangeGrains()
{
	std::vector<int> active;
	for (int g = 0; g < grains(); ++g)
		if (!isRigid_[g] && !isAsleep(g)) active.push_back(g);
	computeFirst(std::move(active));
}

/// Lays the grains into the blocks that are computed, in their order.
template <int dim> void TotalLagrangian<dim>::computeFirst(std::vector<int> chosen)
{
	std::vector<int> others;
	auto next = chosen.begin();
	for (int g = 0; g < grains(); ++g)
		if (next != chosen.end() && *next == g)
			++next;
		else
			others.push_back(g);
	batch_.arrange(chosen, others);
	computed_ = std::move(chosen);
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

template <int dim> double TotalLagrangian<dim>::watchRest(int g, double dt)
{
	RestWatch& rest = rest_[g];
	if (!rest.mayRest()) return 0;
	const double kinetic = softgrain::kineticEnergy(batch_, batch_.v, batch_.v, g);
	return rest.count(rest.isCalm(kinetic, batch_.report[g].elasticEnergy), dt);
}

template <int dim> Vec<dim> TotalLagrangian<dim>::fallAsleep(int g)
{
	rest_[g].fallAsleep();
	++this->changesOfActivity_;
	Vec<dim> momentum = Vec<dim>::Zero();
	if (isRigid_[g]) return momentum;
	for (int I = 0; I < nodes(); ++I)
		momentum += batch_.nodeMass(g, I) * batch_.vNext.get(g, I);
	std::fill_n(batch_.vNext.of(g), nodes(), Vec<dim>::Zero());
	if (damper_) damper_->stop(g);
	return momentum;
}

template <int dim> void TotalLagrangian<dim>::wake(int g)
{
	rest_[g].wake();
	++this->changesOfActivity_;
}

namespace {

template <int dim> std::array<double, 5> materialNumbers(const GrainParameters<dim>& grain)
{
	const ElasticConstants& c = grain.constants;
	return { c.young, c.poisson, c.density, grain.damping.mass, grain.damping.stiffness };
}

} // namespace

/// Calm time; of a sleeping grain also the material it rests with, what was known of it, and the
/// forces of its nodes, so that nothing is computed when it is loaded or woken.
template <int dim> std::vector<double> TotalLagrangian<dim>::restNumbers(int g) const
{
	const RestWatch& rest = rest_[g];
	if (rest.calmTime() == 0) return {};
	std::vector<double> numbers { rest.calmTime() };
	if (!rest.isAsleep()) return numbers;
	const BulkReport& report = batch_.report[g];
	for (double number : materialNumbers(batch_.grain[g]))
		numbers.push_back(number);
	numbers.insert(numbers.end(),
		       { report.elasticEnergy, report.stiffening, rateStiffening(g) });
	for (int I = 0; I < nodes(); ++I)
		for (int a = 0; a < dim; ++a)
			numbers.push_back(batch_.force.get(g, I)[a]);
	return numbers;
}

/// A grain that has another material now is awake.
template <int dim> void TotalLagrangian<dim>::restoreRest(int g, const std::vector<double>& numbers)
{
	rest_[g].wake();
	if (numbers.empty()) return;
	if (numbers.size() == 1) return rest_[g].restore(numbers[0], false);
	const auto material = materialNumbers(batch_.grain[g]);
	const int figures = 1 + static_cast<int>(material.size()), forces = figures + 3;
	requireSize("figures at rest", numbers, forces + nodes() * dim);
	if (!std::equal(material.begin(), material.end(), numbers.begin() + 1)) return;
	rest_[g].restore(numbers[0], true);
	batch_.report[g].elasticEnergy = numbers[figures];
	batch_.report[g].stiffening = numbers[figures + 1];
	damper_->setRateStiffening(g, numbers[figures + 2]);
	for (int I = 0; I < nodes(); ++I)
		batch_.force.set(g, I, Eigen::Map<const Vec<dim>>(&numbers[forces + I * dim]));
}

template <int dim> RigidBounds<dim> TotalLagrangian<dim>::rigidBounds(int g) const
{
	const RigidMotion<dim>& motion = rigid_[g];
	const double R = batch_.grain[g].radius;
	RigidBounds<dim> bounds;
	bounds.centre = batch_.grain[g].origin + motion.centre;
	bounds.radius = R * outlineRadius_;
	bounds.bulge = R * outlineBulge_;
	bounds.speed =
		motion.velocity.norm() + motion.angularVelocity(shape_[g]).norm() * bounds.radius;
	return bounds;
}

template <int dim> void TotalLagrangian<dim>::writeNodes(int g) const
{
	if (nodesWritten_[g]) return;
	nodesWritten_[g] = 1;
	const RigidMotion<dim>& motion = rigid_[g];
	const double R = batch_.grain[g].radius;
	const Mat<dim> spin = spinMatrix<dim>(motion.angularVelocity(shape_[g]));
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> x =
			motion.positionOf(R * batch_.reference->nodePosition[I], shape_[g]);
		batch_.x.set(g, I, x);
		batch_.v.set(g, I, motion.velocity + spin * (x - motion.centre));
	}
	if (!pointVelocities_) return;
	pointVelocities_->takeFromNodes(batch_, g);
	pointVelocities_->mapToNodes(batch_, g);
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

template <int dim>
void TotalLagrangian<dim>::predictVelocities(int g, double kick, const BodyLoad<dim>& load)
{
	if (isRigid_[g]) {
		rigid_[g].accelerate(kick, load.acceleration, load.angular, shape_[g]);
		return;
	}
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
	if (damper_ && damper_->acts(batch_, g)) damper_->addImpulses(batch_, g, kick);
	if (!loaded) return;
	for (int I = 0; I < nodes(); ++I)
		vNext[I] +=
			kick * (load.acceleration + load.angular * (batch_.x.get(g, I) - centre));
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
	if (isRigid_[g]) return rigid_[g].hasFiniteVelocities();
	// What is not finite leaves no zero.
	const Vec<dim>* v = batch_.vNext.of(g);
	Vec<dim> sum = Vec<dim>::Zero();
	for (int I = 0; I < nodes(); ++I)
		addScaled<dim>(sum, 0, v[I]);
	return sum.isZero(0);
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
	const Vec<dim> centre = whole(g).centre;
	for (int I = 0; I < nodes(); ++I) {
		const Vec<dim> impulse =
			kick * batch_.nodeMass(g, I) *
			(load.acceleration + load.angular * (batch_.x.get(g, I) - centre));
		before += 0.5 * impulse.dot(batch_.v.get(g, I));
		after += 0.5 * impulse.dot(batch_.vNext.get(g, I));
	}
}

template <int dim>
void TotalLagrangian<dim>::addDampingLoss(int g, double& before, double& after) const
{
	if (damper_ && !isRigid_[g] && damper_->acts(batch_, g))
		damper_->addLoss(batch_, g, before, after);
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
	Vec<dim>*x = batch_.x.of(g), *v = batch_.v.of(g);
	for (int I = 0; I < nodes(); ++I) {
		addScaled<dim>(x[I], dt, vNext[I]);
		if (!pointVelocities_) v[I] = vNext[I];
	}
}

namespace {

/// In point spacings per critical time step: slower grains cannot close a gap worth counting
/// within some steps (System::reach), so that a coarse bound of their speed does.
constexpr double slowSpeed = 0.005;

} // namespace

template <int dim> double TotalLagrangian<dim>::fastestContactNode(int g) const
{
	if (isRigid_[g]) return rigidBounds(g).speed;
	const double bound = shareSum_ * largestNorm<dim>(batch_.v.of(g), nodes());
	const double slow = slowSpeed * batch_.reference->pointSpacing() * batch_.grain[g].radius /
			    criticalTimeStep_[g];
	if (bound <= slow) return bound;
	std::vector<Vec<dim>> v;
	interpolate(batch_.reference->contactShapes, g, batch_.v, v);
	return largestNorm<dim>(v);
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
	interpolate(batch_.reference->contactShapes, g, batch_.x, at);
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
	ownNodes_[g].delassus = delassusTable(rows, batch_.reference->nodeMass);
	ownNodes_[g].shapes = std::move(rows);
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

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodePositions(int g) const
{
	writeNodes(g);
	std::vector<Vec<dim>> x;
	for (int I = 0; I < nodes(); ++I)
		x.push_back(batch_.position(g, I));
	return x;
}

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodeVelocities(int g) const
{
	writeNodes(g);
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
	isRigid_[g] = 0;
	wake(g);
	nodesWritten_[g] = 1;
	holder_.forget(g);
	batch_.place(g, rotation, velocity, spin);
	if (!pointVelocities_) return;
	pointVelocities_->takeFromNodes(batch_, g);
	pointVelocities_->mapToNodes(batch_, g);
}

template <int dim>
void TotalLagrangian<dim>::moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
				       const Vec<dim>& velocity, const Mat<dim>& spin)
{
	if (isRigid_[g]) {
		rigid_[g].add(rotation, shift, velocity, spin, shape_[g]);
		nodesWritten_[g] = 0;
		return;
	}
	holder_.forget(g); // forces turn with the grain
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
	writeNodes(g);
	GrainState s;
	if (isRigid_[g]) s.rigid = rigid_[g].numbers();
	s.held = heldForces(g);
	s.rest = restNumbers(g);
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
	if (!s.rigid.empty()) {
		requireSize("rigid motion", s.rigid, RigidMotion<dim>::numberCount);
		rigid_[g] = RigidMotion<dim>::fromNumbers(s.rigid);
	}
	isRigid_[g] = !s.rigid.empty();
	restoreRest(g, s.rest);
	++this->changesOfActivity_;
	nodesWritten_[g] = 1;
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
	setHeldForces(g, s.held);
}

template <int dim> std::vector<double> TotalLagrangian<dim>::heldForces(int g) const
{
	std::vector<double> numbers;
	if (!holder_.holds(g)) return numbers;
	holder_.append(batch_, g, numbers);
	if (damper_) damper_->append(g, numbers);
	return numbers;
}

template <int dim>
void TotalLagrangian<dim>::setHeldForces(int g, const std::vector<double>& numbers)
{
	holder_.forget(g);
	if (numbers.empty()) return;
	const int own = ForceHolder<dim>::numberCount(batch_);
	requireSize("forces", numbers, own + (damper_ ? damper_->numberCount() : 0));
	holder_.restore(batch_, g, numbers.data());
	if (damper_) damper_->restore(g, numbers.data() + own);
}

template class TotalLagrangian<2>;
template class TotalLagrangian<3>;

} // namespace softgrain
