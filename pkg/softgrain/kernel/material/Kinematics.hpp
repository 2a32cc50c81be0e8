// What laws derive from a deformation gradient.
#pragma once

#include "lanes/LaneMath.hpp"

namespace softgrain {

/// Cofactors of F (rows and columns as F) and its determinant: F^-T = C / J.
template <class Part = WholeLanes>
typename Part::Numbers cofactors(const typename Part::Numbers (&F)[2][2],
				 typename Part::Numbers (&C)[2][2])
{
	C[0][0] = F[1][1];
	C[0][1] = -F[1][0];
	C[1][0] = -F[0][1];
	C[1][1] = F[0][0];
	return F[0][0] * F[1][1] - F[0][1] * F[1][0];
}

template <class Part = WholeLanes>
typename Part::Numbers cofactors(const typename Part::Numbers (&F)[3][3],
				 typename Part::Numbers (&C)[3][3])
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
template <class Part = WholeLanes>
typename Part::Numbers largestSquaredStretch(const typename Part::Numbers (&A)[2][2])
{
	const typename Part::Numbers p = A[0][0] + A[1][1], q = A[0][1] - A[1][0],
				     r = A[0][0] - A[1][1], t = A[0][1] + A[1][0];
	const typename Part::Numbers sum = p * p + q * q, difference = r * r + t * t;
	return 0.25 * (sum + difference) + 0.5 * sqrtOf<Part>(sum * difference);
}

/// An upper bound in 3D, exact where A A^T is spherical.
template <class Part = WholeLanes>
typename Part::Numbers largestSquaredStretch(const typename Part::Numbers (&A)[3][3])
{
	constexpr int dim = 3;
	typename Part::Numbers trace = {}, squares = {};
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b) {
			typename Part::Numbers B = {};
			for (int c = 0; c < dim; ++c)
				B += A[a][c] * A[b][c];
			squares += B * B;
			if (a == b) trace += B;
		}
	const typename Part::Numbers mean = trace / dim;
	const typename Part::Numbers deviator = squares - dim * mean * mean;
	return mean +
	       sqrtOf<Part>((dim - 1.) / dim * larger<Part>(deviator, typename Part::Numbers {}));
}

} // namespace softgrain
