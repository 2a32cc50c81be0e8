// Four numbers of an array at once: what one register of AVX2 holds. (Lanes, eight numbers, are
// computed with on all machines, but with AVX2 their shuffles go through memory.)
#pragma once

namespace softgrain {

using FourNumbers
	[[gnu::vector_size(4 * sizeof(double)), gnu::aligned(alignof(double)), gnu::may_alias]] =
		double;
/// For shuffles: the places of four numbers in one vector, or in two one behind the other.
using FourPlaces [[gnu::vector_size(4 * sizeof(long long))]] = long long;

inline FourNumbers& fourAt(double* first) { return *reinterpret_cast<FourNumbers*>(first); }
inline const FourNumbers& fourAt(const double* first)
{
	return *reinterpret_cast<const FourNumbers*>(first);
}

inline double sumOf(const FourNumbers& numbers)
{
	return numbers[0] + numbers[1] + numbers[2] + numbers[3];
}

} // namespace softgrain
