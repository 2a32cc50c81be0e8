// Which bodies hang together.
#pragma once

#include <numeric>
#include <vector>

namespace softgrain {

/// Disjoint sets of bodies: each at first alone, then joined two by two. An island is named by its
/// lowest body.
class Islands {
public:
	explicit Islands(int bodies)
		: parent_(bodies)
	{
		std::iota(parent_.begin(), parent_.end(), 0);
	}
	void join(int a, int b)
	{
		a = of(a), b = of(b);
		parent_[a < b ? b : a] = a < b ? a : b;
	}
	int of(int body)
	{
		while (parent_[body] != body) {
			parent_[body] = parent_[parent_[body]]; // halves the way for who comes next
			body = parent_[body];
		}
		return body;
	}

private:
	std::vector<int> parent_;
};

} // namespace softgrain
