#include "contact/OutlineCurve.hpp"

#include <algorithm>

namespace softgrain {

namespace {

/// Newton's method from the place on the chord; each step gains a factor of gap times curvature.
constexpr int newtonSteps = 2;

} // namespace

OutlineCurve::OutlineCurve(const ContactBody<2>& body, int facet)
	: body_(body)
{
	node_ = body.mesh->carriers(facet);
	startsSharp_ = body.isSharp(node_[1]);
	endsSharp_ = body.isSharp(node_[2]);
}

/// x_0 = 2 x_1 - x_2 at a sharp first node, x_3 = 2 x_2 - x_1 at a sharp second one.
std::array<double, 4> OutlineCurve::withoutBeyond(std::array<double, 4> weight) const
{
	auto [w0, w1, w2, w3] = weight;
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

OutlineCurve::Place OutlineCurve::at(double t) const
{
	const double tt = t * t, ttt = tt * t;
	Place place;
	place.weight = withoutBeyond({ 0.5 * (-t + 2 * tt - ttt), 0.5 * (2 - 5 * tt + 3 * ttt),
				       0.5 * (t + 4 * tt - 3 * ttt), 0.5 * (ttt - tt) });
	const auto slope = withoutBeyond({ 0.5 * (-1 + 4 * t - 3 * tt), 0.5 * (-10 * t + 9 * tt),
					   0.5 * (1 + 8 * t - 9 * tt), 0.5 * (3 * tt - 2 * t) });
	for (int k = 0; k < 4; ++k) {
		place.position += place.weight[k] * body_.position[node_[k]];
		place.tangent += slope[k] * body_.position[node_[k]];
	}
	return place;
}

OutlineCurve::Place OutlineCurve::nearest(const Vec<2>& x, double t) const
{
	Place place = at(t);
	for (int step = 0; step < newtonSteps; ++step) {
		const double ahead = (x - place.position).dot(place.tangent);
		t = std::clamp(t + ahead / place.tangent.squaredNorm(), 0., 1.);
		place = at(t);
	}
	return place;
}

} // namespace softgrain
