#include "Helpers.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/Sharing.hpp"
#include "contact/solve/SweepPlan.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <deque>
#include <map>
#include <set>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Pairs of bodies at random, and of a few bodies with a plane.
std::vector<BodiesOfPair> randomPairs(int bodies)
{
	Random random(3);
	std::vector<BodiesOfPair> pairs;
	for (int g = 0; g < bodies; ++g)
		for (int k = 0; k < 2; ++k) {
			const int other = random.index(bodies + 5);
			if (other != g) pairs.push_back({ g, other < bodies ? other : -1 });
		}
	return pairs;
}

/// Bodies of one node each, neighbours in a lattice in contact and a few with a plane, at random
/// places and velocities.
struct Crowd {
	static constexpr int side = 24, count = side * side;
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
		for (const BodiesOfPair& pair : latticeOf(side))
			addList(random, pair.first, pair.second);
		for (int g = 0; g < 5; ++g)
			addList(random, g, -1);
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

/// What the solver makes of it.
std::vector<double> solved(ContactSolver<2>& solver, Crowd& crowd,
			   const std::vector<ContactList<2>*>& lists, int threads)
{
	SolverSettings settings;
	settings.tolerance = 1e-6;
	settings.maxSweeps = 1000;
	std::vector<ContactList<2>> copies;
	for (const ContactList<2>* list : lists)
		copies.push_back(*list);
	REQUIRE(threadsThatShare<2>(copies, crowd.body, {}, {}, threads) == threads);
	solver.plan(lists, static_cast<int>(crowd.body.size()));
	solver.prepare(crowd.body, 1, settings, threads);
	const SolverReport report = solver.solve();
	CHECK(report.converged);
	CHECK(report.active > 100);
	std::vector<double> bits { report.residual, double(report.sweeps),
				   solver.work().friction.after };
	for (const ContactBody<2>& b : crowd.body)
		for (const Vec<2>& v : { b.velocity[0], b.impulse[0] })
			bits.insert(bits.end(), v.data(), v.data() + 2);
	return bits;
}

} // namespace

TEST_CASE("Plan of sweeps: every pair once, no body in two tasks of a colour", "[contact]")
{
	constexpr int bodies = 300;
	const std::vector<BodiesOfPair> pairs = randomPairs(bodies);
	const int count = static_cast<int>(pairs.size());
	const SweepPlan plan = planSweeps(pairs, bodies);
	CHECK(std::set(plan.pairs.begin(), plan.pairs.end()).size() == pairs.size());
	REQUIRE(plan.taskEnd.back() == count);
	REQUIRE(plan.colourEnd.back() == plan.tasks());
	int task = 0, pair = 0;
	for (int colour = 0; colour < plan.colours(); ++colour) {
		std::map<int, int> taskOf; // bodies of this colour
		for (; task < plan.colourEnd[colour]; ++task)
			for (; pair < plan.taskEnd[task]; ++pair)
				for (int body : { pairs[plan.pairs[pair]].first,
						  pairs[plan.pairs[pair]].second })
					if (body >= 0)
						CHECK(taskOf.emplace(body, task).first->second ==
						      task);
	}
	CHECK(plan.tasks() < count / 2); // of two pairs and more
}

TEST_CASE("Plan of sweeps: neighbours share tasks", "[contact]")
{
	constexpr int side = 32;
	const std::vector<BodiesOfPair> pairs = latticeOf(side);
	const SweepPlan plan = planSweeps(pairs, side * side);
	CHECK(plan.taskEnd[plan.colourEnd[0] - 1] > static_cast<int>(pairs.size()) / 2);
	CHECK(plan.colours() < 12);
	// the plan of the same pairs is the same
	CHECK(planSweeps(pairs, side * side).pairs == plan.pairs);
}

TEST_CASE("Plan of sweeps: shares are all tasks, and of the same bodies in all colours",
	  "[contact]")
{
	constexpr int side = 40;
	const std::vector<BodiesOfPair> pairs = latticeOf(side);
	const SweepPlan plan = planSweeps(pairs, side * side);
	for (int parts : { 1, 2, 3, 7 }) {
		CAPTURE(parts);
		std::vector<std::set<int>> partsOf(side *
						   side); // those that have a pair of the body
		int largest = 0, first = 0;
		for (int colour = 0; colour < plan.colours(); ++colour) {
			for (int part = 0; part < parts; ++part) {
				const auto [begin, end] = plan.shareOf(colour, part, parts);
				REQUIRE(begin == first);
				REQUIRE(end >= begin);
				first = end;
				const int from = begin > 0 ? plan.taskEnd[begin - 1] : 0;
				const int to = end > 0 ? plan.taskEnd[end - 1] : 0;
				if (colour == 0) largest = std::max(largest, to - from);
				for (int k = from; k < to; ++k)
					for (int body : { pairs[plan.pairs[k]].first,
							  pairs[plan.pairs[k]].second })
						partsOf[body].insert(part);
			}
			REQUIRE(first == plan.colourEnd[colour]);
		}
		const int mean = plan.taskEnd[plan.colourEnd[0] - 1] / parts;
		CHECK(largest <= mean + 24); // pairs of a cluster of 16 in a square lattice
		const auto shared =
			std::count_if(partsOf.begin(), partsOf.end(),
				      [](const std::set<int>& p) { return p.size() > 1; });
		CHECK(shared <= side * side * (parts - 1) / 8);
	}
}

TEST_CASE("Plan of sweeps: tasks that share a cluster follow one another", "[contact]")
{
	std::vector<BodiesOfPair> pairs;
	for (int k = 1; k <= 3000; ++k) // a star: all clusters but one are single bodies
		pairs.push_back({ 0, k });
	const SweepPlan plan = planSweeps(pairs, 3001);
	CHECK(plan.colours() == plan.tasks());
	for (int k = 0; k < 3000; ++k)
		CHECK(plan.pairs[k] == k);
}

TEST_CASE("Solver: the same bits with any number of threads", "[contact]")
{
	auto solvedBy = [](int threads) {
		Crowd crowd;
		ContactSolver<2> solver;
		return solved(solver, crowd, crowd.pointers(), threads);
	};
	const auto one = solvedBy(1);
	CHECK(solvedBy(2) == one);
	CHECK(solvedBy(3) == one);
}

TEST_CASE("Solver: what it keeps of the step before changes nothing", "[contact]")
{
	auto fewer = [](Crowd& crowd) {
		auto lists = crowd.pointers();
		lists.resize(lists.size() / 2);
		return std::vector(lists.rbegin(), lists.rend());
	};
	auto solvedFirst = [](ContactSolver<2>& solver, auto&& choose, int threads) {
		Crowd crowd; // gone when the solver goes on
		return solved(solver, crowd, choose(crowd), threads);
	};
	auto all = [](Crowd& crowd) { return crowd.pointers(); };
	ContactSolver<2> fresh, another;
	const auto ofAll = solvedFirst(fresh, all, 1), ofFewer = solvedFirst(another, fewer, 1);
	for (int threads : { 1, 2, 3 }) {
		ContactSolver<2> solver;
		for (int turn = 0; turn < 3; ++turn) {
			CHECK(solvedFirst(solver, all, threads) == ofAll);
			CHECK(solvedFirst(solver, fewer, threads) == ofFewer);
		}
	}
}
