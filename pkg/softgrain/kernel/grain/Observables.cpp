#include "grain/Observables.hpp"
#include "grain/BlockField.hpp"
#include "grain/InternalForce.hpp"

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

template <> Mat<2> spinMatrix<2>(const Eigen::Matrix<double, 1, 1>& omega)
{
	return (Mat<2>() << 0, -omega[0], omega[0], 0).finished();
}

template <> Mat<3> spinMatrix<3>(const Vec<3>& omega)
{
	return (Mat<3>() << 0, -omega[2], omega[1], omega[2], 0, -omega[0], -omega[1], omega[0], 0)
		.finished();
}

namespace {

/// The components of so many vectors of the plane.
struct PlaneLanes {
	Lanes x, y;

	void operator+=(const PlaneLanes& other)
	{
		x += other.x;
		y += other.y;
	}
};
PlaneLanes operator-(const PlaneLanes& a, const Vec<2>& b) { return { a.x - b[0], a.y - b[1] }; }
PlaneLanes operator*(const Lanes& a, const PlaneLanes& b) { return { a * b.x, a * b.y }; }

/// Vectors from `k` on of an array of `count`; zero behind its end.
PlaneLanes takePlane(const Vec<2>* vectors, int k, int count)
{
	const double* numbers = vectors[0].data();
	const Lanes low = detail::loadPart(numbers, 2 * k, 2 * count),
		    high = detail::loadPart(numbers, 2 * k + laneWidth, 2 * count);
	return { __builtin_shuffle(low, high, LaneBits { 0, 2, 4, 6, 8, 10, 12, 14 }),
		 __builtin_shuffle(low, high, LaneBits { 1, 3, 5, 7, 9, 11, 13, 15 }) };
}

double sumOf(const Lanes& lanes)
{
	double sum = 0;
	for (int l = 0; l < laneWidth; ++l)
		sum += lanes[l];
	return sum;
}
Vec<2> sumOf(const PlaneLanes& lanes) { return { sumOf(lanes.x), sumOf(lanes.y) }; }

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
	Lanes mass {}, spin {}, inertia {};
	PlaneLanes first {}, momentum {}, reference {}, motion[2] {};
	for (int k = 0; k < count; k += laneWidth) {
		const Lanes m = detail::loadPart(node.mass.data(), k, count);
		const PlaneLanes x = takePlane(node.x, k, count) - x0,
				 v = takePlane(node.v, k, count) - v0,
				 X = takePlane(node.X, k, count), mx = m * x;
		mass += m;
		first += mx;
		momentum += m * v;
		reference += m * X;
		spin += mx.x * v.y - mx.y * v.x;
		inertia += mx.x * x.x + mx.y * x.y;
		motion[0] += mx.x * X;
		motion[1] += mx.y * X;
	}
	sums.mass = sumOf(mass);
	sums.spin = sumOf(spin);
	sums.inertia = sumOf(inertia);
	sums.x = sumOf(first);
	sums.v = sumOf(momentum);
	sums.X = sumOf(reference);
	sums.motion.row(0) = sumOf(motion[0]);
	sums.motion.row(1) = sumOf(motion[1]);
}

} // namespace

template <> WholeGrain<2> wholeGrain(const Batch<2>& batch, int g)
{
	using Scalar = WholeGrain<2>::Angular;
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
	whole.angularMomentum = scale * (Scalar(sums.spin) - sums.mass * detail::cross(x, v));
	whole.inertia = scale * (Scalar(sums.inertia) - sums.mass * detail::pointInertia(x));
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

template <int dim>
double kineticEnergy(const Batch<dim>& batch, const NodalField<dim>& v, const NodalField<dim>& w,
		     int g)
{
	double sum = 0;
	for (int I = 0; I < batch.reference->nodes(); ++I)
		sum += batch.nodeMass(g, I) * v.get(g, I).dot(w.get(g, I));
	return 0.5 * sum;
}

template <int dim> double currentVolume(const Batch<dim>& batch, int g)
{
	const auto responses = pointResponses(batch, g);
	double sum = 0;
	for (std::size_t p = 0; p < responses.size(); ++p)
		sum += batch.reference->pointVolume[p] * responses[p].J;
	return sum * batch.pointScale[g];
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template double kineticEnergy<dim>(const Batch<dim>&, const NodalField<dim>&,              \
					   const NodalField<dim>&, int);                           \
	template double currentVolume<dim>(const Batch<dim>&, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
