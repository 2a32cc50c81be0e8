// Outlines that are closed polylines: polygons and finely sampled smooth curves. The only ones that
// need not be convex.
#pragma once

#include "reference/Outline.hpp"

namespace softgrain {

class RingOutline : public Outline<2> {
public:
	/// A polygon about its centroid whose largest circle inside has radius 1.
	explicit RingOutline(const Ring& ring);
	/// A smooth convex curve, symmetric about the origin, sampled by the ring.
	RingOutline(const Ring& ring, double volume);

	/// By comparison with all edges; the sign by the number of edges to the right.
	double signedDistance(const Vec<2>& X) const override;
	double volume() const override { return volume_; }
	/// Of the box about the origin that holds the ring, which need not be symmetric.
	Vec<2> halfSides() const override;
	double inradius() const override { return inradius_; }
	Vec<2> cellSides(double spacing) const override { return Vec<2>::Constant(spacing); }
	/// The ring clipped by the four sides of the cell (Sutherland and Hodgman, 1974). Where it
	/// falls into several parts, they are joined by edges there and back, which add nothing.
	std::optional<Moments<2>> cut(const Vec<2>& centre, const Vec<2>& sides) const override;
	/// Vertices at the corners and between them along the ring, nearer to each other (down to
	/// half the spacing) where the ring turns much. Without corners their number has no divisor
	/// 2 or 3, as on a disk.
	OutlineMesh<2> mesh(double spacing) const override;

private:
	Ring ring_;
	double volume_, inradius_;
	bool irregular_;
};

/// |x/a|^n + |y/b|^n = 1, n > 1: an ellipse for n = 2.
RingOutline superdisk(double a, double b, double n);

/// The number next to `count` that has no divisor 2 or 3. Contacts at multiples of 60 or 90
/// degrees then meet the nodes of a round outline at different phases, and the error that each
/// makes by its phase averages out (doc/decisions/0008-node-spacing.md).
int nearestWithoutSmallDivisors(double count);

} // namespace softgrain
