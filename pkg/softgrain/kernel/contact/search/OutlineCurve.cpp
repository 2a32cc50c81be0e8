#include "contact/search/OutlineCurve.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

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

/// y - x_1 - t (x_2 - x_1) = -t (1 - t) (quadratic + cubic + t cubic).
double OutlineCurve::bulge() const
{
	return 0.25 * std::sqrt(std::max((quadratic_ + cubic_).squaredNorm(),
					 (quadratic_ + 2 * cubic_).squaredNorm()));
}

} // namespace softgrain
