// Contacts of a grain with rigid surfaces, alone and beside each other.
#pragma once

#include "Helpers.hpp"
#include "contact/search/Search.hpp"

#include <catch2/catch_test_macros.hpp>
#include <set>
#include <vector>

namespace softgrain::testing {

template <int dim> ContactList<dim> listWith(const RigidSurface<dim>& surface)
{
	ContactList<dim> list;
	list.first = 0;
	list.rigid.emplace();
	list.rigid->surface = surface;
	return list;
}

/// Contacts with surfaces beside each other, of which the former come first.
template <int dim>
std::vector<Contact<dim>> contactsWith(const std::vector<RigidSurface<dim>>& surfaces,
				       const ContactBody<dim>& body, double reach)
{
	std::vector<Contact<dim>> all;
	for (std::size_t k = 0; k < surfaces.size(); ++k) {
		auto list = listWith<dim>(surfaces[k]);
		list.rigid->others = [&] {
			std::vector<SurfaceBeside<dim>> others;
			for (std::size_t j = 0; j < surfaces.size(); ++j)
				if (j != k) others.push_back({ surfaces[j], j < k });
			return others;
		};
		findContacts<dim>(body, reach, list);
		CHECK(list.deepest < 0.5); // in dr
		all.insert(all.end(), list.contacts.begin(), list.contacts.end());
	}
	return all;
}

/// How many contact nodes have a contact; that none has two is checked.
template <int dim> int nodesOnce(const std::vector<Contact<dim>>& contacts)
{
	std::set<int> nodes;
	int count = 0;
	for (const Contact<dim>& c : contacts) {
		if (c.key.side != 0) continue;
		nodes.insert(c.key.node);
		++count;
	}
	CHECK(static_cast<int>(nodes.size()) == count);
	return count;
}

} // namespace softgrain::testing
