// Boxes of the rigid bodies about a grain, side by side: which of them lie beside one that it
// touches is asked for each of these, and where a surface is made of thousands of facets a walk
// through all bodies would take longer than everything else.
#pragma once

#include "Vectors.hpp"

#include <mutex>
#include <unordered_map>
#include <vector>

namespace softgrain {

class NeighbourBoxes {
public:
	struct Entry {
		int id; ///< of the body
		Box<3> box;
	};

	/// Those of a grain; `make` tells them at the first call in a step of the host. Searches
	/// run in parallel.
	template <class Make> const std::vector<Entry>& of(int grain, long step, Make&& make)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		Kept& kept = kept_[grain];
		if (kept.step != step) kept = { step, make() };
		return kept.entries;
	}
	/// Bodies and boxes may be others from now on.
	void forget() { kept_.clear(); }

private:
	struct Kept {
		long step = -1;
		std::vector<Entry> entries;
	};

	std::mutex mutex_;
	std::unordered_map<int, Kept> kept_; ///< by grain; entries stay where they are
};

} // namespace softgrain
