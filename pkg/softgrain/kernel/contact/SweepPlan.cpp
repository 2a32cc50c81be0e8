#include "contact/SweepPlan.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <tuple>

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

/// Number of the cluster of each body: neighbours of neighbours, breadth first, and each cluster
/// beside an earlier one if there is room, so that neighbouring clusters have neighbouring numbers.
std::vector<int> clustersOf(const Graph& graph, int bodies)
{
	constexpr int none = -1;
	std::vector<int> cluster(bodies, none), gathered; // in the order of the clusters
	int clusters = 0;
	auto gather = [&](int first) {
		std::size_t k = gathered.size(), end = k + bodiesPerCluster;
		auto add = [&](int body) {
			if (cluster[body] != none || gathered.size() >= end) return;
			cluster[body] = clusters;
			gathered.push_back(body);
		};
		add(first);
		for (; k < gathered.size(); ++k)
			graph.forEachNeighbour(gathered[k], add);
		++clusters;
	};
	std::size_t grown = 0; // of `gathered`, those whose neighbours have all been met
	for (int first = 0; first < bodies; ++first) {
		if (cluster[first] != none) continue;
		gather(first);
		for (; grown < gathered.size(); ++grown)
			graph.forEachNeighbour(gathered[grown], [&](int b) {
				if (cluster[b] == none) gather(b);
			});
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
	using Key = std::tuple<bool, int, int, int>; // across, clusters, number of the pair
	std::vector<Key> keys;
	keys.reserve(pairs.size());
	for (const BodiesOfPair& pair : pairs) {
		const int a = cluster[pair.first], b = pair.second >= 0 ? cluster[pair.second] : a;
		keys.emplace_back(a != b, std::min(a, b), std::max(a, b), keys.size());
	}
	std::sort(keys.begin(), keys.end());
	std::vector<Task> tasks;
	order.clear();
	for (const auto& [across, a, b, pair] : keys) {
		const int begin = static_cast<int>(order.size());
		const bool isNew = tasks.empty() || tasks.back().across != across ||
				   tasks.back().first != a || tasks.back().second != b;
		if (isNew) tasks.push_back({ across, a, b, begin, begin });
		++tasks.back().end;
		order.push_back(pair);
	}
	return tasks;
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

} // namespace

SweepPlan planSweeps(const std::vector<BodiesOfPair>& pairs, int bodies)
{
	const std::vector<int> cluster = clustersOf(Graph(pairs, bodies), bodies);
	std::vector<int> order;
	const auto tasks = tasksOf(pairs, cluster, order);
	SweepPlan plan;
	plan.pairs.reserve(pairs.size());
	long work = 0;
	for (auto& colour : coloursOf(tasks, bodies)) {
		std::stable_sort(colour.begin(), colour.end(), [](const Task* a, const Task* b) {
			return std::tie(a->first, a->second) < std::tie(b->first, b->second);
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
