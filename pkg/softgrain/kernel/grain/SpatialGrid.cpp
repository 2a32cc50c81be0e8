#include "grain/SpatialGrid.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace softgrain {

namespace {

/// Steps to the nodes around a node, nearest first.
template <int dim> struct Neighbourhood {
	struct Step {
		int squared; ///< distance in grid steps, squared
		std::array<int, dim> by;
	};
	std::vector<Step> step;

	Neighbourhood()
	{
		constexpr int reach = 4, side = 2 * reach + 1;
		int count = 1;
		for (int a = 0; a < dim; ++a)
			count *= side;
		for (int k = 0; k < count; ++k) {
			Step s {};
			for (int a = 0, rest = k; a < dim; ++a, rest /= side) {
				s.by[a] = rest % side - reach;
				s.squared += s.by[a] * s.by[a];
			}
			if (s.squared > 0) step.push_back(s);
		}
		std::stable_sort(step.begin(), step.end(), [](const Step& a, const Step& b) {
			return a.squared < b.squared;
		});
	}
};

} // namespace

template <int dim> void SpatialGrid<dim>::lay(const Index& low, const Index& high)
{
	low_ = low;
	int count = 1;
	for (int a = dim - 1; a >= 0; --a) {
		size_[a] = high[a] - low[a] + 1;
		stride_[a] = count;
		count *= size_[a];
	}
	mass.assign(count, 0.);
	wanted.assign(count, 0);
	for (GridField<dim>* field : { &velocity, &force, &velocityNext })
		for (std::vector<double>& component : *field)
			component.assign(count, 0.);
}

template <int dim> std::vector<typename SpatialGrid<dim>::Index> SpatialGrid<dim>::indices() const
{
	std::vector<Index> all(nodes(), low_);
	for (int I = 1; I < nodes(); ++I) {
		all[I] = all[I - 1];
		for (int a = dim - 1; ++all[I][a] == low_[a] + size_[a]; --a)
			all[I][a] = low_[a];
	}
	return all;
}

template <int dim> void SpatialGrid<dim>::tieLightNodes(double share)
{
	const double lightest = share * *std::max_element(mass.begin(), mass.end());
	carries_.assign(nodes(), 0);
	tieNumber_.assign(nodes(), -1);
	carrying_.clear();
	ties_.clear();
	tiedTo_.clear();
	for (int I = 0; I < nodes(); ++I)
		if (mass[I] > 0 && mass[I] >= lightest) {
			carries_[I] = 1;
			carrying_.push_back(I);
		}
	for (int I = 0; I < nodes(); ++I)
		if (!carries_[I] && (mass[I] > 0 || wanted[I])) appendTie(I);
	for (const Tie& tie : ties_) {
		for (int k = tie.begin; k < tie.end; ++k) {
			const auto& [I, weight] = tiedTo_[k];
			mass[I] += weight * mass[tie.node];
			for (int a = 0; a < dim; ++a) {
				velocity[a][I] += weight * velocity[a][tie.node];
				force[a][I] += weight * force[a][tie.node];
			}
		}
		mass[tie.node] = 0;
	}
}

/// Minimum-norm weights on the nearest carrying nodes that reproduce affine functions; trust falls
/// with distance^-4. All nodes as far away as the last one count.
template <int dim> void SpatialGrid<dim>::appendTie(int node)
{
	static const Neighbourhood<dim> around;
	constexpr int neighbours = dim == 2 ? 6 : 11;
	using Affine = Eigen::Matrix<double, dim + 1, 1>;

	const Index centre = indexOf(node);
	const int begin = static_cast<int>(tiedTo_.size());
	Eigen::Matrix<double, dim + 1, dim + 1> normal;
	normal.setZero();
	arms_.clear();
	int last = 0;
	for (const auto& step : around.step) {
		if (static_cast<int>(arms_.size()) >= neighbours && step.squared > last) break;
		Index index;
		bool inside = true;
		for (int a = 0; a < dim; ++a) {
			index[a] = centre[a] + step.by[a];
			inside = inside && index[a] >= low_[a] && index[a] < low_[a] + size_[a];
		}
		if (!inside || !carries_[at(index)]) continue;
		Affine arm;
		arm[0] = 1;
		for (int a = 0; a < dim; ++a)
			arm[1 + a] = step.by[a];
		const double trust = 1. / (static_cast<double>(step.squared) * step.squared);
		normal += trust * arm * arm.transpose();
		arms_.push_back(arm);
		tiedTo_.push_back({ at(index), trust });
		last = step.squared;
	}
	const Affine solved = normal.inverse().col(0);
	for (std::size_t k = 0; k < arms_.size(); ++k)
		tiedTo_[begin + k].weight *= arms_[k].dot(solved);
	tieNumber_[node] = static_cast<int>(ties_.size());
	ties_.push_back({ node, begin, static_cast<int>(tiedTo_.size()) });
}

template <int dim> void SpatialGrid<dim>::followTies(GridField<dim>& field) const
{
	for (const Tie& tie : ties_)
		for (int a = 0; a < dim; ++a) {
			double sum = 0;
			for (int k = tie.begin; k < tie.end; ++k)
				sum += tiedTo_[k].weight * field[a][tiedTo_[k].node];
			field[a][tie.node] = sum;
		}
}

template class SpatialGrid<2>;
template class SpatialGrid<3>;

} // namespace softgrain
