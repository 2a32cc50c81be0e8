// Times of softgrain in YADE's own books: yade.timing.stats() prints them while O.timingEnabled.
#pragma once

#include "Yade.hpp"

#include <algorithm>

namespace yade {

/// Adds to the line `label` of the details of an engine or functor.
inline void addTime(TimingDeltas& details, const string& label, TimingInfo::delta nanoseconds,
		    long count)
{
	const auto found = std::find(details.labels.begin(), details.labels.end(), label);
	const auto line = found - details.labels.begin();
	if (found == details.labels.end()) {
		details.labels.push_back(label);
		details.data.emplace_back();
	}
	details.data[line].nsec += nanoseconds;
	details.data[line].nExec += count;
}

} // namespace yade
