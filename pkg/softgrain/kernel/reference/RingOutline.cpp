#include "reference/RingOutline.hpp"
#include "Require.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace softgrain {

namespace {

/// Area and first moment of a closed polyline.
Moments<2> momentsOf(const std::vector<Vec<2>>& vertex)
{
	Moments<2> m;
	for (std::size_t k = 0; k < vertex.size(); ++k) {
		const Vec<2>&a = vertex[k], &b = vertex[(k + 1) % vertex.size()];
		const double twice = cross(a, b);
		m.volume += twice / 2;
		m.first += twice / 6 * (a + b);
	}
	return m;
}

bool crosses(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d)
{
	for (int axis = 0; axis < 2; ++axis)
		if (std::max(a[axis], b[axis]) < std::min(c[axis], d[axis]) ||
		    std::max(c[axis], d[axis]) < std::min(a[axis], b[axis]))
			return false;
	return cross(b - a, c - a) * cross(b - a, d - a) <= 0 &&
	       cross(d - c, a - c) * cross(d - c, b - c) <= 0;
}

void requireSimple(const std::vector<Vec<2>>& vertex)
{
	const std::size_t count = vertex.size();
	for (std::size_t i = 0; i < count; ++i)
		for (std::size_t k = i + 2; k < count; ++k) {
			if (i == 0 && k == count - 1) continue;
			if (crosses(vertex[i], vertex[i + 1], vertex[k], vertex[(k + 1) % count]))
				throw std::invalid_argument(
					"vertices: the outline crosses or touches itself, at the "
					"sides after vertices " +
					std::to_string(i) + " and " + std::to_string(k));
		}
}

} // namespace

void Ring::validate() const
{
	if (vertex.size() < 3)
		throw std::invalid_argument("vertices: a polygon has at least three, not " +
					    std::to_string(vertex.size()));
	constexpr double farthest = 1000;
	for (std::size_t k = 0; k < vertex.size(); ++k) {
		const double distance = vertex[k].norm();
		require(distance <= farthest, "vertices (distance from the centroid)", distance,
			"[0, 1000] radii");
		const double side = (vertex[(k + 1) % vertex.size()] - vertex[k]).norm();
		require(side > 1e-9 * farthest, "vertices (length of a side)", side,
			"(1e-6, inf) radii");
	}
	for (std::size_t k = 0; k < corner.size(); ++k)
		require(corner[k] >= 0 && corner[k] < static_cast<int>(vertex.size()) &&
				(k == 0 || corner[k] > corner[k - 1]),
			"corners (index of a vertex)", corner[k],
			"ascending, from 0 to the number of vertices - 1");
	requireSimple(vertex);
	require(area() > 0, "vertices (area)", area(), "(0, inf): counter-clockwise");
	require(centroid().norm() < 1e-6, "vertices (centroid)", centroid().norm(),
		"0: the outline lies about its centroid");
}

bool Ring::operator<(const Ring& o) const
{
	auto before = [](const Vec<2>& a, const Vec<2>& b) {
		return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
	};
	if (corner != o.corner) return corner < o.corner;
	return std::lexicographical_compare(vertex.begin(), vertex.end(), o.vertex.begin(),
					    o.vertex.end(), before);
}

double Ring::area() const { return momentsOf(vertex).volume; }

Vec<2> Ring::centroid() const
{
	const Moments<2> m = momentsOf(vertex);
	return m.first / m.volume;
}

RingOutline::RingOutline(const Ring& ring)
	: ring_(ring)
	, volume_(ring.area())
	, inradius_(1)
	, irregular_(true)
{
}

RingOutline::RingOutline(const Ring& ring, double volume)
	: ring_(ring)
	, volume_(volume)
	, inradius_(-signedDistance(Vec<2>::Zero()))
	, irregular_(false)
{
}

double RingOutline::signedDistance(const Vec<2>& X) const
{
	double squared = std::numeric_limits<double>::infinity();
	bool inside = false;
	for (std::size_t k = 0; k < ring_.vertex.size(); ++k) {
		const Vec<2>&a = ring_.vertex[k], &b = ring_.vertex[(k + 1) % ring_.vertex.size()];
		const Vec<2> edge = b - a;
		const double t = std::clamp((X - a).dot(edge) / edge.squaredNorm(), 0., 1.);
		squared = std::min(squared, (a + t * edge - X).squaredNorm());
		if ((a[1] > X[1]) != (b[1] > X[1]) &&
		    X[0] < a[0] + (X[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
			inside = !inside;
	}
	return inside ? -std::sqrt(squared) : std::sqrt(squared);
}

Vec<2> RingOutline::halfSides() const
{
	Vec<2> half = Vec<2>::Zero();
	for (const Vec<2>& X : ring_.vertex)
		half = half.cwiseMax(X.cwiseAbs());
	return half;
}

std::optional<Moments<2>> RingOutline::cut(const Vec<2>& centre, const Vec<2>& sides) const
{
	std::vector<Vec<2>> part = ring_.vertex, next;
	for (int axis = 0; axis < 2; ++axis)
		for (double sign : { -1., 1. }) {
			const double limit = centre[axis] + sign * 0.5 * sides[axis];
			next.clear();
			for (std::size_t k = 0; k < part.size(); ++k) {
				const Vec<2>&a = part[k], &b = part[(k + 1) % part.size()];
				const double da = sign * (limit - a[axis]),
					     db = sign * (limit - b[axis]);
				if (da >= 0) next.push_back(a);
				if ((da > 0 && db < 0) || (da < 0 && db > 0))
					next.push_back(a + da / (da - db) * (b - a));
			}
			part.swap(next);
		}
	// about the centre of the cell, which saves digits
	for (Vec<2>& X : part)
		X -= centre;
	Moments<2> m = momentsOf(part);
	if (m.volume <= 0) return Moments<2> {};
	m.first += m.volume * centre;
	return m;
}

namespace {

/// A facet turns by no more than this from the next (rad), if that takes no more than twice the
/// vertices.
constexpr double mostTurn = 0.5;
constexpr double leastSpacingShare = 0.5;

/// How much longer a facet may be than its neighbour: lengths differ by this share of the distance.
constexpr double gradation = 0.3;

/// A piece of the ring from corner to corner, or all of it.
struct Section {
	std::vector<Vec<2>> vertex; ///< of a closed one the first is also the last
	std::vector<double> along;  ///< distance from the first, along the ring
	bool closed;
};

Section sectionOf(const Ring& ring, int first, int last)
{
	const int count = static_cast<int>(ring.vertex.size());
	Section section;
	section.closed = ring.corner.empty();
	for (int k = first; k <= last; ++k) {
		const Vec<2>& X = ring.vertex[k % count];
		section.along.push_back(
			k == first ? 0 : section.along.back() + (X - section.vertex.back()).norm());
		section.vertex.push_back(X);
	}
	return section;
}

/// Angle by which the section turns at a vertex; at the ends of an open one not at all.
double turnAt(const Section& s, int k)
{
	const int last = static_cast<int>(s.vertex.size()) - 1;
	if (!s.closed && (k == 0 || k == last)) return 0;
	const Vec<2> in = s.vertex[k] - s.vertex[k > 0 ? k - 1 : last - 1],
		     out = s.vertex[k < last ? k + 1 : 1] - s.vertex[k];
	return std::abs(std::atan2(cross(in, out), in.dot(out)));
}

/// Facet length wanted at each vertex of a section: the turn is counted over half a spacing about
/// it, then lengths are held down where they would grow too fast.
std::vector<double> lengthsWanted(const Section& s, double spacing)
{
	const int last = static_cast<int>(s.vertex.size()) - 1;
	const double window = 0.5 * spacing, total = s.along.back();
	std::vector<double> turn(last + 1), length(last + 1);
	for (int k = 0; k <= last; ++k)
		turn[k] = turnAt(s, k);
	auto distance = [&](int i, int k) {
		const double d = std::abs(s.along[i] - s.along[k]);
		return s.closed ? std::min(d, total - d) : d;
	};
	for (int k = 0; k <= last; ++k) {
		double turned = 0;
		for (int i = s.closed ? 1 : 0; i <= last; ++i)
			if (distance(i, k) <= 0.5 * window) turned += turn[i];
		length[k] = std::clamp(mostTurn * window / std::max(turned, 1e-12),
				       leastSpacingShare * spacing, spacing);
	}
	std::vector<double> graded = length;
	for (int k = 0; k <= last; ++k)
		for (int i = 0; i <= last; ++i)
			graded[k] = std::min(graded[k], length[i] + gradation * distance(i, k));
	return graded;
}

/// Appends vertices on a section, its first one included, its last one not.
void appendVertices(const Section& s, double spacing, std::vector<Vec<2>>& vertex)
{
	const auto length = lengthsWanted(s, spacing);
	std::vector<double> facets { 0 }; // so many from the first vertex on
	for (std::size_t k = 1; k < s.vertex.size(); ++k)
		facets.push_back(facets.back() +
				 2 * (s.along[k] - s.along[k - 1]) / (length[k] + length[k - 1]));
	const int count = s.closed ? nearestWithoutSmallDivisors(std::max(11., facets.back()))
				   : std::max(1, static_cast<int>(std::lround(facets.back())));
	std::size_t k = 0;
	for (int i = 0; i < count; ++i) {
		const double wanted = facets.back() * i / count;
		while (facets[k + 1] <= wanted)
			++k;
		const double share = (wanted - facets[k]) / (facets[k + 1] - facets[k]);
		vertex.push_back(s.vertex[k] + share * (s.vertex[k + 1] - s.vertex[k]));
	}
}

} // namespace

OutlineMesh<2> RingOutline::mesh(double spacing) const
{
	OutlineMesh<2> mesh;
	mesh.irregular = irregular_;
	const int total = static_cast<int>(ring_.vertex.size());
	std::vector<int> cornerVertex;
	if (ring_.corner.empty()) appendVertices(sectionOf(ring_, 0, total), spacing, mesh.vertex);
	for (std::size_t k = 0; k < ring_.corner.size(); ++k) {
		const bool isLast = k + 1 == ring_.corner.size();
		const int end = isLast ? ring_.corner[0] + total : ring_.corner[k + 1];
		cornerVertex.push_back(static_cast<int>(mesh.vertex.size()));
		appendVertices(sectionOf(ring_, ring_.corner[k], end), spacing, mesh.vertex);
	}
	closeOutline(mesh, cornerVertex);
	return mesh;
}

RingOutline superdisk(double a, double b, double n)
{
	constexpr int samples = 1024;
	Ring ring;
	for (int k = 0; k < samples; ++k) {
		const double t = 2 * std::numbers::pi * k / samples;
		const double x = std::cos(t), y = std::sin(t);
		ring.vertex.emplace_back(std::copysign(a * std::pow(std::abs(x), 2 / n), x),
					 std::copysign(b * std::pow(std::abs(y), 2 / n), y));
	}
	const double quarter =
		a * b * std::tgamma(1 + 1 / n) * std::tgamma(1 + 1 / n) / std::tgamma(1 + 2 / n);
	return RingOutline(ring, 4 * quarter);
}

int nearestWithoutSmallDivisors(double count)
{
	const int sixes = 6 * static_cast<int>(std::floor(count / 6));
	int nearest = sixes - 1;
	for (int number : { sixes + 1, sixes + 5, sixes + 7 })
		if (std::abs(number - count) < std::abs(nearest - count)) nearest = number;
	return nearest;
}

} // namespace softgrain
