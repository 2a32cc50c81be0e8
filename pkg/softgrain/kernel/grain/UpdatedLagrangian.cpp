#include "grain/UpdatedLagrangian.hpp"
#include "Numbers.hpp"
#include "grain/CriticalTimeStep.hpp"
#include "material/Dispatch.hpp"
#include "reference/BackgroundGrid.hpp"

#include <cmath>
#include <memory>

namespace softgrain {

namespace {

/// Width of a grain over that of the undeformed one at which it has fallen apart: a guard against
/// grids without bounds.
constexpr double widestStretch = 20;

} // namespace

template <int dim>
UpdatedLagrangian<dim>::UpdatedLagrangian(std::shared_ptr<const GrainTemplate<dim>> reference,
					  Law law, Condition condition,
					  const std::vector<GrainParameters<dim>>& grains,
					  double picShare)
	: reference_(std::move(reference))
	, law_(law)
	, condition_(condition)
	, parameters_(grains)
	, grain_(grains.size())
	, picShare_(picShare)
{
	checkGrains(condition, grains);
	criticalTimeStep_ = criticalTimeSteps(*reference_, condition_, parameters_);
	// the grid in space is as fine along all axes, that of a block's template may be coarser
	const double finer = reference_->recipe.nodeSpacing * reference_->pointSpacing() /
			     reference_->gridSteps.maxCoeff();
	for (double& step : criticalTimeStep_)
		step *= pointVelocityTimeStepShare * std::min(finer, 1.);
	for (const Vec<dim>& X : reference_->pointPosition)
		width_ = std::max(width_, 2 * X.cwiseAbs().maxCoeff());
	const int padded = (pointCount() + laneWidth - 1) / laneWidth * laneWidth;
	for (int g = 0; g < this->grains(); ++g) {
		UpdatedGrain<dim>& grain = grain_[g];
		const GrainParameters<dim>& own = parameters_[g];
		grain.spacing =
			own.radius * reference_->recipe.nodeSpacing * reference_->pointSpacing();
		grain.lame = LameConstants::ofAll(own.constants);
		grain.mass.assign(padded, 0.);
		grain.volume.assign(padded, 0.);
		for (int p = 0; p < pointCount(); ++p) {
			grain.volume[p] = std::pow(own.radius, dim) * reference_->pointVolume[p];
			grain.mass[p] = own.constants.density * grain.volume[p];
		}
		for (auto* field : { &grain.x, &grain.v })
			for (std::vector<double>& component : *field)
				component.assign(padded, 0.);
		for (std::vector<double>& component : grain.F)
			component.assign(padded, 0.);
		grain.contactX.resize(reference_->contactNodes());
		grain.contactV.resize(reference_->contactNodes());
		place(g, Mat<dim>::Identity(), Vec<dim>::Zero(), Mat<dim>::Zero());
	}
}

// --- points -------------------------------------------------------------------------------------

template <int dim> Vec<dim> UpdatedLagrangian<dim>::pointAt(int g, int p) const
{
	Vec<dim> x;
	for (int a = 0; a < dim; ++a)
		x[a] = grain_[g].x[a][p];
	return x;
}

template <int dim> Vec<dim> UpdatedLagrangian<dim>::velocityAt(int g, int p) const
{
	Vec<dim> v;
	for (int a = 0; a < dim; ++a)
		v[a] = grain_[g].v[a][p];
	return v;
}

template <int dim> Mat<dim> UpdatedLagrangian<dim>::gradientAt(int g, int p) const
{
	Mat<dim> F;
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			F(a, b) = grain_[g].F[a * dim + b][p];
	return F;
}

template <int dim>
void UpdatedLagrangian<dim>::setPoint(int g, int p, const Vec<dim>& x, const Vec<dim>& v,
				      const Mat<dim>& F)
{
	for (int a = 0; a < dim; ++a) {
		grain_[g].x[a][p] = x[a];
		grain_[g].v[a][p] = v[a];
		for (int b = 0; b < dim; ++b)
			grain_[g].F[a * dim + b][p] = F(a, b);
	}
}

/// The points that only fill up the lanes stay where the first point is.
template <int dim> void UpdatedLagrangian<dim>::fillUp(int g)
{
	for (int p = pointCount(); p < static_cast<int>(grain_[g].mass.size()); ++p)
		setPoint(g, p, pointAt(g, 0), velocityAt(g, 0), gradientAt(g, 0));
}

// --- the phases of a step -----------------------------------------------------------------------

/// Mass, momentum, force and report; whether there is a grid: not where points are too far apart.
template <int dim> bool UpdatedLagrangian<dim>::mapToGrid(int g)
{
	const int order = reference_->recipe.order;
	if (!grain_[g].layGrid(order, widestStretch * width_ * parameters_[g].radius)) return false;
	grain_[g].pointsToGrid(order, law_, condition_);
	return true;
}

template <int dim> int UpdatedLagrangian<dim>::updateForces(const ForceSchedule& schedule)
{
	const int count = grains();
#pragma omp parallel for schedule(static) num_threads(schedule.threads)
	for (int g = 0; g < count; ++g) {
		UpdatedGrain<dim>& grain = grain_[g];
		if (!mapToGrid(g)) continue;
		grain.grid.tieLightNodes(lightNodeShare);
		for (int I : grain.grid.carrying())
			for (int a = 0; a < dim; ++a)
				grain.grid.velocity[a][I] /= grain.grid.mass[I];
	}
	return count;
}

template <int dim> Vec<dim> UpdatedLagrangian<dim>::nodeAt(int g, int node) const
{
	const auto index = grain_[g].grid.indexOf(node);
	Vec<dim> x;
	for (int a = 0; a < dim; ++a)
		x[a] = grain_[g].spacing * index[a];
	return x;
}

template <int dim>
void UpdatedLagrangian<dim>::predictVelocities(int g, double kick, const BodyLoad<dim>& load)
{
	SpatialGrid<dim>& grid = grain_[g].grid;
	for (int I : grid.carrying())
		for (int a = 0; a < dim; ++a)
			grid.velocityNext[a][I] =
				grid.velocity[a][I] + kick * (grid.force[a][I] / grid.mass[I]);
	if (load.isZero()) return;
	const RigidVelocities<dim> added = this->kickOf(g, load, kick);
	for (int I : grid.carrying()) {
		const Vec<dim> change = added.at(nodeAt(g, I));
		for (int a = 0; a < dim; ++a)
			grid.velocityNext[a][I] += change[a];
	}
}

template <int dim> ContactMobility<dim> UpdatedLagrangian<dim>::contactMobility(int g)
{
	grain_[g].findContactMobility(reference_->recipe.order);
	return { &grain_[g].delassus, nullptr, 1 };
}

namespace {

template <int dim>
void interpolate(const SparseRows<double>& shapes, const GridField<dim>& field,
		 std::vector<Vec<dim>>& at)
{
	at.assign(shapes.rows(), Vec<dim>::Zero());
	for (int s = 0; s < shapes.rows(); ++s)
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			for (int a = 0; a < dim; ++a)
				at[s][a] += shapes.value[k] * field[a][shapes.column[k]];
}

} // namespace

template <int dim>
void UpdatedLagrangian<dim>::contactVelocities(int g, std::vector<Vec<dim>>& at) const
{
	interpolate<dim>(grain_[g].contactShapes, grain_[g].grid.velocityNext, at);
}

template <int dim>
void UpdatedLagrangian<dim>::contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const
{
	interpolate<dim>(grain_[g].contactShapes, grain_[g].grid.velocity, at);
}

template <int dim>
void UpdatedLagrangian<dim>::applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse)
{
	UpdatedGrain<dim>& grain = grain_[g];
	const SparseRows<double>& shapes = grain.contactShapes;
	for (int s = 0; s < shapes.rows(); ++s) {
		if (impulse[s].isZero(0)) continue;
		for (int k = shapes.begin(s); k < shapes.end(s); ++k) {
			const int I = shapes.column[k];
			const double share = shapes.value[k] / grain.grid.mass[I];
			for (int a = 0; a < dim; ++a)
				grain.grid.velocityNext[a][I] += share * impulse[s][a];
		}
	}
}

template <int dim> bool UpdatedLagrangian<dim>::hasFiniteVelocities(int g) const
{
	for (const std::vector<double>& component : grain_[g].grid.velocityNext)
		for (int I : grain_[g].grid.carrying())
			if (!std::isfinite(component[I])) return false;
	return true;
}

template <int dim> double UpdatedLagrangian<dim>::kineticEnergy(int g) const
{
	const SpatialGrid<dim>& grid = grain_[g].grid;
	double sum = 0;
	for (int I : grid.carrying())
		for (int a = 0; a < dim; ++a)
			sum += grid.mass[I] * grid.velocity[a][I] * grid.velocityNext[a][I];
	return 0.5 * sum;
}

template <int dim>
void UpdatedLagrangian<dim>::addLoadWork(int g, double kick, const BodyLoad<dim>& load,
					 double& before, double& after) const
{
	const SpatialGrid<dim>& grid = grain_[g].grid;
	const RigidVelocities<dim> added = this->kickOf(g, load, kick);
	for (int I : grid.carrying()) {
		const Vec<dim> impulse = grid.mass[I] * added.at(nodeAt(g, I));
		for (int a = 0; a < dim; ++a) {
			before += 0.5 * impulse[a] * grid.velocity[a][I];
			after += 0.5 * impulse[a] * grid.velocityNext[a][I];
		}
	}
}

template <int dim> void UpdatedLagrangian<dim>::move(int g, double dt)
{
	grain_[g].grid.followTies(grain_[g].grid.velocity);
	grain_[g].grid.followTies(grain_[g].grid.velocityNext);
	grain_[g].gridToPoints(reference_->recipe.order, dt, picShare_);
}

template <int dim> VectorRange<dim> UpdatedLagrangian<dim>::contactVelocityRange(int g) const
{
	return rangeOf<dim>(grain_[g].contactV);
}

template <int dim>
void UpdatedLagrangian<dim>::contactPositions(int g, std::vector<Vec<dim>>& at) const
{
	at.resize(grain_[g].contactX.size());
	for (std::size_t s = 0; s < at.size(); ++s)
		at[s] = parameters_[g].origin + grain_[g].contactX[s];
}

// --- what others ask and set --------------------------------------------------------------------

template <int dim> WholeGrain<dim> UpdatedLagrangian<dim>::whole(int g) const
{
	return wholeOf<dim>(pointCount(), [&](int p) {
		return Particle<dim> { grain_[g].mass[p], pointAt(g, p), velocityAt(g, p),
				       reference_->pointPosition[p] };
	});
}

template <int dim> double UpdatedLagrangian<dim>::presentKineticEnergy(int g) const
{
	double sum = 0;
	for (int p = 0; p < pointCount(); ++p)
		sum += grain_[g].mass[p] * velocityAt(g, p).squaredNorm();
	return 0.5 * sum;
}

template <int dim> std::vector<PointResponse<dim>> UpdatedLagrangian<dim>::points(int g) const
{
	const UpdatedGrain<dim>& grain = grain_[g];
	std::vector<PointResponse<dim>> responses;
	withLaw<dim>(law_, condition_, [&](auto evaluator) {
		PointLanes<dim> point;
		OutOfPlane out;
		for (int p = 0; p < pointCount(); ++p) {
			const int lane = p % laneWidth;
			for (int a = 0; a < dim && lane == 0; ++a)
				for (int b = 0; b < dim; ++b)
					point.F[a][b] = loadLanes(&grain.F[a * dim + b][p]);
			if (lane == 0) {
				evaluator.evaluate(point, grain.lame);
				out = evaluator.outOfPlane(point, grain.lame, lnOf(point.J));
			}
			PointResponse<dim> r = pointResponse(point, lane, out);
			r.position = parameters_[g].origin + pointAt(g, p);
			r.volume = grain.volume[p] * r.J;
			responses.push_back(r);
		}
	});
	return responses;
}

template <int dim> std::vector<Vec<dim>> UpdatedLagrangian<dim>::nodePositions(int g) const
{
	std::vector<Vec<dim>> x;
	for (int p = 0; p < pointCount(); ++p)
		x.push_back(parameters_[g].origin + pointAt(g, p));
	return x;
}

template <int dim> std::vector<Vec<dim>> UpdatedLagrangian<dim>::nodeVelocities(int g) const
{
	std::vector<Vec<dim>> v;
	for (int p = 0; p < pointCount(); ++p)
		v.push_back(velocityAt(g, p));
	return v;
}

template <int dim>
void UpdatedLagrangian<dim>::place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
				   const Mat<dim>& spin)
{
	const double R = parameters_[g].radius;
	for (int p = 0; p < pointCount(); ++p) {
		const Vec<dim> x = R * (rotation * reference_->pointPosition[p]);
		setPoint(g, p, x, velocity + spin * x, rotation);
	}
	fillUp(g);
	for (int s = 0; s < reference_->contactNodes(); ++s) {
		const Vec<dim> x = R * (rotation * reference_->contactMesh.vertex[s]);
		grain_[g].contactX[s] = x;
		grain_[g].contactV[s] = velocity + spin * x;
	}
}

template <int dim>
void UpdatedLagrangian<dim>::moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
					 const Vec<dim>& velocity, const Mat<dim>& spin)
{
	const Vec<dim> centre = whole(g).centre;
	for (int p = 0; p < pointCount(); ++p) {
		const Vec<dim> arm = rotation * (pointAt(g, p) - centre);
		setPoint(g, p, centre + arm + shift,
			 rotation * velocityAt(g, p) + velocity + spin * arm,
			 rotation * gradientAt(g, p));
	}
	fillUp(g);
	for (std::size_t s = 0; s < grain_[g].contactX.size(); ++s) {
		const Vec<dim> arm = rotation * (grain_[g].contactX[s] - centre);
		grain_[g].contactX[s] = centre + arm + shift;
		grain_[g].contactV[s] = rotation * grain_[g].contactV[s] + velocity + spin * arm;
	}
}

template <int dim> GrainState UpdatedLagrangian<dim>::state(int g) const
{
	GrainState s;
	for (int p = 0; p < pointCount(); ++p) {
		append(s.x, pointAt(g, p));
		append(s.v, velocityAt(g, p));
		append(s.F, gradientAt(g, p));
	}
	for (std::size_t k = 0; k < grain_[g].contactX.size(); ++k) {
		append(s.x, grain_[g].contactX[k]);
		append(s.v, grain_[g].contactV[k]);
	}
	return s;
}

template <int dim> void UpdatedLagrangian<dim>::setState(int g, const GrainState& s)
{
	const int contacts = reference_->contactNodes();
	requireSize("positions", s.x, (pointCount() + contacts) * dim);
	requireSize("velocities", s.v, (pointCount() + contacts) * dim);
	requireSize("deformation gradients", s.F, pointCount() * dim * dim);
	NumbersInTurn x(s.x), v(s.v), F(s.F);
	for (int p = 0; p < pointCount(); ++p)
		setPoint(g, p, x.next<Vec<dim>>(), v.next<Vec<dim>>(), F.next<Mat<dim>>());
	fillUp(g);
	for (int k = 0; k < contacts; ++k) {
		x.take(grain_[g].contactX[k]);
		v.take(grain_[g].contactV[k]);
	}
	mapToGrid(g); // the energy is to be told before the next forces are computed
}

template class UpdatedLagrangian<2>;
template class UpdatedLagrangian<3>;

} // namespace softgrain
