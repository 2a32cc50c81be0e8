#include "contact/search/SelfOverlap.hpp"
#include "contact/Facets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace softgrain {

namespace {

/// Outwards from a node, over the spacing of material points: there a grain that has not gone into
/// itself is not.
constexpr double outwards = 1e-3;

/// Half a turn, and what outlines of straight facets leave of it.
constexpr double nearlyBack = 0.9 * std::numbers::pi;

Vec<2> alongFacet(const ContactOutline<2>& body, std::size_t facet)
{
	const auto& [first, second] = body.mesh->facet[facet];
	return body.position[second] - body.position[first];
}

/// Whether some stretch of the outline turns inwards by half a turn on the whole, about: one that
/// closes a pocket does, since its turns and the one where it meets itself, by half a turn at most,
/// are a full one.
bool turnsBack(const ContactOutline<2>& body)
{
	const std::size_t facets = body.mesh->facet.size();
	double inwards = 0; // of the stretch that ends here and turns inwards most
	Vec<2> last = alongFacet(body, facets - 1);
	for (std::size_t f = 0; f < 2 * facets; ++f) { // stretches may pass the first one
		const Vec<2> here = alongFacet(body, f % facets);
		inwards = std::max(0., inwards - std::atan2(cross(last, here), last.dot(here)));
		if (inwards > nearlyBack) return true;
		last = here;
	}
	return false;
}

/// From x, a place inside at a node of this normal, to the nearest facet that faces the node and
/// has x on its inner side; infinity if there is none.
double depthBelowFacing(const ContactOutline<2>& body, const Vec<2>& normal, const Vec<2>& x)
{
	double depth = std::numeric_limits<double>::infinity();
	for (const auto& [first, second] : body.mesh->facet) {
		const Vec<2>&a = body.position[first], &b = body.position[second];
		const Vec<2> facing(b[1] - a[1], a[0] - b[0]); // counter-clockwise: outwards
		if (facing.dot(normal) >= 0 || facing.dot(x - a) >= 0) continue;
		const auto weight = nearestOnFacet(x, { a, b });
		depth = std::min(depth, (weight[0] * a + weight[1] * b - x).norm());
	}
	return depth;
}

} // namespace

double selfOverlap(const ContactOutline<2>& body)
{
	double deepest = 0;
	if (!body.hasFacets() || !turnsBack(body)) return deepest;
	for (int s = 0; s < body.nodes(); ++s) {
		const Vec<2>& normal = body.normal[s];
		const Vec<2> x = body.position[s] + outwards * body.pointSpacing * normal;
		if (!body.encloses(x)) continue;
		const double depth = depthBelowFacing(body, normal, x);
		if (depth < std::numeric_limits<double>::infinity())
			deepest = std::max(deepest, depth);
	}
	return deepest;
}

} // namespace softgrain
