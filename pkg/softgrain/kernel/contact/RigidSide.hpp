// What is not a grain in a pair: a plane or another rigid body.
#pragma once

#include "Vector.hpp"
#include "Vectors.hpp"
#include "contact/RigidSurface.hpp"

#include <functional>
#include <vector>

namespace softgrain {

/// Rigid plane with prescribed motion; the grain is on the side of the normal.
template <int dim> struct Plane {
	Vec<dim> point = Vec<dim>::Zero();
	Vec<dim> normal = Vec<dim>::Zero();
	Vec<dim> velocity = Vec<dim>::Zero(); ///< m/s
};

/// A surface beside a rigid one.
template <int dim> struct SurfaceBeside {
	RigidSurface<dim> surface;
	bool comesFirst = false; ///< a place on the seam of both touches this one only
};

/// A rigid body in place of the second grain. Contacts of side 1 are those of its own ends
/// (tipsOf); edges that cross are its own and the grain's.
template <int dim> struct RigidSide {
	RigidSurface<dim> surface;
	Vec<dim> pivot = Vec<dim>::Zero(); ///< moments of the impulses are about it, m
	VectorRange<dim> velocities;       ///< of the places of the surface, m/s
	int partner = -1;                  ///< its motion: number in the step at hand
	/// RigidPartner::moves and hasVelocity, known from the begin of a step until the next
	/// search.
	bool moves = false, hasVelocity = false;
	/// Other surfaces about the grain, during a search: asked for where it meets an edge. May
	/// be empty.
	std::function<std::vector<SurfaceBeside<dim>>()> others;
};

} // namespace softgrain
