// Compressible neo-Hookean law: W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2,
// P = mu (F - F^-T) + lambda ln J F^-T (method: section 2).
#pragma once

#include "lanes/LaneMath.hpp"
#include "material/Elasticity.hpp"
#include "material/PointLanes.hpp"

#include <cmath>
#include <limits>

namespace softgrain {

namespace detail {

/// Cofactors of F (rows and columns as F) and its determinant: F^-T = C / J.
inline Lanes cofactors(const Lanes (&F)[2][2], Lanes (&C)[2][2])
{
	C[0][0] = F[1][1];
	C[0][1] = -F[1][0];
	C[1][0] = -F[0][1];
	C[1][1] = F[0][0];
	return F[0][0] * F[1][1] - F[0][1] * F[1][0];
}

inline Lanes cofactors(const Lanes (&F)[3][3], Lanes (&C)[3][3])
{
	for (int a = 0; a < 3; ++a)
		for (int b = 0; b < 3; ++b) {
			const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3,
				  b2 = (b + 2) % 3;
			C[a][b] = F[a1][b1] * F[a2][b2] - F[a1][b2] * F[a2][b1];
		}
	return F[0][0] * C[0][0] + F[0][1] * C[0][1] + F[0][2] * C[0][2];
}

/// Largest eigenvalue of A A^T. With s1 >= s2 the singular values of A, the two sums of squares are
/// (s1 + s2)^2 and (s1 - s2)^2 (or the other way round where det A < 0): no digit cancels.
inline Lanes largestSquaredStretch(const Lanes (&A)[2][2])
{
	const Lanes p = A[0][0] + A[1][1], q = A[0][1] - A[1][0], r = A[0][0] - A[1][1],
		    t = A[0][1] + A[1][0];
	const Lanes sum = p * p + q * q, difference = r * r + t * t;
	return 0.25 * (sum + difference) + 0.5 * sqrtOf(sum * difference);
}

/// An upper bound in 3D, exact where A A^T is spherical.
inline Lanes largestSquaredStretch(const Lanes (&A)[3][3])
{
	constexpr int dim = 3;
	Lanes trace = {}, squares = {};
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b) {
			Lanes B = {};
			for (int c = 0; c < dim; ++c)
				B += A[a][c] * A[b][c];
			squares += B * B;
			if (a == b) trace += B;
		}
	const Lanes mean = trace / dim;
	const Lanes deviator = squares - dim * mean * mean;
	return mean + sqrtOf((dim - 1.) / dim * larger(deviator, Lanes {}));
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
inline Lanes thicknessStrain(const Lanes& lnJ2, const Lanes& lambda, const Lanes& mu)
{
	Lanes y = -lambda * lnJ2 / (lambda + 2 * mu);
	for (int k = 0; k < 8; ++k) {
		const Lanes a = expOf(2 * y);
		y -= (mu * (a - 1) + lambda * (lnJ2 + y)) / (2 * mu * a + lambda);
	}
	for (int l = 0; l < laneWidth; ++l)
		if (lambda[l] < 0) y[l] = auxeticThicknessStrain(lnJ2[l], lambda[l], mu[l]);
	return y;
}

} // namespace detail

template <int dim, Condition condition> struct NeoHookean {
	static_assert((dim == 3) == (condition == Condition::solid));
	/// Whether the volumetric strain may be projected (grain/InternalForce.cpp).
	static constexpr bool canProject = condition != Condition::planeStress;

	/// Fills P, J, energy and stiffening from F. Where J <= 0 the results are not finite, and
	/// where no thickness is free of stress none of them is a number.
	static void evaluate(PointLanes<dim>& point, const LameConstants& lame)
	{
		Lanes lnJ = volumetricStrain(point), squareF33 = Lanes {} + 1;
		if constexpr (condition == Condition::planeStress) {
			const Lanes y = detail::thicknessStrain(lnJ, lame.lambda, lame.mu);
			squareF33 = expOf(2 * y);
			lnJ += y; // of the in-plane part so far; the thickness follows
			point.J = (point.J > 0) & (y != y) ? y : point.J;
		}
		respond(point, lame, lnJ, lnJ, squareF33);
	}

	/// Fills J from F; ln J.
	static Lanes volumetricStrain(PointLanes<dim>& point)
	{
		Lanes C[dim][dim];
		point.J = detail::cofactors(point.F, C);
		return lnOf(point.J);
	}

	/// As `evaluate`, with theta in the place of ln J in the volumetric part lambda/2 (ln J)^2:
	/// its energy is lambda/2 theta ln J, the sum of which over a grain is that of theta^2.
	static void evaluateProjected(PointLanes<dim>& point, const LameConstants& lame,
				      const Lanes& theta)
	{
		static_assert(canProject);
		const Lanes lnJ = volumetricStrain(point);
		respond(point, lame, lnJ, theta, Lanes {} + 1);
	}

	/// Replaces the stiffening, after `evaluate`, by that seen by a grid fixed in space: with a
	/// spatial wave vector k, rho0 omega^2 = mu |F^T k|^2 + (lambda + mu - lambda ln J) |k|^2.
	static void stiffenInSpace(PointLanes<dim>& point, const LameConstants& lame)
	{
		const Lanes &lambda = lame.lambda, &mu = lame.mu;
		Lanes tau = {}, b = {}; // first diagonal entries
		for (int a = 0; a < dim; ++a) {
			tau += point.P[0][a] * point.F[0][a];
			b += point.F[0][a] * point.F[0][a];
		}
		const Lanes rest = tau - mu * b; // lambda ln J - mu; with P33 = 0 also -mu F33^2
		point.stiffening = (mu * detail::largestSquaredStretch(point.F) +
				    inPlane(lambda, -rest) - rest) /
				   (inPlane(lambda, mu) + 2 * mu);
	}

private:
	/// Stress, energy and stiffening with the volumetric strain `theta`: ln J or its
	/// projection.
	static void respond(PointLanes<dim>& point, const LameConstants& lame, const Lanes& lnJ,
			    const Lanes& theta, const Lanes& squareF33)
	{
		const Lanes &lambda = lame.lambda, &mu = lame.mu;
		Lanes C[dim][dim];
		const Lanes inverseJ = 1 / detail::cofactors(point.F, C);
		const Lanes pressure = lambda * theta - mu, onInverse = pressure * inverseJ;
		Lanes squares = dim == 2 ? squareF33 : Lanes {};
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b) {
				point.P[a][b] = mu * point.F[a][b] + onInverse * C[a][b];
				squares += point.F[a][b] * point.F[a][b];
			}
		point.energy = 0.5 * (mu * (squares - 3) + lnJ * (pressure - mu));
		const Lanes inverseStretch =
			detail::largestSquaredStretch(C) * (inverseJ * inverseJ);
		const Lanes tangentLambda = inPlane(lambda, mu * squareF33);
		// the divisions are the same in all points
		point.stiffening = (mu + (tangentLambda - pressure) * inverseStretch) *
				   (1 / (inPlane(lambda, mu) + 2 * mu));
		if (lame.anyIsochoric)
			point.stiffening = larger((mu - pressure * inverseStretch) *
							  (lame.isochoricShare / (2 * mu)),
						  point.stiffening);
	}

	/// First Lame constant that acts in the plane where the thickness is free to follow.
	static Lanes inPlane(const Lanes& lambda, const Lanes& mu)
	{
		if constexpr (condition == Condition::planeStress)
			return 2 * mu * lambda / (2 * mu + lambda);
		else
			return lambda;
	}
};

} // namespace softgrain
