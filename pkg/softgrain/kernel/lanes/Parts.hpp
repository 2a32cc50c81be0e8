// Parts of Lanes that one register holds. Loops over arrays work on one after the other: vectors
// that are wider than registers would stay in memory, and be copied there in pieces.
#pragma once

#include "lanes/FourNumbers.hpp"
#include "lanes/Lanes.hpp"

#include <utility>

namespace softgrain {

/// With AVX-512.
struct WholeLanes {
	using Numbers = Lanes;
	using Unaligned = detail::UnalignedLanes;
	using Bits = LaneBits;
	static constexpr int width = laneWidth;
};
/// With AVX2, and in two registers of the baseline.
struct HalfLanes {
	using Numbers = FourNumbers;
	using Unaligned = FourNumbers;
	static constexpr int width = laneWidth / 2;
	using Bits [[gnu::vector_size(width * sizeof(double)), gnu::aligned(alignof(double)),
		     gnu::may_alias]] = unsigned long long;
};
static_assert(HalfLanes::width * sizeof(double) == sizeof(FourNumbers));

/// Calls `use(kind of the parts)`.
template <class Use> void withParts(Use&& use)
{
	if (__builtin_cpu_supports("x86-64-v4"))
		use(WholeLanes {});
	else
		use(HalfLanes {});
}
/// Calls `use(kind of the part, its first lane)` for all parts.
template <class Use> void forEachPart(Use&& use)
{
	withParts([&](auto part) {
		for (int begin = 0; begin < laneWidth; begin += part.width)
			use(part, begin);
	});
}

/// The lanes from `begin` on.
template <class Part> typename Part::Numbers& partOf(Lanes& lanes, int begin)
{
	return *reinterpret_cast<typename Part::Numbers*>(reinterpret_cast<double*>(&lanes) +
							  begin);
}
template <class Part> const typename Part::Numbers& partOf(const Lanes& lanes, int begin)
{
	return partOf<Part>(const_cast<Lanes&>(lanes), begin);
}

/// Lane by lane: of vectors that are wider than registers the compiler takes comparisons apart into
/// single numbers.
template <class Part = WholeLanes, class Function>
typename Part::Numbers inEveryLane(Function&& function)
{
	typename Part::Numbers y;
#pragma omp simd simdlen(Part::width)
	for (int l = 0; l < Part::width; ++l)
		y[l] = function(l);
	return y;
}

template <class Part = WholeLanes>
typename Part::Numbers larger(const typename Part::Numbers& x, const typename Part::Numbers& y)
{
	return inEveryLane<Part>([&](int l) { return x[l] > y[l] ? x[l] : y[l]; });
}

/// From the k-th of `count` numbers on; zero behind their end.
template <class Part> typename Part::Numbers numbersFrom(const double* numbers, int k, int count)
{
	if (k + Part::width <= count)
		return *reinterpret_cast<const typename Part::Unaligned*>(numbers + k);
	typename Part::Numbers some = {};
	for (int i = k; i < count; ++i)
		some[i - k] = numbers[i];
	return some;
}
/// To the k-th of `count` numbers and what follows, as far as there are.
template <class Part>
void putNumbers(const typename Part::Numbers& from, double* numbers, int k, int count)
{
	if (k + Part::width <= count) {
		*reinterpret_cast<typename Part::Unaligned*>(numbers + k) = from;
		return;
	}
	for (int i = k; i < count; ++i)
		numbers[i] = from[i - k];
}

namespace detail {

/// Every other block of `step` numbers of one row against the block before it of the other.
template <class Part, int step, std::size_t... l>
void exchangeBlocks(typename Part::Numbers& x, typename Part::Numbers& y, std::index_sequence<l...>)
{
	constexpr int width = Part::width;
	const typename Part::Numbers first =
		__builtin_shufflevector(x, y, (l & step ? width + l - step : l)...);
	y = __builtin_shufflevector(x, y, (l & step ? width + l : l + step)...);
	x = first;
}

} // namespace detail

/// Number i of row j becomes number j of row i.
template <class Part, int step = 1> void transpose(typename Part::Numbers (&row)[Part::width])
{
	if constexpr (step < Part::width) {
		for (int r = 0; r < Part::width; ++r)
			if (!(r & step))
				detail::exchangeBlocks<Part, step>(
					row[r], row[r + step],
					std::make_index_sequence<Part::width>());
		transpose<Part, 2 * step>(row);
	}
}

} // namespace softgrain
