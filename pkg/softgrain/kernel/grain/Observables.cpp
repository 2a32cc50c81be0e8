#include "grain/Observables.hpp"
#include "Vectors.hpp"
#include "lanes/Lanes.hpp"
#include "lanes/NodeBlocks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace softgrain {

template <> Mat<2> detail::nearestRotation(const Mat<2>& A)
{
	const Vec<2> direction = Vec<2>(A(0, 0) + A(1, 1), A(1, 0) - A(0, 1)).normalized();
	return (Mat<2>() << direction[0], -direction[1], direction[1], direction[0]).finished();
}

template <> Mat<3> detail::nearestRotation(const Mat<3>& A)
{
	Eigen::JacobiSVD<Mat<3>> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
	Mat<3> U = svd.matrixU();
	if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) *= -1;
	return U * svd.matrixV().transpose();
}

namespace {

/// Nodes of a grain of the plane.
struct PlaneNodes {
	const std::vector<double>& mass;
	const Vec<2>*x, *v, *X;

	int count() const { return static_cast<int>(mass.size()); }
	int middle() const { return count() / 2; }
};

/// Sums over the nodes, x and v less those of one of them: no digits are lost far from the origin.
struct PlaneSums {
	double mass, spin, inertia; ///< m, m x cross v, m x.x
	Vec<2> x, v, X;             ///< m x, m v, m X
	Mat<2> motion;              ///< m x X^T
};

SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void sumUp(const PlaneNodes& node, PlaneSums& sums)
{
	const int count = node.count();
	const Vec<2> x0 = node.x[node.middle()], v0 = node.v[node.middle()];
	FourNumbers mass = {}, spin = {}, inertia = {};
	BlockVectors first, momentum, reference, motion[2];
	for (int k = 0; k < count; k += nodesPerBlock) {
		const FourNumbers m = fourOf(node.mass.data(), k, count);
		const BlockVectors x = vectorsOf(node.x, k, count).less(x0),
				   v = vectorsOf(node.v, k, count).less(v0),
				   X = vectorsOf(node.X, k, count);
		mass += m;
		first.add(m, x);
		momentum.add(m, v);
		reference.add(m, X);
		spin += m * x.cross(v);
		inertia += m * x.dot(x);
		motion[0].add(m * x.x, X);
		motion[1].add(m * x.y, X);
	}
	sums.mass = sumOf(mass);
	sums.spin = sumOf(spin);
	sums.inertia = sumOf(inertia);
	sums.x = first.sum();
	sums.v = momentum.sum();
	sums.X = reference.sum();
	sums.motion.row(0) = motion[0].sum();
	sums.motion.row(1) = motion[1].sum();
}

} // namespace

template <> WholeGrain<2> wholeGrain(const Batch<2>& batch, int g)
{
	const GrainTemplate<2>& reference = *batch.reference;
	const PlaneNodes node { reference.nodeMass, batch.x.of(g), batch.v.of(g),
				reference.nodePosition.data() };
	PlaneSums sums;
	sumUp(node, sums);
	const double scale = batch.massScale[g];
	const Vec<2> x = sums.x / sums.mass, v = sums.v / sums.mass; // of the centre
	WholeGrain<2> whole;
	whole.mass = scale * sums.mass;
	whole.centre = node.x[node.middle()] + x;
	whole.velocity = node.v[node.middle()] + v;
	whole.angularMomentum = scale * (Spin<2>(sums.spin) - sums.mass * moment<2>(x, v));
	whole.inertia = scale * (Inertia<2>(sums.inertia) - sums.mass * detail::pointInertia(x));
	whole.angularVelocity = whole.angularMomentum / whole.inertia(0, 0);
	whole.rotation = detail::nearestRotation<2>(sums.motion - x * sums.X.transpose());
	return whole;
}

template <> WholeGrain<3> wholeGrain(const Batch<3>& batch, int g)
{
	return wholeOf<3>(batch.reference->nodes(), [&](int I) {
		return Particle<3> { batch.nodeMass(g, I), batch.x.get(g, I), batch.v.get(g, I),
				     batch.reference->nodePosition[I] };
	});
}

namespace {

/// sum m v . w
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS double sumOfProducts(const std::vector<double>& mass,
							const Vec<dim>* v, const Vec<dim>* w)
{
	const int count = static_cast<int>(mass.size());
	FourNumbers sum[dim] = {};
	for (int k = 0; k < count; k += nodesPerBlock)
		forFourNumbers<dim>(fourOf(mass.data(), k, count),
				    [&](int i, const FourNumbers& m) {
					    const int first = dim * k + 4 * i;
					    sum[i] += m * fourOf(v->data(), first, dim * count) *
						      fourOf(w->data(), first, dim * count);
				    });
	return sumOf(std::accumulate(sum + 1, sum + dim, sum[0]));
}

/// sum m v
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS Vec<dim> weightedSum(const std::vector<double>& mass,
							const Vec<dim>* v)
{
	const int count = static_cast<int>(mass.size());
	BlockSum<dim> sum;
	for (int k = 0; k < count; k += nodesPerBlock)
		sum.add(v, k, count, fourOf(mass.data(), k, count));
	return sum.value();
}

/// What is not finite leaves no zero.
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS bool areFinite(const double* numbers, int count)
{
	FourNumbers sum = {};
	for (int k = 0; k < count; k += nodesPerBlock)
		sum += 0 * fourOf(numbers, k, count);
	return sumOf(sum) == 0;
}

} // namespace

template <int dim>
double kineticEnergy(const Batch<dim>& batch, const NodalField<dim>& v, const NodalField<dim>& w,
		     int g)
{
	return 0.5 * batch.massScale[g] *
	       sumOfProducts<dim>(batch.reference->nodeMass, v.of(g), w.of(g));
}

template <int dim> Vec<dim> momentum(const Batch<dim>& batch, const NodalField<dim>& v, int g)
{
	return batch.massScale[g] * weightedSum<dim>(batch.reference->nodeMass, v.of(g));
}

template <int dim> bool isFinite(const NodalField<dim>& field, int g, int nodes)
{
	return areFinite(field.of(g)->data(), dim * nodes);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template double kineticEnergy<dim>(const Batch<dim>&, const NodalField<dim>&,              \
					   const NodalField<dim>&, int);                           \
	template Vec<dim> momentum<dim>(const Batch<dim>&, const NodalField<dim>&, int);           \
	template bool isFinite<dim>(const NodalField<dim>&, int, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
