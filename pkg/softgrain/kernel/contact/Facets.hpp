// The flat pieces that outlines are made of.
#pragma once

#include "Vector.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace softgrain {

/// Barycentric coordinates of the point of a segment nearest to `x`.
inline std::array<double, 2> nearestOnFacet(const Vec<2>& x, const std::array<Vec<2>, 2>& corner)
{
	const Vec<2> edge = corner[1] - corner[0];
	const double t = std::clamp((x - corner[0]).dot(edge) / edge.squaredNorm(), 0., 1.);
	return { 1 - t, t };
}

/// The same for a triangle, by the regions of its corners, edges and inside (Ericson, Real-Time
/// Collision Detection, 2005, 5.1.5).
inline std::array<double, 3> nearestOnFacet(const Vec<3>& x, const std::array<Vec<3>, 3>& corner)
{
	const Vec<3> ab = corner[1] - corner[0], ac = corner[2] - corner[0];
	const Vec<3> ax = x - corner[0], bx = x - corner[1], cx = x - corner[2];
	const double d1 = ab.dot(ax), d2 = ac.dot(ax), d3 = ab.dot(bx), d4 = ac.dot(bx),
		     d5 = ab.dot(cx), d6 = ac.dot(cx);
	if (d1 <= 0 && d2 <= 0) return { 1, 0, 0 };
	if (d3 >= 0 && d4 <= d3) return { 0, 1, 0 };
	if (d6 >= 0 && d5 <= d6) return { 0, 0, 1 };
	const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return { 1 - d1 / (d1 - d3), d1 / (d1 - d3), 0 };
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return { 1 - d2 / (d2 - d6), 0, d2 / (d2 - d6) };
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
		const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
		return { 0, 1 - w, w };
	}
	const double sum = va + vb + vc;
	return { va / sum, vb / sum, vc / sum };
}

} // namespace softgrain
