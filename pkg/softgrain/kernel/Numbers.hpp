// Vectors and matrices one after the other in a list of numbers, as a save keeps them.
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

namespace softgrain {

template <class Part> void append(const Part& part, std::vector<double>& numbers)
{
	std::copy_n(part.data(), part.size(), std::back_inserter(numbers));
}

/// Takes parts out again, in the same order; there must be enough numbers for each.
class NumbersInTurn {
public:
	explicit NumbersInTurn(const double* first)
		: next_(first)
	{
	}
	template <class Part> void take(Part& part)
	{
		std::copy_n(next_, part.size(), part.data());
		next_ += part.size();
	}
	double takeOne() { return *next_++; }
	const double* rest() const { return next_; }

private:
	const double* next_;
};

} // namespace softgrain
