// Functions of one number in every lane.
#pragma once

#include "lanes/Lanes.hpp"

#include <cmath>

// The compiler may take this from the vector mathematics of the C library, for all lanes at once
// (error below 4 units in the last place).
extern "C" {
__attribute__((simd("notinbranch"), const)) double exp(double) noexcept;
}

namespace softgrain {

inline Lanes expOf(const Lanes& x)
{
	return inEveryLane([&](int l) { return ::exp(x[l]); });
}
inline Lanes sqrtOf(const Lanes& x)
{
	return inEveryLane([&](int l) { return std::sqrt(x[l]); });
}

/// Natural logarithm, within 2 units in the last place; not a number unless 0 < x < inf, and for
/// the subnormal numbers next to 0. In the loops over material points it costs half of a call of
/// the C library, which leaves no register as it was.
inline Lanes lnOf(const Lanes& x)
{
	// x = 2^e m with m from sqrt(1/2) to sqrt(2), ln m = 2 artanh s with s = (m - 1)/(m + 1)
	constexpr unsigned long long sqrtHalf = 0x3fe6a09e667f3bcd, exponent = 0xfff0000000000000,
				     sign = 0x8000000000000000, twoTo52 = 0x4330000000000000;
	const LaneBits bits = reinterpret_cast<LaneBits>(x);
	const LaneBits above = bits - sqrtHalf; // its exponent is e
	const LaneBits mantissa = bits - (above & exponent);
	const LaneBits shifted = ((above ^ sign) >> 52) | twoTo52; // as a number 2^52 + 2048 + e
	const Lanes m = reinterpret_cast<Lanes>(mantissa);
	const Lanes e = reinterpret_cast<Lanes>(shifted) - (0x1p52 + 2048);
	const Lanes s = (m - 1) / (m + 1), z = s * s, zz = z * z;
	// 2 artanh(s)/s - 2 over z, Chebyshev fit for z up to 0.0295, relative error 5e-18
	const Lanes even = 0x1.5555555555558p-1 +
			   zz * (0x1.2492492dfd86cp-2 +
				 zz * (0x1.7462b91b8df65p-3 + zz * 0x1.2b5f68a50d903p-3));
	const Lanes odd =
		0x1.9999999995273p-2 + zz * (0x1.c71c62d5e53e0p-3 + zz * 0x1.39fdcceb4bb45p-3);
	const Lanes y = 0x1.62e42fefa39efp-1 * e + (2 * s + s * (z * (even + z * odd)));
	// all bits set, not a number, unless x is from the least normal number to the greatest
	constexpr unsigned long long least = 0x0010000000000000, most = 0x7fefffffffffffff;
	const LaneBits outside = 0 - (((bits - least) | (most - bits)) >> 63);
	return reinterpret_cast<Lanes>(reinterpret_cast<LaneBits>(y) | outside);
}

} // namespace softgrain
