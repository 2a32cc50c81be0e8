// Functions of one number in every lane.
#pragma once

#include "lanes/Parts.hpp"

#include <cmath>

// The compiler may take this from the vector mathematics of the C library, for all lanes at once
// (error below 4 units in the last place).
extern "C" {
__attribute__((simd("notinbranch"), const)) double exp(double) noexcept;
}

namespace softgrain {

template <class Part = WholeLanes> typename Part::Numbers expOf(const typename Part::Numbers& x)
{
	return inEveryLane<Part>([&](int l) { return ::exp(x[l]); });
}
template <class Part = WholeLanes> typename Part::Numbers sqrtOf(const typename Part::Numbers& x)
{
	return inEveryLane<Part>([&](int l) { return std::sqrt(x[l]); });
}

/// Natural logarithm, within 2 units in the last place; not a number unless 0 < x < inf, and for
/// the subnormal numbers next to 0. In the loops over material points it costs half of a call of
/// the C library, which leaves no register as it was.
template <class Part = WholeLanes> typename Part::Numbers lnOf(const typename Part::Numbers& x)
{
	using Numbers = typename Part::Numbers;
	using Bits = typename Part::Bits;
	// x = 2^e m with m from sqrt(1/2) to sqrt(2), ln m = 2 artanh s with s = (m - 1)/(m + 1)
	constexpr unsigned long long sqrtHalf = 0x3fe6a09e667f3bcd, exponent = 0xfff0000000000000,
				     sign = 0x8000000000000000, twoTo52 = 0x4330000000000000;
	const Bits bits = reinterpret_cast<Bits>(x);
	const Bits above = bits - sqrtHalf; // its exponent is e
	const Bits mantissa = bits - (above & exponent);
	const Bits shifted = ((above ^ sign) >> 52) | twoTo52; // as a number 2^52 + 2048 + e
	const Numbers m = reinterpret_cast<Numbers>(mantissa);
	const Numbers e = reinterpret_cast<Numbers>(shifted) - (0x1p52 + 2048);
	const Numbers s = (m - 1) / (m + 1), z = s * s, zz = z * z;
	// 2 artanh(s)/s - 2 over z, Chebyshev fit for z up to 0.0295, relative error 5e-18
	const Numbers even = 0x1.5555555555558p-1 +
			     zz * (0x1.2492492dfd86cp-2 +
				   zz * (0x1.7462b91b8df65p-3 + zz * 0x1.2b5f68a50d903p-3));
	const Numbers odd =
		0x1.9999999995273p-2 + zz * (0x1.c71c62d5e53e0p-3 + zz * 0x1.39fdcceb4bb45p-3);
	const Numbers y = 0x1.62e42fefa39efp-1 * e + (2 * s + s * (z * (even + z * odd)));
	// all bits set, not a number, unless x is from the least normal number to the greatest
	constexpr unsigned long long least = 0x0010000000000000, most = 0x7fefffffffffffff;
	const Bits outside = 0 - (((bits - least) | (most - bits)) >> 63);
	return reinterpret_cast<Numbers>(reinterpret_cast<Bits>(y) | outside);
}

} // namespace softgrain
