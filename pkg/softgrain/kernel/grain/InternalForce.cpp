#include "grain/InternalForce.hpp"
#include "grain/BlockField.hpp"
#include "material/Dispatch.hpp"

#include <cmath>
#include <type_traits>
#include <vector>

namespace softgrain {

namespace {

template <int dim>
void gatherGradient(const GrainTemplate<dim>& reference, const BlockField<dim>& x, int p,
		    const Lanes& inverseRadius, PointLanes<dim>& point)
{
	Lanes sum[dim][dim] = {}; // local, so that it can stay in registers
	const auto& shapes = reference.pointShapes;
	for (int k = shapes.begin(p); k < shapes.end(p); ++k)
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				sum[a][b] += x.at(shapes.column[k], a) * shapes.value[k].G[b];
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			point.F[a][b] = sum[a][b] * inverseRadius;
}

/// f_I -= weight P G_I
template <int dim>
void scatterForce(const GrainTemplate<dim>& reference, int p, const PointLanes<dim>& point,
		  const Lanes& weight, BlockField<dim>& force)
{
	Lanes P[dim][dim];
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			P[a][b] = weight * point.P[a][b];
	const auto& shapes = reference.pointShapes;
	for (int k = shapes.begin(p); k < shapes.end(p); ++k)
		for (int a = 0; a < dim; ++a) {
			Lanes sum = {};
			for (int b = 0; b < dim; ++b)
				sum += P[a][b] * shapes.value[k].G[b];
			force.at(shapes.column[k], a) -= sum;
		}
}

/// Scales of a block's lanes: gradients with 1/R, point volumes with R^dim.
struct BlockScales {
	Lanes inverseRadius, volume, volumeOverRadius;
};

template <int dim> BlockScales blockScales(const Batch<dim>& batch, int block)
{
	BlockScales s;
	for (int l = 0; l < laneWidth; ++l) {
		const int g = batch.grainInLane(block, l);
		s.inverseRadius[l] = 1 / batch.grain[g].radius;
		s.volume[l] = batch.pointScale[g];
	}
	s.volumeOverRadius = s.volume * s.inverseRadius;
	return s;
}

/// Stress from F, every point on its own.
template <int dim, class LawEvaluator> struct PointwiseLaw {
	PointwiseLaw(const Batch<dim>& batch, int block, const BlockField<dim>&)
		: lame(batch.lame[block])
	{
	}
	void evaluate(int, PointLanes<dim>& point) const { LawEvaluator::evaluate(point, lame); }
	/// The volumetric strain that the stress was computed with, plane strain and 3D.
	double theta(int, const PointLanes<dim>& point, int lane) const
	{
		return std::log(point.J[lane]);
	}

	const LameConstants& lame;
};

/// Stress from F and theta = Pi ln J, the projection over all points of the grain.
template <int dim, class LawEvaluator> struct ProjectedLaw {
	ProjectedLaw(const Batch<dim>& batch, int block, const BlockField<dim>& x)
		: lame(batch.lame[block])
		, theta_(static_cast<std::size_t>(batch.reference->points()) * laneWidth)
	{
		const BlockScales scales = blockScales(batch, block);
		PointLanes<dim> point;
		for (int p = 0; p < batch.reference->points(); ++p) {
			gatherGradient(*batch.reference, x, p, scales.inverseRadius, point);
			storeLanes(&theta_[p * laneWidth], LawEvaluator::volumetricStrain(point));
		}
		project<laneWidth>(batch.reference->pressureSpace, batch.reference->pointVolume,
				   theta_.data());
	}
	void evaluate(int p, PointLanes<dim>& point) const
	{
		LawEvaluator::evaluateProjected(point, lame, loadLanes(&theta_[p * laneWidth]));
	}
	double theta(int p, const PointLanes<dim>&, int lane) const
	{
		return theta_[p * laneWidth + lane];
	}

	const LameConstants& lame;

private:
	std::vector<double> theta_; ///< [point][lane]
};

/// Calls `use` with the type that evaluates the law over a batch: nothing of the projection is in
/// the loops of batches without it.
template <int dim, class Use> void withVolumetricLaw(const Batch<dim>& batch, Use&& use)
{
	withLaw<dim>(batch.law, batch.condition, [&]<class LawEvaluator>(LawEvaluator) {
		if constexpr (LawEvaluator::canProject)
			if (!batch.reference->pressureSpace.empty()) {
				use(std::type_identity<ProjectedLaw<dim, LawEvaluator>> {});
				return;
			}
		use(std::type_identity<PointwiseLaw<dim, LawEvaluator>> {});
	});
}

template <int dim, class VolumetricLaw>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void forceOfBlock(Batch<dim>& batch, int block,
						     std::type_identity<VolumetricLaw>)
{
	const GrainTemplate<dim>& reference = *batch.reference;
	BlockField<dim> x(reference.nodes()), force(reference.nodes());
	x.load(batch.x, batch, block);
	const BlockScales scales = blockScales(batch, block);
	const VolumetricLaw law(batch, block, x);
	Lanes energy = {}, stiffening = {}, invertedPoint = Lanes {} - 1;
	PointLanes<dim> point;
	for (int p = 0; p < reference.points(); ++p) {
		gatherGradient(reference, x, p, scales.inverseRadius, point);
		law.evaluate(p, point);
		const double V = reference.pointVolume[p];
		energy += V * scales.volume * point.energy;
		stiffening = larger(point.stiffening, stiffening);
		const Lanes found = invertedPoint < 0 ? Lanes {} + p : invertedPoint;
		invertedPoint = point.J > 0 ? invertedPoint : found;
		scatterForce(reference, p, point, V * scales.volumeOverRadius, force);
	}
	force.store(batch.force, batch, block);
	for (int l = 0; l < laneWidth && batch.hasGrain(block, l); ++l)
		batch.report[batch.grainInLane(block, l)] = { energy[l], stiffening[l],
							      static_cast<int>(invertedPoint[l]) };
}

} // namespace

template <int dim> void computeInternalForce(Batch<dim>& batch, int threads)
{
	withVolumetricLaw(batch, [&](auto law) {
		const int blocks = batch.activeBlocks();
#pragma omp parallel for schedule(static) num_threads(threads)
		for (int b = 0; b < blocks; ++b)
			forceOfBlock(batch, b, law);
	});
}

template <int dim>
PointResponse<dim> pointResponse(const PointLanes<dim>& point, int lane, Condition condition,
				 const LameConstants& lame)
{
	PointResponse<dim> r;
	Mat<dim> P;
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b) {
			r.F(a, b) = point.F[a][b][lane];
			P(a, b) = point.P[a][b][lane];
		}
	r.J = point.J[lane];
	r.cauchy = P * r.F.transpose() / r.J;
	if (condition == Condition::planeStrain)
		r.cauchy33 = lame.lambda[lane] * std::log(r.J) / r.J;
	if (condition == Condition::planeStress) {
		// forces are per unit reference thickness, Cauchy stress per present one
		r.F33 = expOf(detail::thicknessStrain(lnOf(point.J), lame.lambda, lame.mu))[lane];
		r.cauchy /= r.F33;
	}
	return r;
}

template <int dim> std::vector<PointResponse<dim>> pointResponses(const Batch<dim>& batch, int g)
{
	const int block = batch.blockOf(g), lane = batch.laneOf(g);
	const BlockScales scales = blockScales(batch, block);
	const auto& shapes = batch.reference->pointShapes;
	std::vector<PointResponse<dim>> responses;
	withVolumetricLaw(batch, [&]<class VolumetricLaw>(std::type_identity<VolumetricLaw>) {
		BlockField<dim> x(batch.reference->nodes());
		x.load(batch.x, batch, block);
		const VolumetricLaw law(batch, block, x);
		PointLanes<dim> point;
		for (int p = 0; p < batch.reference->points(); ++p) {
			gatherGradient(*batch.reference, x, p, scales.inverseRadius, point);
			law.evaluate(p, point);
			PointResponse<dim> r =
				pointResponse(point, lane, batch.condition, batch.lame[block]);
			r.position = batch.grain[g].origin;
			for (int k = shapes.begin(p); k < shapes.end(p); ++k)
				r.position += shapes.value[k].N * batch.x.get(g, shapes.column[k]);
			r.volume = batch.pointScale[g] * batch.reference->pointVolume[p] * r.J;
			if (batch.condition == Condition::planeStrain)
				r.cauchy33 = batch.lame[block].lambda[lane] *
					     law.theta(p, point, lane) / r.J;
			responses.push_back(r);
		}
	});
	return responses;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void computeInternalForce<dim>(Batch<dim>&, int);                                 \
	template PointResponse<dim> pointResponse<dim>(const PointLanes<dim>&, int, Condition,     \
						       const LameConstants&);                      \
	template std::vector<PointResponse<dim>> pointResponses<dim>(const Batch<dim>&, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
