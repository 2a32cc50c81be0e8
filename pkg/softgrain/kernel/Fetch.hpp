// Asks for memory that will be needed soon, so that nothing waits for it then.
#pragma once

namespace softgrain {

inline void fetchBytes(const void* from, const void* to)
{
	constexpr int cacheLine = 64; // bytes
	for (auto at = static_cast<const char*>(from); at < to; at += cacheLine)
		__builtin_prefetch(at, 1);
}

} // namespace softgrain
