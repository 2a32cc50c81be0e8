#include "grain/Observables.hpp"
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

template <int dim> WholeGrain<dim> wholeGrain(const Batch<dim>& batch, int g)
{
	return wholeOf<dim>(batch.reference->nodes(), [&](int I) {
		return Particle<dim> { batch.nodeMass(g, I), batch.x.get(g, I), batch.v.get(g, I),
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
	template WholeGrain<dim> wholeGrain<dim>(const Batch<dim>&, int);                          \
	template double kineticEnergy<dim>(const Batch<dim>&, const NodalField<dim>&,              \
					   const NodalField<dim>&, int);                           \
	template double currentVolume<dim>(const Batch<dim>&, int);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
