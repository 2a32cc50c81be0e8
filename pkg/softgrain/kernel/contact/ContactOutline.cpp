#include "contact/ContactOutline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace softgrain {

namespace {

/// Outward normal of a facet, its length the measure of the facet (3D: twice).
Vec<2> normalOf(const std::vector<Vec<2>>& x, const std::array<int, 2>& f)
{
	const Vec<2> edge = x[f[1]] - x[f[0]];
	return { edge[1], -edge[0] };
}

Vec<3> normalOf(const std::vector<Vec<3>>& x, const std::array<int, 3>& f)
{
	return (x[f[1]] - x[f[0]]).cross(x[f[2]] - x[f[0]]);
}

/// Whether a facet is crossed on the way from one place to another.
template <int dim>
bool isCrossed(const std::vector<Vec<dim>>& x, const std::array<int, dim>& f, const Vec<dim>& from,
	       const Vec<dim>& to)
{
	const Vec<dim>& corner = x[f[0]];
	Mat<dim> sides; // corner + sum_i w_i (x_i - corner) = to + t (from - to)
	for (int i = 1; i < dim; ++i)
		sides.col(i - 1) = x[f[i]] - corner;
	sides.col(dim - 1) = to - from;
	if (sides.determinant() == 0) return false;
	const Vec<dim> w = sides.inverse() * (to - corner);
	return w.minCoeff() >= 0 && w[dim - 1] <= 1 && w.template head<dim - 1>().sum() <= 1;
}

/// Of the edges of a facet.
double longestSquare(const std::vector<Vec<2>>& x, const std::array<int, 2>& f)
{
	return (x[f[1]] - x[f[0]]).squaredNorm();
}

double longestSquare(const std::vector<Vec<3>>& x, const std::array<int, 3>& f)
{
	return std::max({ (x[f[1]] - x[f[0]]).squaredNorm(), (x[f[2]] - x[f[1]]).squaredNorm(),
			  (x[f[0]] - x[f[2]]).squaredNorm() });
}

/// Of two facets of a ring, in its order: negative where the outline turns inwards by more than 17
/// degrees between them. (Outlines of dense packings do so by 4; two places were taken for the
/// nearest from 26 on: doc/decisions/0028-search.md.)
double outwardTurn(const Vec<2>& normal, const Vec<2>& next)
{
	constexpr double tangent = 0.3;
	return cross(normal, next) + tangent * normal.dot(next);
}

/// Between its sides a corner faces all directions by this much at least, as that of an equilateral
/// triangle does by itself.
constexpr double leastBetween = 0.5;

/// Of two facets of a ring: positive where the outline turns between them, either way, by more than
/// 60 degrees. (Its normal there is more than 30 degrees off either side; what is bent by more
/// fails to face what one of them lies on: doc/decisions/0028-search.md, Folds.)
double bendBetween(const Vec<2>& normal, const Vec<2>& next)
{
	const double tangent = std::numbers::sqrt3;
	return std::abs(cross(normal, next)) - tangent * normal.dot(next);
}

} // namespace

template <int dim> void ContactOutline<dim>::updateGeometry()
{
	box = boxOf(position).grown(nodeRadius);
	circumradius = farthestFrom<dim>(box.centre(), position);
	if (!hasFacets()) return;
	normal.assign(position.size(), Vec<dim>::Zero());
	double squaredEdge = 0;
	// asked of all facets in every step, without a branch in outlines without corners
	double leastTurn = 0, mostBend = 0;
	const bool hasCorners = mesh->hasCorners();
	Vec<dim> last = normalOf(position, mesh->facet.back());
	for (const auto& facet : mesh->facet) {
		const Vec<dim> n = normalOf(position, facet);
		if constexpr (dim == 2) {
			leastTurn = std::min(leastTurn, outwardTurn(last, n));
			if (!hasCorners || !isSharp(facet[0]))
				mostBend = std::max(mostBend, bendBetween(last, n));
		}
		last = n;
		for (int node : facet)
			normal[node] += n;
		squaredEdge = std::max(squaredEdge, longestSquare(position, facet));
	}
	longestEdge = std::sqrt(squaredEdge);
	folded = leastTurn < 0;
	bent = mostBend > 0;
	normalizeAll(normal);
	facetNormal.clear();
	if (!hasCorners) return;
	for (std::size_t f = 0; f < mesh->facet.size(); ++f)
		facetNormal.push_back(areaOfFacet(static_cast<int>(f)).normalized());
}

template <> bool ContactOutline<2>::isBent(int node) const
{
	if (!bent || isSharp(node)) return false;
	const auto& sides = mesh->facetsAbout[node];
	return bendBetween(areaOfFacet(sides[0]), areaOfFacet(sides[1])) > 0;
}

template <> bool ContactOutline<3>::isBent(int) const { return false; }

template <> bool NodeFacing<2>::isBetweenSides(const Vec<2>& direction) const
{
	const int a = (*sides_)[0], b = (*sides_)[1];
	const bool inOrder = body_.mesh->facet[a][1] == body_.mesh->facet[b][0];
	const Vec<2> before = body_.areaOfFacet(inOrder ? a : b),
		     after = body_.areaOfFacet(inOrder ? b : a);
	return cross(before, after) > 0 && cross(before, direction) <= 0 &&
	       cross(direction, after) <= 0;
}

/// Corners of cuboids are nowhere so sharp that it matters.
template <> bool NodeFacing<3>::isBetweenSides(const Vec<3>&) const { return false; }

template <int dim> double NodeFacing<dim>::mostOfSides(const Vec<dim>& direction) const
{
	double most = isBetweenSides(direction) ? leastBetween : -1;
	for (int facet : *sides_)
		most = std::max(most, -body_.normalOfFacet(facet).dot(direction));
	return most;
}

template <int dim> double NodeFacing<dim>::ofCorner(const Vec<dim>& direction) const
{
	if (isSharp_) return mostOfSides(direction);
	const double ofNormal = -normal_.dot(direction);
	return isBetweenSides(direction) ? std::max(ofNormal, leastBetween) : ofNormal;
}

template <int dim> std::vector<int> ContactOutline<dim>::nodesIn(const Box<dim>& region) const
{
	return numbersThat(nodes(), [&](int s) { return region.contains(position[s]); });
}

template <int dim> Vec<dim> ContactOutline<dim>::areaOfFacet(int facet) const
{
	return (dim == 2 ? 1. : 0.5) * normalOf(position, mesh->facet[facet]);
}

/// By the number of facets to the right.
template <> bool ContactOutline<2>::encloses(const Vec<2>& x) const
{
	if (!hasFacets() || !box.contains(x)) return false;
	bool inside = false;
	for (const auto& [first, second] : mesh->facet) {
		const Vec<2>&a = position[first], &b = position[second];
		if ((a[1] > x[1]) != (b[1] > x[1]) &&
		    x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
			inside = !inside;
	}
	return inside;
}

/// By the solid angle of the outline (Van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30, 1983):
/// 4 pi inside, 0 outside.
template <> bool ContactOutline<3>::encloses(const Vec<3>& x) const
{
	if (!hasFacets() || !box.contains(x)) return false;
	double angle = 0;
	for (const auto& vertex : mesh->facet) {
		const Vec<3> a = position[vertex[0]] - x, b = position[vertex[1]] - x,
			     c = position[vertex[2]] - x;
		const double A = a.norm(), B = b.norm(), C = c.norm();
		angle += 2 * std::atan2(a.dot(b.cross(c)),
					A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
	}
	return angle > 2 * std::numbers::pi;
}

template <int dim> bool ContactOutline<dim>::encloses(int fromNode, const Vec<dim>& x) const
{
	if (!encloses(x)) return false;
	return std::none_of(mesh->facet.begin(), mesh->facet.end(), [&](const auto& vertex) {
		const bool isAtNode =
			std::find(vertex.begin(), vertex.end(), fromNode) != vertex.end();
		return !isAtNode && isCrossed<dim>(position, vertex, position[fromNode], x);
	});
}

template <int dim> bool ContactOutline<dim>::holds(const Vec<dim>& centre, double radius) const
{
	constexpr double concentric = 0.2; // distance over the smaller radius
	const double distance = (box.centre() - centre).norm(), own = innerRadius();
	const bool isNear =
		distance < concentric * std::min(radius, own) || distance < own - radius;
	// what touches a grain that is pressed flat, or bent, may be so near to its centre from
	// outside
	return isNear && (!hasFacets() || encloses(centre));
}

template <int dim> Vec<dim> ContactOutline<dim>::nodeArea(int node) const
{
	Vec<dim> area = Vec<dim>::Zero();
	for (int facet : mesh->facetsAbout[node])
		area += areaOfFacet(facet) / dim;
	return area;
}

template <int dim> std::vector<Vec<dim>> ContactOutline<dim>::nodeAreas() const
{
	std::vector<Vec<dim>> area;
	for (int s = 0; s < nodes(); ++s)
		area.push_back(hasFacets() ? nodeArea(s) : Vec<dim>(Vec<dim>::Zero()));
	return area;
}

template <int dim>
void ContactOutline<dim>::becomeImage(const ContactOutline& of, const Vec<dim>& shift)
{
	*this = of;
	for (Vec<dim>& x : position)
		x += shift;
	box = { box.low + shift, box.high + shift };
	carried += shift;
}

template struct ContactOutline<2>;
template struct ContactOutline<3>;
template class NodeFacing<2>;
template class NodeFacing<3>;

} // namespace softgrain
