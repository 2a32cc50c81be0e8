// How many threads a loop is worth.
#pragma once

#include <algorithm>

namespace softgrain {

/// For a loop over so many grains, or pairs: to wake a thread takes as long as what it does with
/// `countPerThread`. Two threads share the loop if each has as many, more of them from half as many
/// on. All threads or one: libgomp ends those that a smaller team leaves out, and makes them anew
/// for the next larger one.
inline int threadsFor(long count, int threads, int countPerThread = 16)
{
	return count >= std::max(2, threads / 2) * countPerThread ? threads : 1;
}

} // namespace softgrain
