#include "grain/InternalForce.hpp"
#include "material/Dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

namespace softgrain {

namespace {

template <int dim>
void gatherGradient(const Batch<dim>& batch, int block, int p, const Lanes& inverseRadius,
		    PointLanes<dim>& point)
{
	Lanes sum[dim][dim] = {}; // local, so that it can stay in registers
	const auto& shapes = batch.reference->pointShapes;
	for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
		const Vec<dim> G = shapes.value[k].G;
		for (int a = 0; a < dim; ++a) {
			const double* x = batch.x.lanes(block, shapes.column[k], a);
			for (int b = 0; b < dim; ++b)
#pragma omp simd
				for (int l = 0; l < laneWidth; ++l)
					sum[a][b][l] += x[l] * G[b];
		}
	}
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			for (int l = 0; l < laneWidth; ++l)
				point.F[a][b][l] = sum[a][b][l] * inverseRadius[l];
}

/// f_I -= weight P G_I
template <int dim>
void scatterForce(Batch<dim>& batch, int block, int p, const PointLanes<dim>& point,
		  const Lanes& weight)
{
	Lanes P[dim][dim];
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			for (int l = 0; l < laneWidth; ++l)
				P[a][b][l] = weight[l] * point.P[a][b][l];
	const auto& shapes = batch.reference->pointShapes;
	for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
		const Vec<dim> G = shapes.value[k].G;
		for (int a = 0; a < dim; ++a) {
			double* f = batch.force.lanes(block, shapes.column[k], a);
#pragma omp simd
			for (int l = 0; l < laneWidth; ++l) {
				double sum = 0;
				for (int b = 0; b < dim; ++b)
					sum += P[a][b][l] * G[b];
				f[l] -= sum;
			}
		}
	}
}

template <int dim> void clearForce(Batch<dim>& batch, int block)
{
	double* f = batch.force.lanes(block, 0, 0);
	for (int k = 0; k < batch.reference->nodes() * dim * laneWidth; ++k)
		f[k] = 0;
}

/// Scales of a block's lanes: gradients with 1/R, point volumes with R^dim.
struct BlockScales {
	Lanes inverseRadius, volume, volumeOverRadius;
};

template <int dim> BlockScales blockScales(const Batch<dim>& batch, int block)
{
	BlockScales s;
	for (int l = 0; l < laneWidth; ++l) {
		const int g = block * laneWidth + l;
		const bool used = g < batch.grains();
		s.inverseRadius[l] = used ? 1 / batch.grain[g].radius : 1;
		s.volume[l] = used ? batch.pointScale[g] : 1;
		s.volumeOverRadius[l] = s.volume[l] * s.inverseRadius[l];
	}
	return s;
}

/// Stress from F, every point on its own.
template <int dim, class LawEvaluator> struct PointwiseLaw {
	PointwiseLaw(const Batch<dim>& batch, int block)
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
	ProjectedLaw(const Batch<dim>& batch, int block)
		: lame(batch.lame[block])
		, theta_(static_cast<std::size_t>(batch.reference->points()) * laneWidth)
	{
		const BlockScales scales = blockScales(batch, block);
		PointLanes<dim> point;
		Lanes lnJ;
		for (int p = 0; p < batch.reference->points(); ++p) {
			gatherGradient(batch, block, p, scales.inverseRadius, point);
			LawEvaluator::volumetricStrain(point, lnJ);
			std::copy(lnJ, lnJ + laneWidth, &theta_[p * laneWidth]);
		}
		project<laneWidth>(batch.reference->pressureSpace, batch.reference->pointVolume,
				   theta_.data());
	}
	void evaluate(int p, PointLanes<dim>& point) const
	{
		Lanes theta;
		std::copy(&theta_[p * laneWidth], &theta_[p * laneWidth] + laneWidth, theta);
		LawEvaluator::evaluateProjected(point, lame, theta);
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
	const BlockScales scales = blockScales(batch, block);
	const VolumetricLaw law(batch, block);
	Lanes energy {}, stiffening {}, invertedPoint;
	for (double& p : invertedPoint)
		p = -1;
	clearForce(batch, block);
	PointLanes<dim> point;
	for (int p = 0; p < batch.reference->points(); ++p) {
		gatherGradient(batch, block, p, scales.inverseRadius, point);
		law.evaluate(p, point);
		Lanes weight;
		const double V = batch.reference->pointVolume[p];
		for (int l = 0; l < laneWidth; ++l) {
			weight[l] = V * scales.volumeOverRadius[l];
			energy[l] += V * scales.volume[l] * point.energy[l];
			stiffening[l] = point.stiffening[l] > stiffening[l] ? point.stiffening[l]
									    : stiffening[l];
			if (!(point.J[l] > 0) && invertedPoint[l] < 0) invertedPoint[l] = p;
		}
		scatterForce(batch, block, p, point, weight);
	}
	for (int l = 0; l < laneWidth; ++l) {
		const int g = block * laneWidth + l;
		if (g < batch.grains())
			batch.report[g] = { energy[l], stiffening[l],
					    static_cast<int>(invertedPoint[l]) };
	}
}

} // namespace

template <int dim> void computeInternalForce(Batch<dim>& batch, int threads)
{
	withVolumetricLaw(batch, [&](auto law) {
		const int blocks = batch.blocks();
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
		r.F33 = std::exp(
			detail::thicknessStrain(std::log(r.J), lame.lambda[lane], lame.mu[lane]));
		r.cauchy /= r.F33;
	}
	return r;
}

template <int dim> std::vector<PointResponse<dim>> pointResponses(const Batch<dim>& batch, int g)
{
	const int block = g / laneWidth, lane = g % laneWidth;
	const BlockScales scales = blockScales(batch, block);
	const auto& shapes = batch.reference->pointShapes;
	std::vector<PointResponse<dim>> responses;
	withVolumetricLaw(batch, [&]<class VolumetricLaw>(std::type_identity<VolumetricLaw>) {
		const VolumetricLaw law(batch, block);
		PointLanes<dim> point;
		for (int p = 0; p < batch.reference->points(); ++p) {
			gatherGradient(batch, block, p, scales.inverseRadius, point);
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
