// What a rigid surface ends in: corners and edges that enter the outline of a grain between its
// contact nodes.
#pragma once

#include "Vectors.hpp"
#include "contact/RigidSurface.hpp"
#include "contact/search/EdgeCrossing.hpp"

#include <optional>
#include <vector>

namespace softgrain {

/// A ball (of radius 0: a point) that the surface ends in; between contact nodes it may enter the
/// outline of a grain.
template <int dim> struct Tip {
	BallSurface<dim> ball;
	int number; ///< its own among the tips of the surface, whatever the box
};

/// Of the side that ends at a tip, or another place on an edge, and that an outline with this
/// normal (unit, outwards) lies along there, within an angle (rad): its normal (unit), towards the
/// outline. A side of a block that is narrower than the spacing of the contact nodes is none.
template <int dim>
std::optional<Vec<dim>> sideAlong(const RigidSurface<dim>& surface, const Vec<dim>& place,
				  const Vec<dim>& normal, double angle, double spacing);

/// The ball itself; corners and, in 3D, points of the edges no further apart than `spacing`, of
/// these the ones in `box`.
template <int dim>
std::vector<Tip<dim>> tipsOf(const RigidSurface<dim>& surface, const Box<dim>& box, double spacing);

/// Its edges, none of a ball. The side of a block that is narrower than the spacing of the contact
/// nodes is left out beside the other one: no node need hold what lies along it.
std::vector<ConvexEdge> edgesOf(const RigidSurface<3>& surface, double spacing);

} // namespace softgrain
