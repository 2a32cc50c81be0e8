#include "contact/PairColours.hpp"

#include <bit>
#include <cstdint>

namespace softgrain {

namespace {

/// Colours told apart by bits. A body with more pairs than that gives each further one a colour of
/// its own: they have to follow one another anyway.
constexpr int bits = 64;

} // namespace

template <int dim>
std::vector<std::vector<ContactList<dim>*>> pairColours(const std::vector<ContactList<dim>*>& lists,
							int bodies, int partners)
{
	std::vector<std::uint64_t> taken(bodies + partners, 0); // colours of the pairs of a body
	std::vector<std::vector<ContactList<dim>*>> colours;
	std::vector<ContactList<dim>*> beyond;
	for (ContactList<dim>* list : lists) {
		const int second = list->sharedSecond(bodies);
		std::uint64_t both = taken[list->first];
		if (second >= 0) both |= taken[second];
		const int colour = std::countr_one(both);
		if (colour == bits) {
			beyond.push_back(list);
			continue;
		}
		taken[list->first] |= std::uint64_t(1) << colour;
		if (second >= 0) taken[second] |= std::uint64_t(1) << colour;
		if (colour == static_cast<int>(colours.size())) colours.emplace_back();
		colours[colour].push_back(list);
	}
	for (ContactList<dim>* list : beyond)
		colours.push_back({ list });
	return colours;
}

template std::vector<std::vector<ContactList<2>*>> pairColours(const std::vector<ContactList<2>*>&,
							       int, int);
template std::vector<std::vector<ContactList<3>*>> pairColours(const std::vector<ContactList<3>*>&,
							       int, int);

} // namespace softgrain
