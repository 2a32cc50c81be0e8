// Asks for memory that will be needed soon, so that nothing waits for it then.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace softgrain {

/// What lies in [from, to).
inline void fetchBytes(const void* from, const void* to)
{
	constexpr std::uintptr_t cacheLine = 64; // bytes
	const auto end = reinterpret_cast<std::uintptr_t>(to);
	for (auto at = reinterpret_cast<std::uintptr_t>(from) & ~(cacheLine - 1); at < end;
	     at += cacheLine)
		__builtin_prefetch(reinterpret_cast<const void*>(at), 1);
}

/// Pieces of memory by their addresses alone: asking for one that is no longer there does no harm.
class MemoryPieces {
public:
	static constexpr int most = 6; ///< those of a pair of grains

	/// Those beyond `most` are left out.
	void add(const void* from, const void* to)
	{
		if (count_ < most) piece_[count_++] = { from, to };
	}
	template <class T> void add(const T& object) { add(&object, &object + 1); }
	template <class T> void add(const std::vector<T>& numbers)
	{
		add(numbers.data(), numbers.data() + numbers.size());
	}
	void fetch() const
	{
		for (int k = 0; k < count_; ++k)
			fetchBytes(piece_[k].from, piece_[k].to);
	}

private:
	struct Piece {
		const void *from = nullptr, *to = nullptr;
	};

	int count_ = 0;
	std::array<Piece, most> piece_ {};
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
