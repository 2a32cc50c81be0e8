#include "Helpers.hpp"
#include "contact/ContactSolver.hpp"
#include "contact/PairColours.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <deque>
#include <set>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Bodies of one node each, all of them in contact with some others and a few with a plane, at
/// random places and velocities.
struct Crowd {
	static constexpr int count = 300;
	SparseRows<double> table;
	OutlineMesh<2> mesh;
	std::vector<ContactBody<2>> body = std::vector<ContactBody<2>>(count);
	std::deque<ContactList<2>> lists;

	Crowd()
	{
		Random random(3);
		table.append(0, 1);
		table.closeRow();
		for (ContactBody<2>& b : body) {
			b.delassus = &table;
			b.delassusScale = random.uniform(0.5, 2);
			b.mesh = &mesh;
			b.position.resize(1);
			b.velocity = b.velocityBefore = { random.vector<2>() };
			b.impulse = { Vec<2>::Zero() };
		}
		for (int g = 0; g < count; ++g)
			for (int k = 0; k < 2; ++k) {
				const int other = random.index(count + 5);
				if (other == g) continue;
				addList(random, g, other < count ? other : -1);
			}
	}
	void addList(Random& random, int first, int second)
	{
		ContactList<2> list;
		list.first = first;
		list.second = second;
		list.friction = 0.1;
		Contact<2> contact;
		contact.key = { 0, 0, -1 };
		contact.normal = list.plane.normal = random.direction<2>();
		contact.partners = second < 0 ? 0 : 1;
		contact.weight[0] = 1;
		contact.gap = random.uniform(0, 0.1);
		list.contacts = { contact };
		lists.push_back(list);
	}
	std::vector<ContactList<2>*> pointers()
	{
		std::vector<ContactList<2>*> all;
		for (ContactList<2>& list : lists)
			all.push_back(&list);
		return all;
	}
};

} // namespace

TEST_CASE("Colours: every pair once, no body twice in a colour", "[contact]")
{
	Crowd crowd;
	const auto colours = pairColours<2>(crowd.pointers(), Crowd::count);
	std::set<ContactList<2>*> seen;
	for (const auto& colour : colours) {
		std::set<int> bodies;
		for (ContactList<2>* list : colour) {
			CHECK(seen.insert(list).second);
			CHECK(bodies.insert(list->first).second);
			if (list->second >= 0) CHECK(bodies.insert(list->second).second);
		}
	}
	CHECK(seen.size() == crowd.lists.size());
	CHECK(colours.size() < 20); // a body has 4 pairs on average
}

TEST_CASE("Colours: a body with many pairs gives each its own", "[contact]")
{
	std::deque<ContactList<2>> lists;
	std::vector<ContactList<2>*> pointers;
	for (int k = 1; k <= 100; ++k) {
		lists.emplace_back();
		lists.back().first = 0;
		lists.back().second = k;
		pointers.push_back(&lists.back());
	}
	const auto colours = pairColours<2>(pointers, 101);
	REQUIRE(colours.size() == 100);
	for (int k = 0; k < 100; ++k)
		CHECK(colours[k] == std::vector<ContactList<2>*> { pointers[k] });
}

TEST_CASE("Solver: the same bits with any number of threads", "[contact]")
{
	auto solved = [](int threads) {
		Crowd crowd;
		SolverSettings settings;
		settings.tolerance = 1e-6;
		settings.maxSweeps = 1000;
		ContactSolver<2> solver;
		solver.prepare(crowd.body, crowd.pointers(), 1, settings, threads);
		const SolverReport report = solver.solve();
		CHECK(report.converged);
		CHECK(report.active > 200);
		std::vector<double> bits { report.residual, double(report.sweeps),
					   solver.work().friction.after };
		for (const ContactBody<2>& b : crowd.body)
			for (const Vec<2>& v : { b.velocity[0], b.impulse[0] })
				bits.insert(bits.end(), v.data(), v.data() + 2);
		return bits;
	};
	const auto one = solved(1);
	CHECK(solved(2) == one);
	CHECK(solved(3) == one);
}
