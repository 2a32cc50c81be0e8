#include "grain/PointVelocities.hpp"

namespace softgrain {

namespace {

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
nodesToPoints(const GrainTemplate<dim>& reference, const NodalField<dim>& v,
	      const NodalField<dim>& vNext, double picShare, int block, NodalField<dim>& points)
{
	const auto& shapes = reference.pointShapes;
	for (int p = 0; p < reference.points(); ++p) {
		Lanes change[dim] = {}, whole[dim] = {};
		for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
			const double N = shapes.value[k].N;
			for (int a = 0; a < dim; ++a) {
				const Lanes& after = vNext.lanes(block, shapes.column[k], a);
				change[a] += N * (after - v.lanes(block, shapes.column[k], a));
				whole[a] += N * after;
			}
		}
		for (int a = 0; a < dim; ++a) {
			Lanes& vp = points.lanes(block, p, a);
			vp = (1 - picShare) * (vp + change[a]) + picShare * whole[a];
		}
	}
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void pointsToNodes(const GrainTemplate<dim>& reference,
						      const NodalField<dim>& points, int block,
						      NodalField<dim>& v)
{
	const auto& shapes = reference.pointShapes;
	for (int I = 0; I < reference.nodes(); ++I)
		for (int a = 0; a < dim; ++a)
			v.lanes(block, I, a) = Lanes {};
	for (int p = 0; p < reference.points(); ++p)
		for (int k = shapes.begin(p); k < shapes.end(p); ++k) {
			const double mass = reference.pointVolume[p] * shapes.value[k].N;
			for (int a = 0; a < dim; ++a)
				v.lanes(block, shapes.column[k], a) +=
					mass * points.lanes(block, p, a);
		}
	for (int I = 0; I < reference.nodes(); ++I) {
		const double inverseMass = 1 / reference.nodeMass[I];
		for (int a = 0; a < dim; ++a)
			v.lanes(block, I, a) *= inverseMass;
	}
}

} // namespace

template <int dim>
PointVelocities<dim>::PointVelocities(Batch<dim>& batch, double picShare)
	: picShare_(picShare)
{
	v_.resize(batch.blocks(), batch.reference->points());
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

template <int dim> void PointVelocities<dim>::updateBlock(const Batch<dim>& batch, int block)
{
	nodesToPoints(*batch.reference, batch.v, batch.vNext, picShare_, block, v_);
}

template <int dim> void PointVelocities<dim>::mapBlockToNodes(Batch<dim>& batch, int block)
{
	pointsToNodes(*batch.reference, v_, block, batch.v);
}

template <int dim> void PointVelocities<dim>::update(Batch<dim>& batch, int threads)
{
	const int blocks = batch.blocks();
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int b = 0; b < blocks; ++b) {
		updateBlock(batch, b);
		mapBlockToNodes(batch, b);
	}
}

template class PointVelocities<2>;
template class PointVelocities<3>;

} // namespace softgrain
