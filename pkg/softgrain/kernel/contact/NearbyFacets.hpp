// The facets of an outline nearest to a node, noted when they were looked for: while the bodies
// have moved little since, the nearest now is found without a look at others.
#pragma once

#include <algorithm>
#include <array>

namespace softgrain {

/// In their order, nearest first.
template <int dim> class NearbyFacets {
public:
	/// Forgets what was noted. `within`: all facets so near are going to be noted, m.
	void clear(double within)
	{
		count_ = 0;
		beyond_ = toFloat(within);
	}
	/// A facet at this distance, m; the farthest are dropped where there are too many.
	void note(int facet, double distance)
	{
		const float bound = toFloat(distance);
		if (bound >= beyond_) return;
		if (count_ == most) {
			const bool isFarthest = bound >= distance_[most - 1];
			beyond_ = isFarthest ? bound : distance_[--count_];
			if (isFarthest) return;
		}
		int place = count_++;
		for (; place > 0 && distance_[place - 1] > bound; --place) {
			distance_[place] = distance_[place - 1];
			facet_[place] = facet_[place - 1];
		}
		distance_[place] = bound;
		facet_[place] = facet;
	}
	int count() const { return count_; }
	int facet(int k) const { return facet_[k]; }
	/// It was no nearer, m.
	double distance(int k) const { return distance_[k]; }
	/// All others were no nearer, m.
	double distanceOfOthers() const { return beyond_; }

private:
	/// Some more than meet at a node of an outline, all of which are as near where a node lies
	/// over a node: 2, and 6 of most in space.
	static constexpr int most = dim == 2 ? 4 : 8;

	/// No more than `distance`.
	static float toFloat(double distance)
	{
		constexpr double rounding = 1 - 1e-6;
		return static_cast<float>(rounding * distance);
	}

	std::array<int, most> facet_;
	std::array<float, most> distance_;
	int count_ = 0;
	float beyond_ = 0;
};

} // namespace softgrain
