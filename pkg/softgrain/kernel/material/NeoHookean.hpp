// Compressible neo-Hookean law: W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2,
// P = mu (F - F^-T) + lambda ln J F^-T (method: section 2).
#pragma once

#include "lanes/LaneMath.hpp"
#include "material/Elasticity.hpp"
#include "material/Kinematics.hpp"
#include "material/PointLanes.hpp"

#include <cmath>
#include <limits>

namespace softgrain {

namespace detail {

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
template <class Part>
typename Part::Numbers thicknessStrain(const typename Part::Numbers& lnJ2,
				       const typename Part::Numbers& lambda,
				       const typename Part::Numbers& mu)
{
	typename Part::Numbers y = -lambda * lnJ2 / (lambda + 2 * mu);
	for (int k = 0; k < 8; ++k) {
		const typename Part::Numbers a = expOf<Part>(2 * y);
		y -= (mu * (a - 1) + lambda * (lnJ2 + y)) / (2 * mu * a + lambda);
	}
	for (int l = 0; l < Part::width; ++l)
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
	template <class Part>
	static void evaluate(PointLanes<dim, Part>& point, const LameNumbers<Part>& lame)
	{
		typename Part::Numbers lnJ = volumetricStrain(point),
				       squareF33 = typename Part::Numbers {} + 1;
		if constexpr (condition == Condition::planeStress) {
			const auto y = detail::thicknessStrain<Part>(lnJ, lame.lambda, lame.mu);
			squareF33 = expOf<Part>(2 * y);
			lnJ += y; // of the in-plane part so far; the thickness follows
			point.J = inEveryLane<Part>([&](int l) {
				const double J = point.J[l];
				return J > 0 && std::isnan(y[l]) ? y[l] : J;
			});
		}
		respond(point, lame, lnJ, lnJ, squareF33);
	}

	/// Fills J from F; ln J.
	template <class Part>
	static typename Part::Numbers volumetricStrain(PointLanes<dim, Part>& point)
	{
		typename Part::Numbers C[dim][dim];
		point.J = cofactors<Part>(point.F, C);
		return lnOf<Part>(point.J);
	}

	/// As `evaluate`, with theta in the place of ln J in the volumetric part lambda/2 (ln J)^2:
	/// its energy is lambda/2 theta ln J, the sum of which over a grain is that of theta^2.
	template <class Part>
	static void evaluateProjected(PointLanes<dim, Part>& point, const LameNumbers<Part>& lame,
				      const typename Part::Numbers& theta)
	{
		static_assert(canProject);
		const auto lnJ = volumetricStrain(point);
		respond(point, lame, lnJ, theta, typename Part::Numbers {} + 1);
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
		point.stiffening = (mu * largestSquaredStretch(point.F) +
				    inPlane<WholeLanes>(lambda, -rest) - rest) /
				   (inPlane<WholeLanes>(lambda, mu) + 2 * mu);
	}

	/// Of a point with the volumetric strain `theta`: ln J or its projection. With F33 = 1,
	/// J sigma33 = lambda theta.
	static OutOfPlane outOfPlane(const PointLanes<dim>& point, const LameConstants& lame,
				     const Lanes& theta)
	{
		OutOfPlane out;
		if constexpr (condition == Condition::planeStrain)
			out.stress = lame.lambda * theta / point.J;
		if constexpr (condition == Condition::planeStress)
			out.stretch = expOf(
				detail::thicknessStrain<WholeLanes>(theta, lame.lambda, lame.mu));
		return out;
	}

private:
	/// Stress, energy and stiffening with the volumetric strain `theta`: ln J or its
	/// projection.
	template <class Part>
	static void respond(PointLanes<dim, Part>& point, const LameNumbers<Part>& lame,
			    const typename Part::Numbers& lnJ, const typename Part::Numbers& theta,
			    const typename Part::Numbers& squareF33)
	{
		using Numbers = typename Part::Numbers;
		const Numbers &lambda = lame.lambda, &mu = lame.mu;
		Numbers C[dim][dim];
		const Numbers inverseJ = 1 / cofactors<Part>(point.F, C);
		const Numbers pressure = lambda * theta - mu, onInverse = pressure * inverseJ;
		Numbers squares = dim == 2 ? squareF33 : Numbers {};
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b) {
				point.P[a][b] = mu * point.F[a][b] + onInverse * C[a][b];
				squares += point.F[a][b] * point.F[a][b];
			}
		point.energy = 0.5 * (mu * (squares - 3) + lnJ * (pressure - mu));
		const Numbers inverseStretch =
			largestSquaredStretch<Part>(C) * (inverseJ * inverseJ);
		const Numbers tangentLambda = inPlane<Part>(lambda, mu * squareF33);
		// the divisions are the same in all points
		point.stiffening = (mu + (tangentLambda - pressure) * inverseStretch) *
				   (1 / (inPlane<Part>(lambda, mu) + 2 * mu));
		if (lame.anyIsochoric)
			point.stiffening = larger<Part>((mu - pressure * inverseStretch) *
								(lame.isochoricShare / (2 * mu)),
							point.stiffening);
	}

	/// First Lame constant that acts in the plane where the thickness is free to follow.
	template <class Part>
	static typename Part::Numbers inPlane(const typename Part::Numbers& lambda,
					      const typename Part::Numbers& mu)
	{
		if constexpr (condition == Condition::planeStress)
			return 2 * mu * lambda / (2 * mu + lambda);
		else
			return lambda;
	}
};

} // namespace softgrain
