#include "contact/OutlineCurve.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Newton's method from the place on the chord; each step gains a factor of gap times curvature.
constexpr int newtonSteps = 2;

} // namespace

OutlineCurve::OutlineCurve(const ContactBody<2>& body, int facet)
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
std::array<double, 4> OutlineCurve::weights(double t) const
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

OutlineCurve::Place OutlineCurve::at(double t) const
{
	return { t, start_ + t * (linear_ + t * (quadratic_ + t * cubic_)),
		 linear_ + t * (2 * quadratic_ + 3 * t * cubic_) };
}

OutlineCurve::Place OutlineCurve::nearest(const Vec<2>& x, double t) const
{
	Place place = at(t);
	for (int step = 0; step < newtonSteps; ++step) {
		const double ahead = (x - place.position).dot(place.tangent);
		place = at(std::clamp(t + ahead / place.tangent.squaredNorm(), 0., 1.));
		t = place.t;
	}
	return place;
}

/// `nearest` takes no notice of the curvature: its steps shrink only where x is nearer than the
/// centre of curvature on the other side.
OutlineCurve::Place OutlineCurve::nearestToFar(const Vec<2>& x) const
{
	constexpr int halvings = 40; // t to 1e-12: what is left is far below the roundings of x
	auto ahead = [&x](const Place& place) { return (x - place.position).dot(place.tangent); };
	const Place start = at(0), end = at(1);
	if (ahead(start) <= 0) return start;
	if (ahead(end) >= 0) return end;
	double low = 0, high = 1;
	for (int k = 0; k < halvings; ++k) {
		const double middle = 0.5 * (low + high);
		(ahead(at(middle)) > 0 ? low : high) = middle;
	}
	return at(low);
}

/// y - x_1 - t (x_2 - x_1) = t (1 - t) ((1 - t) (before - edge) - t (next - edge)) / 2.
double OutlineCurve::bulge() const
{
	return 0.125 *
	       std::sqrt(std::max((before_ - edge_).squaredNorm(), (next_ - edge_).squaredNorm()));
}

} // namespace softgrain
