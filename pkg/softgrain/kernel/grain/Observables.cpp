#include "grain/Observables.hpp"
#include "grain/InternalForce.hpp"

#include <Eigen/Dense>

namespace softgrain {

namespace {

Eigen::Matrix<double, 1, 1> cross(const Vec<2>& a, const Vec<2>& b)
{
	return Eigen::Matrix<double, 1, 1>(a[0] * b[1] - a[1] * b[0]);
}
Vec<3> cross(const Vec<3>& a, const Vec<3>& b) { return a.cross(b); }

Eigen::Matrix<double, 1, 1> pointInertia(const Vec<2>& r)
{
	return Eigen::Matrix<double, 1, 1>(r.squaredNorm());
}
Mat<3> pointInertia(const Vec<3>& r)
{
	return r.squaredNorm() * Mat<3>::Identity() - r * r.transpose();
}

/// Rotation nearest to A in the sense of the polar decomposition.
template <int dim> Mat<dim> nearestRotation(const Mat<dim>& A)
{
	Eigen::JacobiSVD<Mat<dim>> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
	Mat<dim> U = svd.matrixU();
	if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(dim - 1) *= -1;
	return U * svd.matrixV().transpose();
}

} // namespace

template <> Mat<2> spinMatrix<2>(const Eigen::Matrix<double, 1, 1>& omega)
{
	return (Mat<2>() << 0, -omega[0], omega[0], 0).finished();
}

template <> Mat<3> spinMatrix<3>(const Vec<3>& omega)
{
	return (Mat<3>() << 0, -omega[2], omega[1], omega[2], 0, -omega[0], -omega[1], omega[0], 0)
		.finished();
}

template <int dim> WholeGrain<dim> wholeGrain(const Batch<dim>& batch, int g)
{
	WholeGrain<dim> whole;
	whole.inertia.setZero();
	const int nodes = batch.reference->nodes();
	for (int I = 0; I < nodes; ++I) {
		const double m = batch.nodeMass(g, I);
		whole.mass += m;
		whole.centre += m * batch.x.get(g, I);
		whole.velocity += m * batch.v.get(g, I);
	}
	whole.centre /= whole.mass;
	whole.velocity /= whole.mass;
	Mat<dim> motion = Mat<dim>::Zero();
	for (int I = 0; I < nodes; ++I) {
		const double m = batch.nodeMass(g, I);
		const Vec<dim> r = batch.x.get(g, I) - whole.centre;
		whole.angularMomentum += m * cross(r, Vec<dim>(batch.v.get(g, I) - whole.velocity));
		whole.inertia += m * pointInertia(r);
		motion += m * r * batch.reference->nodePosition[I].transpose();
	}
	whole.angularVelocity = whole.inertia.inverse() * whole.angularMomentum;
	whole.rotation = nearestRotation<dim>(motion);
	return whole;
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
	template WholeGrain<dim> wholeGrain<dim>(const Batch<dim>&, int);                          \
	template double kineticEnergy<dim>(const Batch<dim>&, const NodalField<dim>&,              \
					   const NodalField<dim>&, int);                           \
	template double currentVolume<dim>(const Batch<dim>&, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
