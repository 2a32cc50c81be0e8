// The outline of a 2D body between its surface nodes: a smooth curve that moves with the nodes.
#pragma once

#include "contact/ContactOutline.hpp"
#include "lanes/VectorLanes.hpp"

#include <algorithm>
#include <array>

namespace softgrain {

/// What a curve asks of vectors and numbers, as VectorLanes.hpp has it for lanes of them.
inline Vec<2> toTheRight(const Vec<2>& v) { return { v[1], -v[0] }; }
inline double withinUnit(double t) { return std::clamp(t, 0., 1.); }

/// The nodes of a curve: x_1 and the ways x_1 - x_0, x_2 - x_1, x_3 - x_2.
template <class Vector> struct NodeWays {
	Vector start, before, edge, next;
};

/// The curve from a node x_1 at t = 0 to the next, x_2, at t = 1; with the nodes x_0, x_3 beside
/// them
///
///     y(t) = sum_k w_k(t) x_k,      2 w_0 = -t + 2 t^2 - t^3,       2 w_1 = 2 - 5 t^2 + 3 t^3,
///                                   2 w_3 = -t^2 + t^3,             2 w_2 = t + 4 t^2 - 3 t^3,
///
/// the cubic with tangents (x_2 - x_0)/2 and (x_3 - x_1)/2 at its ends (Catmull and Rom, 1974). The
/// weights sum to 1, and a place at rest on the curve moves with sum_k w_k v_k. Vector is Vec<2>,
/// or VectorLanes for several curves at a time.
template <class Vector> class CurvePiece {
public:
	using Number = typename Vector::Scalar;

	explicit CurvePiece(const NodeWays<Vector>& nodes)
		: start_(nodes.start)
		, linear_(0.5 * (nodes.before + nodes.edge))
		, quadratic_(1.5 * nodes.edge - nodes.before - 0.5 * nodes.next)
		, cubic_(0.5 * (nodes.before + nodes.next) - nodes.edge)
	{
	}

	struct Place {
		Number t;
		Vector position;                                                   ///< y, m
		Vector tangent;                                                    ///< dy/dt, m
		Vector normal() const { return toTheRight(tangent).normalized(); } ///< outward
	};
	Place at(const Number& t) const
	{
		return { t, start_ + t * (linear_ + t * (quadratic_ + t * cubic_)),
			 linear_ + t * (2. * quadratic_ + 3. * t * cubic_) };
	}
	/// The place nearest to `x`, sought from `t`, that of the nearest on the facet.
	Place nearest(const Vector& x, const Number& t) const
	{
		Place place = at(t);
		for (int step = 0; step < newtonSteps; ++step) {
			const Number ahead = (x - place.position).dot(place.tangent);
			place = at(withinUnit(place.t + ahead / place.tangent.squaredNorm()));
		}
		return place;
	}
	/// Shares w_k(t) of the nodes.
	static void weights(const Number& t, Number (&w)[4])
	{
		const Number tt = t * t, ttt = tt * t;
		w[0] = 0.5 * (-t + 2. * tt - ttt);
		w[1] = 0.5 * (2. - 5. * tt + 3. * ttt);
		w[2] = 0.5 * (t + 4. * tt - 3. * ttt);
		w[3] = 0.5 * (ttt - tt);
	}

protected:
	/// Newton's method from the place on the chord; each step gains a factor of gap times
	/// curvature.
	static constexpr int newtonSteps = 2;

	/// y = x_1 + linear t + quadratic t^2 + cubic t^3
	Vector start_, linear_, quadratic_, cubic_;
};

/// Nodes of the curve over a facet of a body. At a sharp node the outline ends: the neighbour
/// beyond it is the mirror image of the one before, which leaves a straight side straight.
NodeWays<Vec<2>> nodesOver(const ContactOutline<2>& body, int facet);
/// What the nodes themselves have of the weights w_k, given which of x_1 and x_2 are sharp.
std::array<double, 4> sharesOfNodes(const std::array<double, 4>& weight, bool startsSharp,
				    bool endsSharp);

/// The piece over a facet of a body.
class OutlineCurve : public CurvePiece<Vec<2>> {
public:
	OutlineCurve(const ContactOutline<2>& body, int facet);

	/// As `nearest` for an `x` however far outside, by bisection.
	Place nearestToFar(const Vec<2>& x) const;
	/// Shares of its nodes.
	std::array<double, 4> weights(double t) const;
	const std::array<int, 4>& nodes() const { return node_; }
	/// The curve is nowhere further from its facet, m.
	double bulge() const;

private:
	std::array<int, 4> node_;
	bool startsSharp_, endsSharp_;
};

// --- inline, since the search consists of it ------------------------------

inline NodeWays<Vec<2>> nodesOver(const ContactOutline<2>& body, int facet)
{
	const std::array<int, 4>& node = body.mesh->carriers(facet);
	auto way = [&](int k) -> Vec<2> {
		return body.position[node[k + 1]] - body.position[node[k]];
	};
	const Vec<2> edge = way(1);
	return { body.position[node[1]], body.isSharp(node[1]) ? edge : way(0), edge,
		 body.isSharp(node[2]) ? edge : way(2) };
}

/// x_0 = 2 x_1 - x_2 at a sharp first node, x_3 = 2 x_2 - x_1 at a sharp second one.
inline std::array<double, 4> sharesOfNodes(const std::array<double, 4>& weight, bool startsSharp,
					   bool endsSharp)
{
	std::array<double, 4> w = weight;
	if (startsSharp) {
		w[1] += 2 * w[0];
		w[2] -= w[0];
		w[0] = 0;
	}
	if (endsSharp) {
		w[2] += 2 * w[3];
		w[1] -= w[3];
		w[3] = 0;
	}
	return w;
}

inline OutlineCurve::OutlineCurve(const ContactOutline<2>& body, int facet)
	: CurvePiece(nodesOver(body, facet))
	, node_(body.mesh->carriers(facet))
	, startsSharp_(body.isSharp(node_[1]))
	, endsSharp_(body.isSharp(node_[2]))
{
}

inline std::array<double, 4> OutlineCurve::weights(double t) const
{
	double w[4];
	CurvePiece::weights(t, w);
	return sharesOfNodes(std::to_array(w), startsSharp_, endsSharp_);
}

} // namespace softgrain
