// Checks of input: one wording for all.
#pragma once

#include <sstream>
#include <stdexcept>

namespace softgrain {

/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
template <class Number>
void require(bool holds, const char* parameter, const Number& value, const char* range)
{
	if (holds) return;
	std::ostringstream message;
	message << parameter << " = " << value << " is outside the admissible range " << range;
	throw std::invalid_argument(message.str());
}

} // namespace softgrain
