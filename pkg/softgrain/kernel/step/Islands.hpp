// Which grains hang together.
#pragma once

#include <numeric>
#include <vector>

namespace softgrain {

/// Disjoint sets of grains: each at first alone, then joined two by two. An island is named by its
/// lowest grain.
class Islands {
public:
	explicit Islands(int grains)
		: parent_(grains)
	{
		std::iota(parent_.begin(), parent_.end(), 0);
	}
	void join(int a, int b)
	{
		a = of(a), b = of(b);
		parent_[a < b ? b : a] = a < b ? a : b;
	}
	int of(int g)
	{
		while (parent_[g] != g) {
			parent_[g] = parent_[parent_[g]]; // halves the way for who comes next
			g = parent_[g];
		}
		return g;
	}

private:
	std::vector<int> parent_;
};

} // namespace softgrain
