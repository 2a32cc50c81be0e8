// Asks for memory that will be needed soon, so that nothing waits for it then.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace softgrain {

/// Bytes that come from memory together.
constexpr std::uintptr_t cacheLine = 64;

/// So many lines from the one with this number on.
inline void fetchLines(std::uintptr_t first, std::uintptr_t count)
{
	for (std::uintptr_t line = first; line < first + count; ++line)
		__builtin_prefetch(reinterpret_cast<const void*>(line * cacheLine), 1);
}

/// The line of an address.
inline std::uintptr_t lineOf(const void* at)
{
	return reinterpret_cast<std::uintptr_t>(at) / cacheLine;
}

/// Lines that hold [from, to).
inline std::uintptr_t linesOf(const void* from, const void* to)
{
	return from == to ? 0 : lineOf(static_cast<const char*>(to) - 1) - lineOf(from) + 1;
}

/// What lies in [from, to).
inline void fetchBytes(const void* from, const void* to)
{
	fetchLines(lineOf(from), linesOf(from, to));
}

/// Pieces of memory by their addresses alone: asking for one that is no longer there does no harm.
class MemoryPieces {
public:
	static constexpr int most = 6; ///< those of a pair of grains

	/// Those beyond `most` are left out.
	void add(const void* from, const void* to)
	{
		const auto free = std::find(piece_.begin(), piece_.end(), none);
		const std::uintptr_t lines = std::min(linesOf(from, to), mostLines);
		if (free != piece_.end()) *free = lineOf(from) << bitsOfCount | lines;
	}
	template <class T> void add(const T& object) { add(&object, &object + 1); }
	template <class T> void add(const std::vector<T>& numbers)
	{
		add(numbers.data(), numbers.data() + numbers.size());
	}
	void fetch() const
	{
		for (std::uintptr_t piece : piece_)
			fetchLines(piece >> bitsOfCount, piece & mostLines);
	}

private:
	static constexpr int bitsOfCount = 10; ///< of 64: numbers of lines have 51 at most
	static constexpr std::uintptr_t mostLines = (1 << bitsOfCount) - 1, none = 0;

	/// Of a piece its first line and, in the last bits, how many: there are two sets of pieces
	/// for each interaction, which are memory, too.
	std::array<std::uintptr_t, most> piece_ {};
};

/// What the turns of a loop that is run again and again read, as they noted it when it was run
/// last. Turns may be shared among threads: what is noted is not looked at before the next run.
class LoopMemory {
public:
	/// Between two runs.
	void beginRun(std::size_t turns)
	{
		std::swap(known_, noted_);
		noted_.resize(turns);
	}
	void note(std::size_t turn, const MemoryPieces& read)
	{
		if (turn < noted_.size()) noted_[turn] = read;
	}
	/// Asks for what a turn will read.
	void fetch(std::size_t turn) const
	{
		if (turn < known_.size()) known_[turn].fetch();
	}

private:
	std::vector<MemoryPieces> known_, noted_;
};

} // namespace softgrain
