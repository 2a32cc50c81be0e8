// Time by phase of a step, for whoever asks for it.
#pragma once

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>
#include <vector>

namespace softgrain {

/// Books the time since `start`, or since the phase before, on the phase that just ended: phases
/// follow one another, and their times add up to the whole. Switched off, a phase costs one branch.
class PhaseClock {
public:
	struct Entry {
		std::string_view phase; ///< name of the function that does it
		long long nanoseconds = 0;
		long count = 0;
	};

	/// Switches the clock on or off, and begins the first phase.
	void start(bool on)
	{
		on_ = on;
		if (on_) last_ = Clock::now();
	}

	/// Ends the present phase; `phase` must live as long as the clock (a literal).
	void end(std::string_view phase)
	{
		if (on_) book(phase);
	}

	/// What was booked since the last call, in the order of the phases' first ends.
	std::vector<Entry> take() { return std::exchange(entries_, {}); }

private:
	using Clock = std::chrono::steady_clock;

	void book(std::string_view phase)
	{
		const Clock::time_point now = Clock::now();
		auto entry = std::find_if(entries_.begin(), entries_.end(),
					  [&](const Entry& e) { return e.phase == phase; });
		if (entry == entries_.end()) entry = entries_.insert(entry, { phase });
		entry->nanoseconds +=
			std::chrono::duration_cast<std::chrono::nanoseconds>(now - last_).count();
		++entry->count;
		last_ = now;
	}

	bool on_ = false;
	Clock::time_point last_;
	std::vector<Entry> entries_;
};

} // namespace softgrain
