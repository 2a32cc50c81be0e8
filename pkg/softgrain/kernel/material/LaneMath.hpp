// Functions of one number in every lane.
#pragma once

#include "material/Lanes.hpp"

#include <cmath>

// The compiler may take these from the vector mathematics of the C library, for all lanes at once
// (errors below 4 units in the last place).
extern "C" {
__attribute__((simd("notinbranch"), const)) double log(double) noexcept;
__attribute__((simd("notinbranch"), const)) double exp(double) noexcept;
}

namespace softgrain {

#define SOFTGRAIN_IN_EVERY_LANE(name, function)                                                    \
	inline Lanes name(const Lanes& x)                                                          \
	{                                                                                          \
		Lanes y;                                                                           \
		_Pragma("omp simd simdlen(laneWidth)") for (int l = 0; l < laneWidth; ++l) y[l] =  \
			function(x[l]);                                                            \
		return y;                                                                          \
	}
SOFTGRAIN_IN_EVERY_LANE(lnOf, ::log)
SOFTGRAIN_IN_EVERY_LANE(expOf, ::exp)
SOFTGRAIN_IN_EVERY_LANE(sqrtOf, std::sqrt)
#undef SOFTGRAIN_IN_EVERY_LANE

} // namespace softgrain
