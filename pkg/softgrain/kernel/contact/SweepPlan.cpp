#include "contact/SweepPlan.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
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
	template <int dim>
	Graph(const std::vector<ContactList<dim>*>& lists, int grains, int bodies)
		: begin_(bodies + 1, 0)
	{
		forEachEdge(lists, grains, [this](int a, int b) {
			++begin_[a + 1];
			++begin_[b + 1];
		});
		std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
		std::vector<int> next(begin_.begin(), begin_.end() - 1);
		neighbour_.resize(begin_.back());
		forEachEdge(lists, grains, [&](int a, int b) {
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
	template <int dim, class Visit>
	static void forEachEdge(const std::vector<ContactList<dim>*>& lists, int grains,
				Visit&& visit)
	{
		for (const ContactList<dim>* list : lists)
			if (const int second = list->sharedSecond(grains); second >= 0)
				visit(list->first, second);
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
template <int dim> struct Task {
	int first, second; ///< clusters
	std::vector<ContactList<dim>*> pairs;
};

/// Tasks within clusters first, in the order of the clusters; pairs in the given order.
template <int dim>
std::vector<Task<dim>> tasksOf(const std::vector<ContactList<dim>*>& lists,
			       const std::vector<int>& cluster, int grains)
{
	using Key = std::tuple<bool, int, int>; // across, clusters
	std::map<Key, std::vector<ContactList<dim>*>> byClusters;
	for (ContactList<dim>* list : lists) {
		const int second = list->sharedSecond(grains);
		const int a = cluster[list->first], b = second >= 0 ? cluster[second] : a;
		byClusters[{ a != b, std::min(a, b), std::max(a, b) }].push_back(list);
	}
	std::vector<Task<dim>> tasks;
	for (auto& [key, pairs] : byClusters)
		tasks.push_back({ std::get<1>(key), std::get<2>(key), std::move(pairs) });
	return tasks;
}

/// Puts each task into the first colour none of whose tasks shares a cluster with it.
template <int dim>
std::vector<std::vector<const Task<dim>*>> coloursOf(const std::vector<Task<dim>>& tasks,
						     int clusters)
{
	std::vector<std::uint64_t> taken(clusters, 0); // colours of the tasks of a cluster
	std::vector<std::vector<const Task<dim>*>> colours, beyond;
	for (const Task<dim>& task : tasks) {
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

template <int dim>
SweepPlan<dim> planSweeps(const std::vector<ContactList<dim>*>& lists, int bodies, int partners)
{
	const int all = bodies + partners;
	const std::vector<int> cluster = clustersOf(Graph(lists, bodies, all), all);
	const auto tasks = tasksOf<dim>(lists, cluster, bodies);
	SweepPlan<dim> plan;
	for (const auto& colour : coloursOf<dim>(tasks, all)) {
		for (const Task<dim>* task : colour) {
			plan.pairs.insert(plan.pairs.end(), task->pairs.begin(), task->pairs.end());
			plan.taskEnd.push_back(static_cast<int>(plan.pairs.size()));
		}
		plan.colourEnd.push_back(plan.tasks());
	}
	return plan;
}

template SweepPlan<2> planSweeps(const std::vector<ContactList<2>*>&, int, int);
template SweepPlan<3> planSweeps(const std::vector<ContactList<3>*>&, int, int);

} // namespace softgrain
