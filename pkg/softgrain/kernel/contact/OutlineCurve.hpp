// The outline of a 2D body between its surface nodes: a smooth curve that moves with the nodes.
#pragma once

#include "contact/ContactBody.hpp"

#include <array>

namespace softgrain {

/// The piece over one facet, from t = 0 at its first node to t = 1 at its second: with the facet's
/// nodes x_1, x_2 and their neighbours x_0, x_3
///
///     y(t) = sum_k w_k(t) x_k,      2 w_0 = -t + 2 t^2 - t^3,       2 w_1 = 2 - 5 t^2 + 3 t^3,
///                                   2 w_3 = -t^2 + t^3,             2 w_2 = t + 4 t^2 - 3 t^3,
///
/// the cubic with tangents (x_2 - x_0)/2 and (x_3 - x_1)/2 at its ends (Catmull and Rom, 1974). At
/// a sharp node the outline ends: the neighbour beyond it is the mirror image of the one before,
/// which leaves a straight side straight. The weights sum to 1, and a place at rest on the curve
/// moves with sum_k w_k v_k.
class OutlineCurve {
public:
	OutlineCurve(const ContactBody<2>& body, int facet);

	struct Place {
		double t;
		Vec<2> position; ///< y, m
		Vec<2> tangent;  ///< dy/dt, m
	};
	Place at(double t) const;
	/// The place of this piece nearest to `x`, sought from `t`, that of the nearest on the
	/// facet.
	Place nearest(const Vec<2>& x, double t) const;
	/// The same for an `x` however far outside, by bisection.
	Place nearestToFar(const Vec<2>& x) const;
	/// Shares w_k(t) of its nodes.
	std::array<double, 4> weights(double t) const;
	const std::array<int, 4>& nodes() const { return node_; }
	/// The curve is nowhere further from its facet, m.
	double bulge() const;

private:
	std::array<int, 4> node_;
	bool startsSharp_, endsSharp_;
	Vec<2> start_;                      ///< x_1
	Vec<2> before_, edge_, next_;       ///< x_1 - x_0, x_2 - x_1, x_3 - x_2
	Vec<2> linear_, quadratic_, cubic_; ///< y = x_1 + linear t + quadratic t^2 + cubic t^3
};

} // namespace softgrain
