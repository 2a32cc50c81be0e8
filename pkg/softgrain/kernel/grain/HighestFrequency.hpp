// The highest angular frequency of grains as they are deformed: the largest eigenvalue of M^-1 K
// with the tangent K as differences of internal forces, by Lanczos' iteration. Raised a little
// because that approaches from below.
#pragma once

#include "grain/Batch.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace softgrain {

/// Of one grain, rad/s, within 1 %. Takes the time of 40 computations of its forces.
template <int dim> double highestFrequency(const Batch<dim>& batch, int g);

struct MeasuredFrequency {
	double frequency; ///< rad/s
	int forces;       ///< computations of the grain's forces that it took
};

/// Of grains of a batch, side by side, in the time of 24, or of 8 if what is found of the k-th of
/// them then, raised by 4 %, suffices, which `suffices(k, frequency)` tells.
template <int dim>
std::vector<MeasuredFrequency>
highestFrequencies(const Batch<dim>& batch, const std::vector<int>& grains,
		   const std::function<bool(std::size_t, double)>& suffices);

} // namespace softgrain
