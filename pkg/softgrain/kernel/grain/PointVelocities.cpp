#include "grain/PointVelocities.hpp"
#include "grain/BlockField.hpp"

namespace softgrain {

namespace {

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
nodesToPoints(const GrainTemplate<dim>& reference, const BlockField<dim>& v,
	      const BlockField<dim>& vNext, double picShare, BlockField<dim>& points)
{
	const auto& shapes = reference.pointShapes;
	for (int p = 0; p < reference.points(); ++p) {
		Lanes change[dim] = {}, whole[dim] = {};
		for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
			const double N = shapes.value[k].N;
			for (int a = 0; a < dim; ++a) {
				const Lanes& after = vNext.at(shapes.column[k], a);
				change[a] += N * (after - v.at(shapes.column[k], a));
				whole[a] += N * after;
			}
		}
		for (int a = 0; a < dim; ++a) {
			Lanes& vp = points.at(p, a);
			vp = (1 - picShare) * (vp + change[a]) + picShare * whole[a];
		}
	}
}

/// `v` must be zero.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void pointsToNodes(const GrainTemplate<dim>& reference,
						      const BlockField<dim>& points,
						      BlockField<dim>& v)
{
	const auto& shapes = reference.pointShapes;
	for (int p = 0; p < reference.points(); ++p)
		for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
			const double mass = reference.pointVolume[p] * shapes.value[k].N;
			for (int a = 0; a < dim; ++a)
				v.at(shapes.column[k], a) += mass * points.at(p, a);
		}
	for (int I = 0; I < reference.nodes(); ++I) {
		const double inverseMass = 1 / reference.nodeMass[I];
		for (int a = 0; a < dim; ++a)
			v.at(I, a) *= inverseMass;
	}
}

template <int dim> void storeNodes(Batch<dim>& batch, int block, const BlockField<dim>& points)
{
	BlockField<dim> v(batch.reference->nodes());
	pointsToNodes(*batch.reference, points, v);
	v.store(batch.v, batch, block);
}

} // namespace

template <int dim>
PointVelocities<dim>::PointVelocities(Batch<dim>& batch, double picShare)
	: picShare_(picShare)
{
	v_.resize(batch.grains(), batch.reference->points());
	for (int g = 0; g < batch.grains(); ++g)
		takeFromNodes(batch, g);
	for (int b = 0; b < batch.blocks(); ++b)
		mapBlockToNodes(batch, b);
}

template <int dim> void PointVelocities<dim>::takeFromNodes(const Batch<dim>& batch, int g)
{
	const auto& shapes = batch.reference->pointShapes;
	for (int p = 0; p < batch.reference->points(); ++p) {
		Vec<dim> v = Vec<dim>::Zero();
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			v += shapes.value[k].N * batch.v.get(g, shapes.column[k]);
		v_.set(g, p, v);
	}
}

template <int dim> void PointVelocities<dim>::updateBlock(Batch<dim>& batch, int block)
{
	const GrainTemplate<dim>& reference = *batch.reference;
	BlockField<dim> v(reference.nodes()), vNext(reference.nodes()), points(reference.points());
	v.load(batch.v, batch, block);
	vNext.load(batch.vNext, batch, block);
	points.load(v_, batch, block);
	nodesToPoints(reference, v, vNext, picShare_, points);
	points.store(v_, batch, block);
	storeNodes(batch, block, points);
}

template <int dim> void PointVelocities<dim>::mapBlockToNodes(Batch<dim>& batch, int block)
{
	BlockField<dim> points(batch.reference->points());
	points.load(v_, batch, block);
	storeNodes(batch, block, points);
}

template <int dim> void PointVelocities<dim>::update(Batch<dim>& batch, int threads)
{
	const int blocks = batch.activeBlocks();
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int b = 0; b < blocks; ++b)
		updateBlock(batch, b);
}

template class PointVelocities<2>;
template class PointVelocities<3>;

} // namespace softgrain
