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

} // namespace softgrain

/// Marks a function over lanes: it is compiled for several instruction sets with everything it
/// calls inlined, and the best one for the machine is picked when the program starts.
#define SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS                                                         \
	__attribute__((flatten, target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
