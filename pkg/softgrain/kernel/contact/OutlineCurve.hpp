// The outline of a 2D body between its surface nodes: a smooth curve that moves with the nodes.
#pragma once

#include "contact/ContactBody.hpp"

#include <algorithm>
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
	/// Newton's method from the place on the chord; each step gains a factor of gap times
	/// curvature.
	static constexpr int newtonSteps = 2;

	std::array<int, 4> node_;
	bool startsSharp_, endsSharp_;
	Vec<2> start_;                      ///< x_1
	Vec<2> before_, edge_, next_;       ///< x_1 - x_0, x_2 - x_1, x_3 - x_2
	Vec<2> linear_, quadratic_, cubic_; ///< y = x_1 + linear t + quadratic t^2 + cubic t^3
};

// --- inline, since the search consists of it
// ------------------------------------------------------

inline OutlineCurve::OutlineCurve(const ContactBody<2>& body, int facet)
	: node_(body.mesh->carriers(facet))
	, startsSharp_(body.isSharp(node_[1]))
	, endsSharp_(body.isSharp(node_[2]))
	, start_(body.position[node_[1]])
	, edge_(body.position[node_[2]] - start_)
{
	before_ = startsSharp_ ? edge_ : Vec<2>(start_ - body.position[node_[0]]);
	next_ = endsSharp_ ? edge_ : Vec<2>(body.position[node_[3]] - body.position[node_[2]]);
	linear_ = 0.5 * (before_ + edge_);
	quadratic_ = 1.5 * edge_ - before_ - 0.5 * next_;
	cubic_ = 0.5 * (before_ + next_) - edge_;
}

/// x_0 = 2 x_1 - x_2 at a sharp first node, x_3 = 2 x_2 - x_1 at a sharp second one.
inline std::array<double, 4> OutlineCurve::weights(double t) const
{
	const double tt = t * t, ttt = tt * t;
	double w0 = 0.5 * (-t + 2 * tt - ttt), w1 = 0.5 * (2 - 5 * tt + 3 * ttt),
	       w2 = 0.5 * (t + 4 * tt - 3 * ttt), w3 = 0.5 * (ttt - tt);
	if (startsSharp_) {
		w1 += 2 * w0;
		w2 -= w0;
		w0 = 0;
	}
	if (endsSharp_) {
		w2 += 2 * w3;
		w1 -= w3;
		w3 = 0;
	}
	return { w0, w1, w2, w3 };
}

inline OutlineCurve::Place OutlineCurve::at(double t) const
{
	return { t, start_ + t * (linear_ + t * (quadratic_ + t * cubic_)),
		 linear_ + t * (2 * quadratic_ + 3 * t * cubic_) };
}

inline OutlineCurve::Place OutlineCurve::nearest(const Vec<2>& x, double t) const
{
	Place place = at(t);
	for (int step = 0; step < newtonSteps; ++step) {
		const double ahead = (x - place.position).dot(place.tangent);
		place = at(std::clamp(t + ahead / place.tangent.squaredNorm(), 0., 1.));
		t = place.t;
	}
	return place;
}

} // namespace softgrain
