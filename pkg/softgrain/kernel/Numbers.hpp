// Figures, vectors and matrices one after the other in a list of numbers, as a save keeps them.
#pragma once

#include <algorithm>
#include <iterator>
#include <type_traits>
#include <vector>

namespace softgrain {

template <class... Parts> void append(std::vector<double>& numbers, const Parts&... parts)
{
	const auto add = [&](const auto& part) {
		using Part = std::decay_t<decltype(part)>;
		if constexpr (std::is_arithmetic_v<Part> || std::is_enum_v<Part>)
			numbers.push_back(static_cast<double>(part));
		else
			std::copy_n(part.data(), part.size(), std::back_inserter(numbers));
	};
	(add(parts), ...);
}

template <class... Parts> std::vector<double> numbersOf(const Parts&... parts)
{
	std::vector<double> numbers;
	append(numbers, parts...);
	return numbers;
}

/// Takes parts out again, in the same order; there must be enough numbers for each.
class NumbersInTurn {
public:
	explicit NumbersInTurn(const std::vector<double>& numbers)
		: next_(numbers.data())
		, end_(next_ + numbers.size())
	{
	}
	template <class... Parts> void take(Parts&&... parts) { (takeOne(parts), ...); }
	/// Vectors and matrices of fixed size, figures.
	template <class Part> Part next()
	{
		Part part;
		takeOne(part);
		return part;
	}
	std::vector<double> rest() const { return { next_, end_ }; }

private:
	template <class Part> void takeOne(Part& part)
	{
		if constexpr (std::is_arithmetic_v<Part> || std::is_enum_v<Part>) {
			part = static_cast<Part>(*next_++);
		} else {
			std::copy_n(next_, part.size(), part.data());
			next_ += part.size();
		}
	}

	const double *next_, *end_;
};

} // namespace softgrain
