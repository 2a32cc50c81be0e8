// Compressible neo-Hookean law: W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2,
// P = mu (F - F^-T) + lambda ln J F^-T (method: section 2).
#pragma once

#include "material/Elasticity.hpp"
#include "material/Lanes.hpp"

#include <cmath>
#include <limits>

namespace softgrain {

namespace detail {

/// Cofactors of F (rows and columns as F) and its determinant: F^-T = C / J.
inline double cofactors(const double (&F)[2][2], double (&C)[2][2])
{
	C[0][0] = F[1][1];
	C[0][1] = -F[1][0];
	C[1][0] = -F[0][1];
	C[1][1] = F[0][0];
	return F[0][0] * F[1][1] - F[0][1] * F[1][0];
}

inline double cofactors(const double (&F)[3][3], double (&C)[3][3])
{
	for (int a = 0; a < 3; ++a)
		for (int b = 0; b < 3; ++b) {
			const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3,
				  b2 = (b + 2) % 3;
			C[a][b] = F[a1][b1] * F[a2][b2] - F[a1][b2] * F[a2][b1];
		}
	return F[0][0] * C[0][0] + F[0][1] * C[0][1] + F[0][2] * C[0][2];
}

/// Largest eigenvalue of A A^T, exact in 2D, an upper bound (exact where A A^T is spherical) in 3D.
template <int dim> double largestSquaredStretch(const double (&A)[dim][dim])
{
	double trace = 0, squares = 0;
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b) {
			double B = 0;
			for (int c = 0; c < dim; ++c)
				B += A[a][c] * A[b][c];
			squares += B * B;
			if (a == b) trace += B;
		}
	const double mean = trace / dim;
	const double deviator = squares - dim * mean * mean;
	return mean + std::sqrt((dim - 1.) / dim * (deviator > 0 ? deviator : 0));
}

/// The same for lambda < 0 (auxetic): the function has a minimum, and the thickness belongs to the
/// root on its increasing side, where Newton's method converges monotonically from y >= root. Where
/// compression has brought the minimum above 0 there is no thickness without stress: nan.
inline double auxeticThicknessStrain(double lnJ2, double lambda, double mu)
{
	const double lowest = 0.5 * std::log(-0.5 * lambda / mu);
	const double least = mu * (std::exp(2 * lowest) - 1) + lambda * (lnJ2 + lowest);
	if (!(least < 0)) return std::numeric_limits<double>::quiet_NaN();
	double y = 0;
	for (int k = 0; k < 60; ++k) { // next to the minimum the steps only halve the distance
		const double a = std::exp(2 * y);
		const double change = (mu * (a - 1) + lambda * (lnJ2 + y)) / (2 * mu * a + lambda);
		y = std::fmax(y - change, lowest);
		if (std::fabs(change) < 1e-15) break;
	}
	return y;
}

/// ln F33 from P33 = 0: mu (F33^2 - 1) + lambda (ln J2 + ln F33) = 0. For lambda >= 0 the function
/// is convex and increasing in ln F33, so Newton's method converges; 8 steps reach rounding for all
/// J2 in [0.05, 20].
inline double thicknessStrain(double lnJ2, double lambda, double mu)
{
	if (lambda < 0) return auxeticThicknessStrain(lnJ2, lambda, mu);
	double y = -lambda * lnJ2 / (lambda + 2 * mu);
	for (int k = 0; k < 8; ++k) {
		const double a = std::exp(2 * y);
		y -= (mu * (a - 1) + lambda * (lnJ2 + y)) / (2 * mu * a + lambda);
	}
	return y;
}

} // namespace detail

/// One grain's constants as the law uses them.
struct LameConstants {
	Lanes lambda, mu; ///< Pa
};

template <int dim, Condition condition> struct NeoHookean {
	static_assert((dim == 3) == (condition == Condition::solid));
	/// Whether the volumetric strain may be projected (grain/InternalForce.cpp).
	static constexpr bool canProject = condition != Condition::planeStress;

	/// Fills P, J, energy and stiffening from F. Where J <= 0 the results are not finite, and
	/// where no thickness is free of stress none of them is a number.
	static void evaluate(PointLanes<dim>& point, const LameConstants& lame)
	{
		Lanes lnJ, squareF33;
		volumetricStrain(point, lnJ);
		for (int l = 0; l < laneWidth; ++l) {
			const double y = condition == Condition::planeStress
						 ? detail::thicknessStrain(lnJ[l], lame.lambda[l],
									   lame.mu[l])
						 : 0;
			squareF33[l] = condition == Condition::planeStress ? std::exp(2 * y) : 1;
			lnJ[l] += y; // of the in-plane part so far; the thickness follows
			if (point.J[l] > 0 && std::isnan(y)) point.J[l] = y;
		}
		respond<false>(point, lame, lnJ, lnJ, squareF33);
	}

	/// Fills J from F; ln J.
	static void volumetricStrain(PointLanes<dim>& point, Lanes& lnJ)
	{
#pragma omp simd
		for (int l = 0; l < laneWidth; ++l) {
			double F[dim][dim], C[dim][dim];
			laneOf(point.F, l, F);
			point.J[l] = detail::cofactors(F, C);
		}
		for (int l = 0; l < laneWidth; ++l)
			lnJ[l] = std::log(point.J[l]);
	}

	/// As `evaluate`, with theta in the place of ln J in the volumetric part lambda/2 (ln J)^2:
	/// its energy is lambda/2 theta ln J, the sum of which over a grain is that of theta^2.
	static void evaluateProjected(PointLanes<dim>& point, const LameConstants& lame,
				      const Lanes& theta)
	{
		static_assert(canProject);
		Lanes lnJ, squareF33;
		volumetricStrain(point, lnJ);
		for (double& square : squareF33)
			square = 1;
		respond<true>(point, lame, lnJ, theta, squareF33);
	}

	/// Replaces the stiffening, after `evaluate`, by that seen by a grid fixed in space: with a
	/// spatial wave vector k, rho0 omega^2 = mu |F^T k|^2 + (lambda + mu - lambda ln J) |k|^2.
	static void stiffenInSpace(PointLanes<dim>& point, const LameConstants& lame)
	{
#pragma omp simd
		for (int l = 0; l < laneWidth; ++l) {
			double F[dim][dim], tau = 0, b = 0; // first diagonal entries
			laneOf(point.F, l, F);
			for (int a = 0; a < dim; ++a) {
				tau += point.P[0][a][l] * F[0][a];
				b += F[0][a] * F[0][a];
			}
			const double lambda = lame.lambda[l], mu = lame.mu[l];
			const double rest = tau - mu * b; // lambda ln J - mu; with P33 = 0 also
							  // -mu F33^2
			point.stiffening[l] = (mu * detail::largestSquaredStretch<dim>(F) +
					       inPlane(lambda, -rest) - rest) /
					      (inPlane(lambda, mu) + 2 * mu);
		}
	}

private:
	/// Stress, energy and stiffening with the volumetric strain `theta`: ln J or its
	/// projection.
	template <bool projected>
	static void respond(PointLanes<dim>& point, const LameConstants& lame, const Lanes& lnJ,
			    const Lanes& theta, const Lanes& squareF33)
	{
#pragma omp simd
		for (int l = 0; l < laneWidth; ++l) {
			double F[dim][dim], C[dim][dim];
			laneOf(point.F, l, F);
			const double J = detail::cofactors(F, C);
			const double lambda = lame.lambda[l], mu = lame.mu[l];
			const double onInverse = (lambda * theta[l] - mu) / J;
			double squares = dim == 2 ? squareF33[l] : 0;
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b) {
					point.P[a][b][l] = mu * F[a][b] + onInverse * C[a][b];
					squares += F[a][b] * F[a][b];
				}
			point.energy[l] = 0.5 * mu * (squares - 3 - 2 * lnJ[l]) +
					  0.5 * lambda * lnJ[l] * theta[l];
			const double tangentLambda = inPlane(lambda, mu * squareF33[l]);
			const double inverseStretch =
				detail::largestSquaredStretch<dim>(C) / (J * J);
			point.stiffening[l] =
				(mu + (tangentLambda + mu - lambda * theta[l]) * inverseStretch) /
				(inPlane(lambda, mu) + 2 * mu);
			if (projected) { // the shortest waves may change no projected volume
				const double shear =
					(mu + (mu - lambda * theta[l]) * inverseStretch) / (2 * mu);
				point.stiffening[l] =
					shear > point.stiffening[l] ? shear : point.stiffening[l];
			}
		}
	}

	static void laneOf(const Lanes (&tensor)[dim][dim], int l, double (&T)[dim][dim])
	{
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				T[a][b] = tensor[a][b][l];
	}

	/// First Lame constant that acts in the plane where the thickness is free to follow.
	static double inPlane(double lambda, double mu)
	{
		return condition == Condition::planeStress ? 2 * mu * lambda / (2 * mu + lambda)
							   : lambda;
	}
};

} // namespace softgrain
