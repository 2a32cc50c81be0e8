#include "grain/GrainSet.hpp"

#include <stdexcept>
#include <string>

namespace softgrain {

void requireSize(const char* what, const std::vector<double>& numbers, int expected)
{
	if (static_cast<int>(numbers.size()) == expected) return;
	throw std::invalid_argument(
		"its saved " + std::string(what) + " are " + std::to_string(numbers.size()) +
		" numbers, its discretisation needs " + std::to_string(expected) +
		"; discretisation parameters cannot be changed after the first "
		"step");
}

} // namespace softgrain
