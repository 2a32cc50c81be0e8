// The background grid of an updated-Lagrangian grain: regular, fixed in space relative to the
// grain's origin, and made anew in every step where the grain is.
#pragma once

#include "Vector.hpp"

#include <array>
#include <vector>

namespace softgrain {

/// One vector per node, component by component, so that the nodes of a row lie side by side.
template <int dim> using GridField = std::array<std::vector<double>, dim>;

template <int dim> class SpatialGrid {
public:
	using Index = std::array<int, dim>;

	/// A tied node follows nodes that carry unknowns.
	struct Tie {
		int node;
		int begin, end; ///< of its entries in `tiedTo`
	};
	struct TiedTo {
		int node;
		double weight;
	};

	/// Lays the nodes from `low` to `high` (both included); all masses, momenta and forces are
	/// 0.
	void lay(const Index& low, const Index& high);
	/// Nodes lighter than `share` of the heaviest one are tied if they are `wanted` or have
	/// mass: they follow the nearest heavier nodes by an extrapolation exact for affine motions
	/// (as in reference/BackgroundGrid.hpp), and their mass, momentum and force go to these
	/// with the same weights, which conserves momenta.
	void tieLightNodes(double share);
	/// Adds to `field` at the tied nodes what they take from the others.
	void followTies(GridField<dim>& field) const;

	int nodes() const { return static_cast<int>(mass.size()); }
	int stride(int a) const { return stride_[a]; }
	/// Number of the node with a grid index.
	int at(const Index& index) const
	{
		int node = 0;
		for (int a = 0; a < dim; ++a)
			node += (index[a] - low_[a]) * stride_[a];
		return node;
	}
	Index indexOf(int node) const
	{
		Index index;
		for (int a = 0; a < dim; ++a) {
			index[a] = low_[a] + node / stride_[a];
			node %= stride_[a];
		}
		return index;
	}
	std::vector<Index> indices() const;                            ///< of all nodes
	const std::vector<int>& carrying() const { return carrying_; } ///< in ascending order
	const std::vector<TiedTo>& tiedTo() const { return tiedTo_; }
	/// Tie of a node, null for one that carries its own unknowns.
	const Tie* tieOf(int node) const
	{
		return tieNumber_[node] < 0 ? nullptr : &ties_[tieNumber_[node]];
	}

	std::vector<double> mass;    ///< kg; 0 at tied nodes once these are tied
	GridField<dim> velocity;     ///< momentum while it is gathered; then velocity at t_n - dt/2
	GridField<dim> force;        ///< internal force, N
	GridField<dim> velocityNext; ///< at t_n + dt/2
	std::vector<char> wanted;    ///< whether a contact node sees the node

private:
	void appendTie(int node);

	Index low_ {}, size_ {}, stride_ {};
	std::vector<int> carrying_;
	std::vector<Tie> ties_;
	std::vector<TiedTo> tiedTo_;
	std::vector<int> tieNumber_;
	std::vector<char> carries_;
	std::vector<Eigen::Matrix<double, dim + 1, 1>> arms_; ///< (1, step) of the tie being made
};

} // namespace softgrain
