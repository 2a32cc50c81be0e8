// The unit of the bulk computation and of the search: `laneWidth` numbers side by side, be it of as
// many congruent grains, of material points of one grain, or of nodes.
#pragma once

#include <initializer_list>

namespace softgrain {

/// Eight doubles fill an AVX-512 register.
constexpr int laneWidth = 8;

/// One number in every lane. The compiler computes with it as with one number, in as many
/// instructions as the instruction set needs for all lanes. (The alignment is named because it
/// would depend on the instruction set; as a template argument the type loses it: see LaneSlot.)
using Lanes
	[[gnu::vector_size(laneWidth * sizeof(double)), gnu::aligned(laneWidth * sizeof(double))]] =
		double;
/// The bits of Lanes.
using LaneBits [[gnu::vector_size(laneWidth * sizeof(double)),
		 gnu::aligned(laneWidth * sizeof(double)), gnu::may_alias]] = unsigned long long;
/// An element of containers.
struct LaneSlot {
	Lanes value;
};
namespace detail {
using UnalignedLanes [[gnu::vector_size(laneWidth * sizeof(double)), gnu::aligned(alignof(double)),
		       gnu::may_alias]] = double;
}

/// From and to `laneWidth` elements of an array of numbers.
inline Lanes loadLanes(const double* from)
{
	return *reinterpret_cast<const detail::UnalignedLanes*>(from);
}
inline void storeLanes(double* to, const Lanes& lanes)
{
	*reinterpret_cast<detail::UnalignedLanes*>(to) = lanes;
}

/// Lane i of row j becomes lane j of row i.
inline void transpose(Lanes (&row)[laneWidth])
{
	static_assert(laneWidth == 8);
	auto exchange = [](Lanes& x, Lanes& y, const LaneBits& low, const LaneBits& high) {
		const Lanes first = __builtin_shuffle(x, y, low);
		y = __builtin_shuffle(x, y, high);
		x = first;
	};
	for (int r = 0; r < laneWidth; r += 2)
		exchange(row[r], row[r + 1], LaneBits { 0, 8, 2, 10, 4, 12, 6, 14 },
			 LaneBits { 1, 9, 3, 11, 5, 13, 7, 15 });
	for (int r : { 0, 1, 4, 5 })
		exchange(row[r], row[r + 2], LaneBits { 0, 1, 8, 9, 4, 5, 12, 13 },
			 LaneBits { 2, 3, 10, 11, 6, 7, 14, 15 });
	for (int r = 0; r < laneWidth / 2; ++r)
		exchange(row[r], row[r + 4], LaneBits { 0, 1, 2, 3, 8, 9, 10, 11 },
			 LaneBits { 4, 5, 6, 7, 12, 13, 14, 15 });
}

/// Lane by lane: of whole vectors that are wider than its registers (AVX2) the compiler takes
/// comparisons apart into single numbers.
template <class Function> Lanes inEveryLane(Function&& function)
{
	Lanes y;
#pragma omp simd simdlen(laneWidth)
	for (int l = 0; l < laneWidth; ++l)
		y[l] = function(l);
	return y;
}

inline Lanes larger(const Lanes& x, const Lanes& y)
{
	return inEveryLane([&](int l) { return x[l] > y[l] ? x[l] : y[l]; });
}

} // namespace softgrain

/// Marks a function over lanes: it is compiled for several instruction sets with everything it
/// calls inlined, and the best one for the machine is picked when the program starts.
#define SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS                                                         \
	__attribute__((flatten, target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
