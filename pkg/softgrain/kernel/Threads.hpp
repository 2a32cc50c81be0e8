// How many threads a loop is worth.
#pragma once

namespace softgrain {

/// For a loop over so many grains, or pairs: to wake a thread takes as long as what it does with
/// `countPerThread`, so from twice as many on threads share it. All of them or one: libgomp ends
/// those that a smaller team leaves out, and makes them anew for the next larger one.
inline int threadsFor(long count, int threads, int countPerThread = 16)
{
	return count >= 2 * countPerThread ? threads : 1;
}

} // namespace softgrain
