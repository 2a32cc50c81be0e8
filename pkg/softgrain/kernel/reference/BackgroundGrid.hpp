// The background grid of one grain: which nodes carry unknowns, and the shape functions on them.
#pragma once

#include "Vector.hpp"
#include "reference/Quadrature.hpp"
#include "reference/ShapeFunction.hpp"
#include "reference/SparseRows.hpp"

#include <array>
#include <map>
#include <optional>
#include <vector>

namespace softgrain {

/// Nodes lighter than this share of the heaviest one are *tied*: they follow the heavier nodes
/// near them by an extrapolation exact for affine motions, and their shape functions are added to
/// those of these nodes. See doc/decisions/0001-rim.md for how it was chosen.
constexpr double lightNodeShare = 2e-3;

/// Tensor-product B-splines on a regular grid with a node at the origin, restricted to the nodes
/// that carry unknowns.
template <int dim> class BackgroundGrid {
public:
	/// Grid of steps `spacing` along the axes whose nodes are those that the material points
	/// give mass to.
	BackgroundGrid(int order, const Vec<dim>& spacing, const Quadrature<dim>& quadrature,
		       double tiedShare = lightNodeShare);

	using Index = std::array<int, dim>;
	using Weights = std::vector<std::pair<int, double>>;

	int order() const { return order_; }
	const Vec<dim>& spacing() const { return spacing_; }
	/// The nodes that carry unknowns, by their place in the grid.
	const std::map<Index, int>& number() const { return number_; }
	const std::vector<Vec<dim>>& position() const { return position_; }
	const std::vector<double>& mass() const { return mass_; }

	/// Adds the row of shape functions at X, tied nodes resolved.
	void appendShapes(const Vec<dim>& X, SparseRows<ShapeFunction<dim>>& rows) const;
	/// The shape functions at X of all nodes, also of those that are tied; their places ascend.
	std::vector<std::pair<Index, ShapeFunction<dim>>> shapesWithTied(const Vec<dim>& X) const;
	/// The nodes that a tied node follows.
	Weights extrapolation(const Index& index) const;

private:
	Vec<dim> nodeAt(const Index& index) const;
	/// Squared distance in grid steps, and number: of nodes that carry unknowns, the nearest
	/// first.
	using NodesAbout = std::vector<std::pair<int, int>>;
	NodesAbout nodesWithin(int steps, const Index& index) const;
	/// So many, and all that are as near as the last of them.
	NodesAbout nearestNodes(const Index& index, std::size_t count) const;
	/// Minimum-norm weights on nodes that reproduce affine functions at a tied node; none where
	/// the nodes lie in a row (plane).
	std::optional<Weights> affineWeights(const Index& index, const NodesAbout& nodes) const;

	int order_;
	Vec<dim> spacing_;
	std::map<Index, int> number_;           ///< of the nodes that carry unknowns
	mutable std::map<Index, Weights> tied_; ///< extrapolations met so far
	std::vector<Vec<dim>> position_;
	std::vector<double> mass_;
};

} // namespace softgrain
