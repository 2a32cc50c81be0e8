// Small vibrations of a grain, from its internal force.
#pragma once

#include "Helpers.hpp"
#include "grain/InternalForce.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace softgrain::testing {

/// M^-1/2 K M^-1/2 of the grain in its present shape, with K from the internal force itself by
/// differences; its eigenvalues are the squares of the angular frequencies.
template <int dim> Eigen::MatrixXd dynamicMatrix(Batch<dim> batch)
{
	const int n = batch.reference->nodes() * dim;
	const double eps = 1e-6 * batch.grain[0].radius;
	Eigen::MatrixXd K(n, n);
	for (int j = 0; j < n; ++j) {
		const Vec<dim> x = batch.x.get(0, j / dim);
		for (double side : { 1., -1. }) {
			batch.x.set(0, j / dim, x + side * eps * Vec<dim>::Unit(j % dim));
			computeInternalForce(batch, 1);
			for (int i = 0; i < n; ++i) {
				const double f =
					-side * batch.force.get(0, i / dim)[i % dim] / (2 * eps);
				K(i, j) = side > 0 ? f : K(i, j) + f;
			}
		}
		batch.x.set(0, j / dim, x);
	}
	for (int i = 0; i < n; ++i)
		for (int j = 0; j < n; ++j)
			K(i, j) /=
				std::sqrt(batch.nodeMass(0, i / dim) * batch.nodeMass(0, j / dim));
	return K;
}

/// Of the symmetric part, in ascending order.
inline Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A)
{
	const Eigen::MatrixXd symmetric = 0.5 * (A + A.transpose());
	return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
		.eigenvalues();
}

} // namespace softgrain::testing
