// Checks of input: one wording for all.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string_view>

namespace softgrain {

/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
template <class Number>
[[noreturn]] void refuse(std::string_view parameter, const Number& value, std::string_view range)
{
	std::ostringstream message;
	message << parameter << " = " << value << " is outside the admissible range " << range;
	throw std::invalid_argument(message.str());
}

/// The same unless it holds.
template <class Number>
void require(bool holds, std::string_view parameter, const Number& value, std::string_view range)
{
	if (!holds) refuse(parameter, value, range);
}

} // namespace softgrain
