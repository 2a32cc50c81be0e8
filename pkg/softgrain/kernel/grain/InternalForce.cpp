#include "grain/InternalForce.hpp"
#include "grain/BulkPass.hpp"
#include "material/Dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

namespace softgrain {

namespace {

/// Into a part: the lanes from `begin` on.
template <int dim, class Part>
void copyPart(const Lanes (&from)[dim][dim], int begin, PointLanes<dim, Part>& point)
{
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			point.F[a][b] = partOf<Part>(from[a][b], begin);
}

/// Stress from F, every point on its own.
template <int dim, class LawEvaluator> struct PointwiseLaw {
	template <class Side> void prepare(const Side&, const GrainTemplate<dim>&) {}
	template <class Side, class Part>
	void evaluate(const Side&, const LameNumbers<Part>& lame, const Strip<dim>&, int, int,
		      PointLanes<dim, Part>& point) const
	{
		LawEvaluator::evaluate(point, lame);
	}
	/// The volumetric strain that the stress was computed with; in plane stress its in-plane
	/// part.
	template <class Side>
	double theta(const Side&, const Strip<dim>&, int, int lane,
		     const PointLanes<dim>& point) const
	{
		return std::log(point.J[lane]);
	}
};

/// Stress from F and theta = Pi ln J, the projection over all points of the grain.
template <int dim, class LawEvaluator> struct ProjectedLaw {
	template <class Side> void prepare(const Side& side, const GrainTemplate<dim>& reference)
	{
		theta_.resize<Side>(reference);
		Strip<dim> strip;
		forEachStrip(side, reference.pointLines, strip, [&] { logarithms(side, strip); });
		theta_.project<Side>(reference);
	}
	template <class Side, class Part>
	void evaluate(const Side& side, const LameNumbers<Part>& lame, const Strip<dim>& strip,
		      int group, int begin, PointLanes<dim, Part>& point) const
	{
		LawEvaluator::evaluateProjected(
			point, lame, theta_.template part<Part>(side, strip, group, begin));
	}
	template <class Side>
	double theta(const Side& side, const Strip<dim>& strip, int group, int lane,
		     const PointLanes<dim>&) const
	{
		return theta_.at(side, strip, group, lane);
	}

private:
	template <class Side>
	SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void logarithms(const Side& side,
							   const Strip<dim>& strip)
	{
		PointLanes<dim> point;
		for (int group = 0; group < strip.groups; ++group) {
			copyPart(strip.tensor[group], 0, point);
			theta_.set(side, strip, group, LawEvaluator::volumetricStrain(point));
		}
	}

	ProjectedField theta_;
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

/// Turns the deformation gradients of a strip into Vp0 P, in the lanes from `begin` on.
template <int dim, class Part, class VolumetricLaw, class Side>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void stressesOfStrip(const VolumetricLaw& law, const Side& side,
							int begin, Strip<dim>& strip,
							BulkSums& sums)
{
	// a copy that no store to the strip can change
	const LameNumbers<Part> lame = side.lame().template part<Part>(begin);
	typename Part::Numbers energy = partOf<Part>(sums.energy, begin),
			       stiffening = partOf<Part>(sums.stiffening, begin);
	PointLanes<dim, Part> point;
	for (int group = 0; group < strip.groups; ++group) {
		copyPart(strip.tensor[group], begin, point);
		law.evaluate(side, lame, strip, group, begin, point);
		const auto V = side.template volume<Part>(strip, group, begin);
		energy += V * point.energy;
		stiffening = larger<Part>(point.stiffening, stiffening);
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				partOf<Part>(strip.tensor[group][a][b], begin) = V * point.P[a][b];
	}
	partOf<Part>(sums.energy, begin) = energy;
	partOf<Part>(sums.stiffening, begin) = stiffening;
}

template <int dim, class VolumetricLaw, class Side>
void forceOf(Batch<dim>& batch, const Side& side)
{
	VolumetricLaw law;
	law.prepare(side, *batch.reference);
	auto forces = side.noForces();
	BulkSums sums;
	Strip<dim> strip;
	forEachStrip(side, batch.reference->pointLines, strip, [&] {
		forEachPart([&]<class Part>(Part, int begin) {
			stressesOfStrip<dim, Part>(law, side, begin, strip, sums);
		});
		side.scatter(strip, forces);
	});
	side.holdHourglasses(forces, sums.energy);
	side.storeForces(forces, batch, batch.force);
	side.forEachGrain(batch, [&](int g, int begin, int end) {
		batch.report[g] = sums.report(begin, end, batch.pointScale[g]);
	});
}

/// Calls `use(number of the point, response in lanes, its lane, theta)` for the points of a grain.
template <int dim, class Use> void visitPoints(const Batch<dim>& batch, int g, Use&& use)
{
	withVolumetricLaw(batch, [&]<class VolumetricLaw>(std::type_identity<VolumetricLaw>) {
		const PointsInLanes<dim> side(batch, g, batch.x);
		VolumetricLaw law;
		law.prepare(side, *batch.reference);
		Strip<dim> strip;
		PointLanes<dim> point;
		forEachStrip(side, batch.reference->pointLines, strip, [&] {
			const int points = side.points(strip);
			for (int i = 0; i < points; ++i) {
				const int group = i / laneWidth, lane = i % laneWidth;
				if (lane == 0) {
					copyPart(strip.tensor[group], 0, point);
					law.evaluate(side, side.lame(), strip, group, 0, point);
				}
				use(side.place(strip, group, lane), point, lane,
				    law.theta(side, strip, group, lane, point));
			}
		});
	});
}

/// The first point with J <= 0 or not finite, or -1.
template <int dim> int invertedPoint(const Batch<dim>& batch, int g)
{
	const int points = batch.reference->points();
	int first = points;
	visitPoints(batch, g, [&](int p, const PointLanes<dim>& point, int lane, double) {
		const double J = point.J[lane];
		if (!(J > 0 && std::isnormal(J))) first = std::min(first, p);
	});
	return first < points ? first : -1;
}

template <int dim, class VolumetricLaw> void forceOfBlock(Batch<dim>& batch, int block)
{
	forEachSide(batch, block,
		    [&](auto&& sideOf) { forceOf<dim, VolumetricLaw>(batch, sideOf(batch.x)); });
	for (int l = 0; l < batch.grainsInBlock(block); ++l) {
		const int g = batch.grainInLane(block, l);
		if (!std::isfinite(batch.report[g].elasticEnergy)) // ln J is no number
			batch.report[g].invertedPoint = invertedPoint(batch, g);
	}
}

} // namespace

template <int dim> void computeInternalForce(Batch<dim>& batch, int threads)
{
	withVolumetricLaw(batch, [&]<class VolumetricLaw>(std::type_identity<VolumetricLaw>) {
		const int blocks = batch.activeBlocks();
#pragma omp parallel for schedule(static) num_threads(threads)
		for (int b = 0; b < blocks; ++b)
			forceOfBlock<dim, VolumetricLaw>(batch, b);
	});
}

template <int dim>
PointResponse<dim> pointResponse(const PointLanes<dim>& point, int lane, const OutOfPlane& out)
{
	PointResponse<dim> r;
	Mat<dim> P;
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b) {
			r.F(a, b) = point.F[a][b][lane];
			P(a, b) = point.P[a][b][lane];
		}
	r.J = point.J[lane];
	r.F33 = out.stretch[lane];
	r.cauchy33 = out.stress[lane];
	// forces are per unit reference thickness, Cauchy stress per present one
	r.cauchy = P * r.F.transpose() / r.J / r.F33;
	return r;
}

template <int dim> std::vector<PointResponse<dim>> pointResponses(const Batch<dim>& batch, int g)
{
	const GrainTemplate<dim>& reference = *batch.reference;
	const auto& shapes = reference.pointShapes;
	std::vector<PointResponse<dim>> responses(reference.points());
	auto note = [&](int p, const PointLanes<dim>& point, int lane, const OutOfPlane& out) {
		PointResponse<dim>& r = responses[p];
		r = pointResponse(point, lane, out);
		r.position = batch.grain[g].origin;
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			r.position += shapes.value[k].N * batch.x.get(g, shapes.column[k]);
		r.volume = batch.pointScale[g] * reference.pointVolume[p] * r.J;
	};
	withLaw<dim>(batch.law, batch.condition, [&](auto law) {
		const LameConstants lame = LameConstants::ofAll(batch.grain[g].constants);
		visitPoints(
			batch, g, [&](int p, const PointLanes<dim>& point, int lane, double theta) {
				note(p, point, lane, law.outOfPlane(point, lame, Lanes {} + theta));
			});
	});
	return responses;
}

template <int dim> double presentVolume(const Batch<dim>& batch, int g)
{
	const std::vector<double>& volume = batch.reference->pointVolume;
	double sum = 0;
	visitPoints(batch, g, [&](int p, const PointLanes<dim>& point, int lane, double) {
		sum += volume[p] * point.J[lane];
	});
	return batch.pointScale[g] * sum;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void computeInternalForce<dim>(Batch<dim>&, int);                                 \
	template PointResponse<dim> pointResponse<dim>(const PointLanes<dim>&, int,                \
						       const OutOfPlane&);                         \
	template std::vector<PointResponse<dim>> pointResponses<dim>(const Batch<dim>&, int);      \
	template double presentVolume<dim>(const Batch<dim>&, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
