#include "contact/solve/SweepPlan.hpp"
#include "Islands.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>

namespace softgrain {

namespace {

/// Half of the pairs of disks and more lie within a cluster of so many, and what contact reads and
/// writes of them fits into a core's caches. Larger ones leave too few tasks to share.
constexpr int bodiesPerCluster = 16;

/// Colours told apart by bits. A cluster with more tasks than that gives each further one a colour
/// of its own: they have to follow one another anyway.
constexpr int bits = 64;

/// Neighbours of all bodies, in the order of the pairs.
class Graph {
public:
	Graph(const std::vector<BodiesOfPair>& pairs, int bodies)
		: begin_(bodies + 1, 0)
	{
		forEachEdge(pairs, [this](int a, int b) {
			++begin_[a + 1];
			++begin_[b + 1];
		});
		std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
		std::vector<int> next(begin_.begin(), begin_.end() - 1);
		neighbour_.resize(begin_.back());
		forEachEdge(pairs, [&](int a, int b) {
			neighbour_[next[a]++] = b;
			neighbour_[next[b]++] = a;
		});
	}
	template <class Visit> void forEachNeighbour(int body, Visit&& visit) const
	{
		for (int k = begin_[body]; k < begin_[body + 1]; ++k)
			visit(neighbour_[k]);
	}

private:
	template <class Visit>
	static void forEachEdge(const std::vector<BodiesOfPair>& pairs, Visit&& visit)
	{
		for (const BodiesOfPair& pair : pairs)
			if (pair.second >= 0) visit(pair.first, pair.second);
	}
	std::vector<int> begin_, neighbour_;
};

/// Number of the cluster of each body: neighbours of neighbours, breadth first.
std::vector<int> clustersOf(const Graph& graph, int bodies)
{
	constexpr int none = -1;
	std::vector<int> cluster(bodies, none), members;
	int clusters = 0;
	for (int first = 0; first < bodies; ++first) {
		if (cluster[first] != none) continue;
		members.assign(1, first);
		cluster[first] = clusters;
		for (std::size_t k = 0; k < members.size(); ++k)
			graph.forEachNeighbour(members[k], [&](int b) {
				if (cluster[b] != none ||
				    static_cast<int>(members.size()) >= bodiesPerCluster)
					return;
				cluster[b] = clusters;
				members.push_back(b);
			});
		++clusters;
	}
	return cluster;
}

/// Pairs of two clusters or, if they are the same, of one.
struct Task {
	bool across;
	int first, second; ///< clusters
	int begin, end;    ///< of the pairs, in their order by tasks
};

/// Orders the pairs by tasks: those within clusters first, in the order of the clusters; pairs of a
/// task in the given order.
std::vector<Task> tasksOf(const std::vector<BodiesOfPair>& pairs, const std::vector<int>& cluster,
			  std::vector<int>& order)
{
	auto clustersOf = [&](const BodiesOfPair& pair) {
		const int a = cluster[pair.first];
		return std::minmax({ a, pair.second >= 0 ? cluster[pair.second] : a });
	};
	constexpr int digits = 31;
	std::vector<std::pair<std::uint64_t, int>> numbered; // by tasks, and which pairs they are
	numbered.reserve(pairs.size());
	for (const BodiesOfPair& pair : pairs) {
		const auto [a, b] = clustersOf(pair);
		const std::uint64_t across = a != b, first = a, second = b;
		numbered.emplace_back(across << 2 * digits | first << digits | second,
				      numbered.size());
	}
	std::sort(numbered.begin(), numbered.end());
	std::vector<Task> tasks;
	order.clear();
	for (std::size_t k = 0; k < numbered.size(); ++k) {
		const auto& [task, pair] = numbered[k];
		const int begin = static_cast<int>(order.size());
		if (k == 0 || task != numbered[k - 1].first) {
			const auto [a, b] = clustersOf(pairs[pair]);
			tasks.push_back({ a != b, a, b, begin, begin });
		}
		++tasks.back().end;
		order.push_back(pair);
	}
	return tasks;
}

/// Place of each cluster in a row in which neighbours are near each other: breadth first.
std::vector<int> placesOf(const std::vector<Task>& tasks, int clusters)
{
	std::vector<BodiesOfPair> neighbours;
	for (const Task& task : tasks)
		if (task.across) neighbours.push_back({ task.first, task.second });
	const Graph graph(neighbours, clusters);
	constexpr int none = -1;
	std::vector<int> place(clusters, none), row;
	auto add = [&](int cluster) {
		if (place[cluster] != none) return;
		place[cluster] = static_cast<int>(row.size());
		row.push_back(cluster);
	};
	std::size_t grown = 0; // of the row, those whose neighbours have been added
	for (int first = 0; first < clusters; ++first) {
		add(first);
		for (; grown < row.size(); ++grown)
			graph.forEachNeighbour(row[grown], add);
	}
	return place;
}

/// Puts each task into the first colour none of whose tasks shares a cluster with it.
std::vector<std::vector<const Task*>> coloursOf(const std::vector<Task>& tasks, int clusters)
{
	std::vector<std::uint64_t> taken(clusters, 0); // colours of the tasks of a cluster
	std::vector<std::vector<const Task*>> colours, beyond;
	for (const Task& task : tasks) {
		const int colour = std::countr_one(taken[task.first] | taken[task.second]);
		if (colour == bits) {
			beyond.push_back({ &task });
			continue;
		}
		taken[task.first] |= std::uint64_t(1) << colour;
		taken[task.second] |= std::uint64_t(1) << colour;
		if (colour >= static_cast<int>(colours.size())) colours.resize(colour + 1);
		colours[colour].push_back(&task);
	}
	colours.insert(colours.end(), beyond.begin(), beyond.end());
	return colours;
}

/// SweepPlan::island, numbered as they come.
void findIslands(const std::vector<BodiesOfPair>& pairs, int bodies, SweepPlan& plan)
{
	Islands islands(bodies);
	for (const BodiesOfPair& pair : pairs)
		if (pair.second >= 0) islands.join(pair.first, pair.second);
	std::vector<int> number(bodies, -1);
	for (int pair : plan.pairs) {
		int& island = number[islands.of(pairs[pair].first)];
		if (island < 0) island = plan.islands++;
		plan.island.push_back(island);
	}
}

} // namespace

SweepPlan planSweeps(const std::vector<BodiesOfPair>& pairs, int bodies)
{
	const std::vector<int> cluster = clustersOf(Graph(pairs, bodies), bodies);
	std::vector<int> order;
	const auto tasks = tasksOf(pairs, cluster, order);
	SweepPlan plan;
	plan.pairs.reserve(pairs.size());
	const std::vector<int> place = placesOf(tasks, bodies);
	auto placeOf = [&](const Task* task) {
		return std::minmax(place[task->first], place[task->second]);
	};
	long work = 0;
	for (auto& colour : coloursOf(tasks, bodies)) {
		std::stable_sort(colour.begin(), colour.end(), [&](const Task* a, const Task* b) {
			return placeOf(a) < placeOf(b);
		});
		for (const Task* task : colour) {
			for (int k = task->begin; k < task->end; ++k) {
				plan.pairs.push_back(order[k]);
				work += pairs[order[k]].work;
			}
			plan.taskEnd.push_back(static_cast<int>(plan.pairs.size()));
			plan.workEnd.push_back(work);
		}
		plan.colourEnd.push_back(plan.tasks());
	}
	findIslands(pairs, bodies, plan);
	return plan;
}

std::pair<int, int> SweepPlan::shareOf(int colour, int part, int parts) const
{
	const int first = colour > 0 ? colourEnd[colour - 1] : 0, end = colourEnd[colour];
	auto workBefore = [this](int task) { return task > 0 ? workEnd[task - 1] : 0; };
	const long before = workBefore(first), work = workBefore(end) - before;
	// the task behind those whose middle lies within the first k of `parts` shares of the work
	auto endOf = [&](int k) {
		const double limit = before + static_cast<double>(work) * k / parts;
		int task = first;
		while (task < end && workBefore(task) + workEnd[task] < 2 * limit)
			++task;
		return task;
	};
	return { endOf(part), endOf(part + 1) };
}

} // namespace softgrain
