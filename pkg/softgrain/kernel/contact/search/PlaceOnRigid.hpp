// Where a point of the outline of a grain touches the surface of a rigid body.
#pragma once

#include "contact/RigidSurface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>

namespace softgrain {

/// Where a place of a grain touches a rigid surface.
template <int dim> struct SurfacePlace {
	Vec<dim> normal; ///< unit, out of the rigid body
	double gap;      ///< m, negative for an overlap
	/// From the place to the nearest edge of its side, m: 0 on an edge or a corner; on the
	/// sides of plates and on balls infinite, wherever it is.
	double toEdge;
	bool isNearEnd = false; ///< so near to an edge of a plate that it may lie on a seam
	/// Whether the grain lies on the other side of a plate or a block: the place has come
	/// through it, or it is one of the side that the grain turns away.
	bool isBehind = false;
	double beside = 0; ///< how far it lies beyond the end of its side, m
	/// On a side of a block: directions (unit) across the edges next to it, towards the
	/// middle, and how far those edges are the other way, m; negative beyond them.
	struct Edge {
		Vec<dim> inwards = Vec<dim>::Zero();
		double away = 0;
	};
	bool isOnBlock = false;
	std::array<Edge, dim - 1> edges {};
};

/// Cosine of the angle by which an outline faces against a direction (unit): 1 where head-on.
template <int dim> using Facing = std::function<double(const Vec<dim>&)>;

/// Whether another surface goes on from an edge: from a place of it, within 30 degrees of a
/// direction (unit).
template <int dim> using GoesOn = std::function<bool(const Vec<dim>&, const Vec<dim>&)>;

/// Whether any of the directions is in which a surface may go on from the edge of a side: `over` it
/// (unit), inclined, or rising. is(direction, normal): of that surface, both unit.
template <int dim, class Is> bool anyRise(const Vec<dim>& over, const Vec<dim>& sideNormal, Is&& is)
{
	constexpr double rises[] { 0, M_PI / 4, M_PI / 2, 3 * M_PI / 4 };
	return std::any_of(std::begin(rises), std::end(rises), [&](double rise) {
		const double along = std::cos(rise), up = std::sin(rise);
		const Vec<dim> direction = along * over + up * sideNormal;
		const Vec<dim> normal = along * sideNormal - up * over;
		return is(direction, normal);
	});
}

/// The place of the surface that a point `x` of an outline touches. `facing` is asked of the
/// outline there: it tells the two sides of a plate apart, and the sides of a block about an edge;
/// a point that faces none of them touches nothing. What a point slides past, as the edge of the
/// next plate of a floor, it does not face closely enough. `goesOn` is asked of edges that may poke
/// into it, and of those that it has sunk beside; what rises from one it may have sunk into by
/// `sunk`, m.
template <int dim>
std::optional<SurfacePlace<dim>> placeOn(
	const RigidSurface<dim>& surface, const Vec<dim>& x, const Facing<dim>& facing,
	const GoesOn<dim>& goesOn = [](const auto&, const auto&) { return false; },
	double sunk = 0);

/// The same, and where `take` does not take it the place on the next side that the point faces, if
/// the sides meet at an edge as those of a block, or are those of a plate. take(place, from): the
/// point where it is looked from, no longer beyond the sides that were not taken.
template <int dim, class Take>
void tryPlaces(const RigidSurface<dim>& surface, const Vec<dim>& x, const Facing<dim>& facing,
	       const GoesOn<dim>& goesOn, double sunk, Take&& take)
{
	std::array<Vec<dim>, dim> passed; // their normals
	Vec<dim> from = x;
	int sides = 0;
	const Facing<dim> facingAnother = [&](const Vec<dim>& n) {
		// the same side: those of a block are at right angles
		constexpr double alike = 0.99;
		const bool hasPassed =
			std::any_of(passed.begin(), passed.begin() + sides,
				    [&](const Vec<dim>& side) { return n.dot(side) >= alike; });
		return hasPassed ? -1 : facing(n);
	};
	for (; sides < dim; ++sides) {
		auto place = placeOn<dim>(surface, from, facingAnother, goesOn, sunk);
		if (!place) return;
		place->beside += (x - from).norm();
		if (take(*place, from)) return;
		const bool meetsAnother = place->isOnBlock || place->isBehind;
		if (!meetsAnother) return;
		passed[sides] = place->normal;
		from -= std::max(place->gap, 0.) * place->normal;
	}
}

} // namespace softgrain
