// How many threads a loop is worth.
#pragma once

#include <algorithm>

namespace softgrain {

/// For a loop over so many grains, or pairs: with fewer a thread, waking it takes longer than what
/// it does.
inline int threadsFor(long count, int threads)
{
	constexpr long countPerThread = 16;
	return static_cast<int>(std::clamp(count / countPerThread, 1L, static_cast<long>(threads)));
}

} // namespace softgrain
