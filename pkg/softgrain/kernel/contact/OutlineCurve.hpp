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
		std::array<double, 4> weight;
		Vec<2> position = Vec<2>::Zero(); ///< y, m
		Vec<2> tangent = Vec<2>::Zero();  ///< dy/dt, m
	};
	Place at(double t) const;
	/// The place of this piece nearest to `x`, sought from `t`, that of the nearest on the
	/// facet.
	Place nearest(const Vec<2>& x, double t) const;
	/// Those of the weights.
	const std::array<int, 4>& nodes() const { return node_; }

private:
	/// Weights without the nodes beyond sharp ones.
	std::array<double, 4> withoutBeyond(std::array<double, 4> weight) const;

	const ContactBody<2>& body_;
	std::array<int, 4> node_;
	bool startsSharp_, endsSharp_;
};

} // namespace softgrain
