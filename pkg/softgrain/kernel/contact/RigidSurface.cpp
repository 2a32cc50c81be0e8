#include "contact/RigidSurface.hpp"
#include "contact/Facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace softgrain {

namespace {

/// An outline faces a side, and the edge of one, within the angles of these cosines. What is
/// further off than the second has a place nearer to the edge than the node, which the tips see.
constexpr double alongSide = 0.1, aboutEdge = 0.97;

template <int dim> using Place = std::optional<SurfacePlace<dim>>;

constexpr double farFromEdges = std::numeric_limits<double>::infinity();

template <int dim>
Place<dim> placeOnSurface(const BallSurface<dim>& ball, const Vec<dim>& x, const Faces<dim>&,
			  const GoesOn<dim>&)
{
	const Vec<dim> apart = x - ball.centre;
	const double distance = apart.norm();
	if (!(distance > 0)) return std::nullopt;
	return SurfacePlace<dim> { apart / distance, distance - ball.radius, farFromEdges };
}

/// About an edge or a corner: no side lies under `x`.
template <int dim>
Place<dim> placeBeyondEdge(const Vec<dim>& foot, const Vec<dim>& x, const Faces<dim>& faces)
{
	const double distance = (x - foot).norm();
	if (!(distance > 0)) return std::nullopt;
	const Vec<dim> normal = (x - foot) / distance;
	if (!faces(normal, aboutEdge)) return std::nullopt;
	return SurfacePlace<dim> { normal, distance, 0 };
}

/// Whether a point beneath the plane of a side, at such a depth, and beyond its edge is one of that
/// side all the same: it has sunk into what rises from the edge, as in the inside corner of a box.
template <int dim>
bool isBesideEdge(const Vec<dim>& edge, const Vec<dim>& beyond, const Vec<dim>& normal,
		  double depth, const GoesOn<dim>& goesOn)
{
	constexpr double farthest = 4; // over the depth
	return beyond.norm() < farthest * depth && goesOn(edge, beyond.normalized(), normal);
}

/// Plates and blocks that share an edge leave no slit between them: that much of one is added, over
/// its size.
constexpr double plateMargin = 1e-9;
/// Over the height of a plate: what is nearer to an edge asks who else bears it.
constexpr double nearEnd = 0.01;

Vec<2> plateNormal(const PlateSurface<2>& plate)
{
	const Vec<2> edge = plate.corner[1] - plate.corner[0];
	return Vec<2>(edge[1], -edge[0]).normalized();
}
Vec<3> plateNormal(const PlateSurface<3>& plate)
{
	return (plate.corner[1] - plate.corner[0])
		.cross(plate.corner[2] - plate.corner[0])
		.normalized();
}

template <int dim>
Vec<dim> placeAt(const PlateSurface<dim>& plate, const std::array<double, dim>& weight)
{
	Vec<dim> place = Vec<dim>::Zero();
	for (int i = 0; i < dim; ++i)
		place += weight[i] * plate.corner[i];
	return place;
}

/// From a corner of the plate to the opposite edge, at right angles.
Vec<2> awayFrom(const PlateSurface<2>& plate, int i)
{
	return plate.corner[1 - i] - plate.corner[i];
}
Vec<3> awayFrom(const PlateSurface<3>& plate, int i)
{
	const Vec<3>&a = plate.corner[(i + 1) % 3], &b = plate.corner[(i + 2) % 3];
	const Vec<3> edge = (b - a).normalized(), apart = a - plate.corner[i];
	return apart - apart.dot(edge) * edge;
}

/// Whether a point at such a depth beneath the plate is out of it sooner over an edge that the
/// outline faces: the plate pokes into the outline then, and has no side there but its edge.
template <int dim>
bool pokesIn(const PlateSurface<dim>& plate, const std::array<double, dim>& weight,
	     const Vec<dim>& normal, double depth, const Faces<dim>& faces,
	     const GoesOn<dim>& goesOn)
{
	for (int i = 0; depth > 0 && i < dim; ++i) {
		const Vec<dim> away = awayFrom(plate, i), over = away.normalized();
		if (weight[i] * away.norm() >= depth || !faces(over, alongSide)) continue;
		const Vec<dim> edge = placeAt<dim>(plate, weight) + weight[i] * away;
		if (!goesOn(edge, over, normal)) return true;
	}
	return false;
}

template <int dim>
Place<dim> placeOnSurface(const PlateSurface<dim>& plate, const Vec<dim>& x,
			  const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	const auto weight = nearestOnFacet(x, plate.corner);
	const Vec<dim> foot = placeAt<dim>(plate, weight);
	const Vec<dim> normal = plateNormal(plate);
	const double height = (x - foot).dot(normal);
	const double size = (plate.corner[1] - plate.corner[0]).norm();
	const Vec<dim> beyond = (x - foot) - height * normal;
	const bool isBeyond = beyond.norm() > plateMargin * size;
	if (isBeyond)
		if (const auto edge = placeBeyondEdge<dim>(foot, x, faces)) return edge;
	for (const double side : { 1., -1. }) {
		const double depth = -side * height;
		const Vec<dim> out = side * normal;
		if (!faces(out, alongSide)) continue;
		if (isBeyond ? !isBesideEdge<dim>(foot, beyond, out, depth, goesOn)
			     : pokesIn<dim>(plate, weight, out, depth, faces, goesOn))
			return std::nullopt;
		const bool isNearEnd = *std::min_element(weight.begin(), weight.end()) < nearEnd;
		return SurfacePlace<dim> { out, -depth, farFromEdges, isNearEnd, depth > 0 };
	}
	return std::nullopt;
}

/// The same of a point `y`, in the axes of a block, beneath its side across axis `a`.
template <int dim>
bool pokesIn(const BlockSurface<dim>& block, int a, const Vec<dim>& y, const Vec<dim>& normal,
	     double depth, const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	for (int b = 0; b < dim; ++b) {
		const double toEdge = block.halfSides[b] - std::abs(y[b]);
		if (b == a || toEdge >= depth) continue;
		const Vec<dim> over = std::copysign(1., y[b]) * block.axes.col(b);
		if (!faces(over, alongSide)) continue;
		Vec<dim> foot = y;
		foot[a] = std::copysign(block.halfSides[a], -y[a]);
		const Vec<dim> edge = block.centre + block.axes * foot + toEdge * over;
		if (!goesOn(edge, over, normal)) return true;
	}
	return false;
}

template <int dim>
Place<dim> placeOnSurface(const BlockSurface<dim>& block, const Vec<dim>& x,
			  const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	Vec<dim> foot = y.cwiseMax(-block.halfSides).cwiseMin(block.halfSides);
	if ((y - foot).norm() <= plateMargin * block.halfSides.maxCoeff()) foot = y;
	const bool isBeyondEdge = ((y - foot).array() != 0).count() > 1;
	if (isBeyondEdge)
		if (const auto edge =
			    placeBeyondEdge<dim>(block.centre + block.axes * foot, x, faces))
			return edge;
	const Vec<dim> depth = block.halfSides - foot.cwiseAbs();
	Place<dim> best;
	for (int a = 0; a < dim; ++a) {
		const bool isBeside = foot != y && foot[a] == y[a]; // of this side
		if (isBeyondEdge && !isBeside) continue;
		for (const double side : { 1., -1. }) {
			const double gap = side * y[a] - block.halfSides[a];
			const Vec<dim> normal = side * block.axes.col(a);
			const bool isBehind = !isBeside && foot != y && gap < 0;
			if ((best && gap <= best->gap) || !faces(normal, alongSide)) continue;
			Vec<dim> end = foot;
			end[a] = side * block.halfSides[a];
			if (isBeside &&
			    !isBesideEdge<dim>(block.centre + block.axes * end,
					       block.axes * (y - foot), normal, -gap, goesOn))
				continue;
			if (isBehind && pokesIn<dim>(block, a, y, normal, -gap, faces, goesOn))
				continue;
			best = SurfacePlace<dim> { normal, gap, farFromEdges, false, isBehind };
			for (int b = 0; b < dim; ++b) {
				if (b == a) continue;
				best->toEdge = std::min(best->toEdge, depth[b]);
				best->inwards -= std::copysign(1., y[b]) * block.axes.col(b);
			}
		}
	}
	return best;
}

template <int dim> double distanceOf(const Vec<dim>& x, const BallSurface<dim>& ball)
{
	return std::max((x - ball.centre).norm() - ball.radius, 0.);
}

template <int dim> double distanceOf(const Vec<dim>& x, const PlateSurface<dim>& plate)
{
	return (x - placeAt<dim>(plate, nearestOnFacet(x, plate.corner))).norm();
}

template <int dim> double distanceOf(const Vec<dim>& x, const BlockSurface<dim>& block)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	return (y.cwiseAbs() - block.halfSides).cwiseMax(0).norm();
}

template <int dim> BallSurface<dim> ballAboutSurface(const BallSurface<dim>& ball) { return ball; }

template <int dim> BallSurface<dim> ballAboutSurface(const PlateSurface<dim>& plate)
{
	BallSurface<dim> ball { Vec<dim>::Zero(), 0 };
	for (const Vec<dim>& corner : plate.corner)
		ball.centre += corner / dim;
	for (const Vec<dim>& corner : plate.corner)
		ball.radius = std::max(ball.radius, (corner - ball.centre).norm());
	return ball;
}

template <int dim> BallSurface<dim> ballAboutSurface(const BlockSurface<dim>& block)
{
	return { block.centre, block.halfSides.norm() };
}

/// Corners of a polytope, and which of them edges join.
template <int dim> struct Skeleton {
	std::vector<Vec<dim>> corner;
	std::vector<std::pair<int, int>> edge;
};

template <int dim> Skeleton<dim> skeletonOf(const PlateSurface<dim>& plate)
{
	Skeleton<dim> skeleton;
	skeleton.corner.assign(plate.corner.begin(), plate.corner.end());
	for (int i = 0; i < dim; ++i)
		for (int k = 0; k < i; ++k)
			skeleton.edge.push_back({ k, i });
	return skeleton;
}

template <int dim> Skeleton<dim> skeletonOf(const BlockSurface<dim>& block)
{
	Skeleton<dim> skeleton;
	for (int k = 0; k < 1 << dim; ++k) {
		Vec<dim> y = block.halfSides;
		for (int a = 0; a < dim; ++a) {
			if (!(k >> a & 1)) continue;
			y[a] = -y[a];
			skeleton.edge.push_back({ k & ~(1 << a), k });
		}
		skeleton.corner.push_back(block.centre + block.axes * y);
	}
	return skeleton;
}

/// The parts from 0 to 1 of the way from a to b that lie in a box; the first is larger where none
/// does.
template <int dim>
std::pair<double, double> partIn(const Box<dim>& box, const Vec<dim>& a, const Vec<dim>& b)
{
	double first = 0, last = 1;
	for (int i = 0; i < dim; ++i) {
		const double way = b[i] - a[i];
		if (way == 0) {
			if (a[i] < box.low[i] || a[i] > box.high[i]) return { 1, 0 };
			continue;
		}
		const auto [from, to] =
			std::minmax({ (box.low[i] - a[i]) / way, (box.high[i] - a[i]) / way });
		first = std::max(first, from);
		last = std::min(last, to);
	}
	return { first, last };
}

template <int dim> std::vector<Tip<dim>> tips(const BallSurface<dim>& ball, const Box<dim>&, double)
{
	return { { ball, 0 } };
}

template <int dim, class Surface>
std::vector<Tip<dim>> tips(const Surface& surface, const Box<dim>& box, double spacing)
{
	const Skeleton<dim> skeleton = skeletonOf(surface);
	std::vector<Tip<dim>> found;
	int number = 0; // of the corners and points before
	for (const Vec<dim>& corner : skeleton.corner)
		found.push_back({ { corner, 0 }, number++ });
	if (dim == 2) return found; // edges are the sides
	for (const auto& [from, to] : skeleton.edge) {
		const Vec<dim>&a = skeleton.corner[from], &b = skeleton.corner[to];
		const int parts = static_cast<int>(std::ceil((b - a).norm() / spacing));
		const auto [first, last] = partIn<dim>(box, a, b);
		if (first <= last) { // both within [0, 1]
			const int begin = std::max(1, static_cast<int>(std::ceil(first * parts)));
			const int end = std::min(parts - 1, static_cast<int>(last * parts));
			for (int k = begin; k <= end; ++k)
				found.push_back({ { a + (b - a) * k / parts, 0 }, number + k });
		}
		number += parts;
	}
	return found;
}

template <int dim>
bool isAlong(const BallSurface<dim>&, const Vec<dim>&, const Vec<dim>&, double, double)
{
	return false;
}

template <int dim>
bool isAlong(const PlateSurface<dim>& plate, const Vec<dim>&, const Vec<dim>& normal, double cosine,
	     double)
{
	return std::abs(normal.dot(plateNormal(plate))) > cosine;
}

/// Whether the side of a block across axis `a` is so narrow that no node need be on it.
template <int dim> bool isNarrow(const BlockSurface<dim>& block, int a, double spacing)
{
	for (int b = 0; b < dim; ++b)
		if (b != a && 2 * block.halfSides[b] < spacing) return true;
	return false;
}

template <int dim>
bool isAlong(const BlockSurface<dim>& block, const Vec<dim>& place, const Vec<dim>& normal,
	     double cosine, double spacing)
{
	const Vec<dim> y = block.axes.transpose() * (place - block.centre);
	for (int a = 0; a < dim; ++a) {
		const double rounding = 1e-9 * block.halfSides.maxCoeff();
		if (std::abs(y[a]) < block.halfSides[a] - rounding) continue;
		if (isNarrow<dim>(block, a, spacing)) continue;
		const double across = normal.dot(block.axes.col(a));
		const bool hasBothSides = block.halfSides[a] <= rounding;
		const double inwards =
			hasBothSides ? std::abs(across) : -std::copysign(1., y[a]) * across;
		if (inwards > cosine) return true;
	}
	return false;
}

template <int dim> std::vector<double> numbersOf(const BallSurface<dim>& ball)
{
	std::vector<double> numbers(ball.centre.begin(), ball.centre.end());
	numbers.push_back(ball.radius);
	return numbers;
}

template <int dim> std::vector<double> numbersOf(const PlateSurface<dim>& plate)
{
	std::vector<double> numbers;
	for (const Vec<dim>& corner : plate.corner)
		numbers.insert(numbers.end(), corner.begin(), corner.end());
	return numbers;
}

template <int dim> std::vector<double> numbersOf(const BlockSurface<dim>& block)
{
	std::vector<double> numbers(block.centre.begin(), block.centre.end());
	numbers.insert(numbers.end(), block.axes.reshaped().begin(), block.axes.reshaped().end());
	numbers.insert(numbers.end(), block.halfSides.begin(), block.halfSides.end());
	return numbers;
}

} // namespace

template <int dim> std::vector<double> placeNumbers(const RigidSurface<dim>& surface)
{
	return std::visit([](const auto& s) { return numbersOf<dim>(s); }, surface);
}

template <int dim>
bool liesAlongSide(const RigidSurface<dim>& surface, const Tip<dim>& tip, const Vec<dim>& normal,
		   double angle, double spacing)
{
	return std::visit(
		[&](const auto& s) {
			return isAlong<dim>(s, tip.ball.centre, normal, std::cos(angle), spacing);
		},
		surface);
}

template <int dim>
std::optional<SurfacePlace<dim>> placeOn(const RigidSurface<dim>& surface, const Vec<dim>& x,
					 const Faces<dim>& faces, const GoesOn<dim>& goesOn)
{
	return std::visit([&](const auto& s) { return placeOnSurface<dim>(s, x, faces, goesOn); },
			  surface);
}

template <int dim> double distanceTo(const RigidSurface<dim>& surface, const Vec<dim>& x)
{
	return std::visit([&](const auto& s) { return distanceOf<dim>(x, s); }, surface);
}

template <int dim> BallSurface<dim> ballAbout(const RigidSurface<dim>& surface)
{
	return std::visit([](const auto& s) { return ballAboutSurface<dim>(s); }, surface);
}

template <int dim>
std::vector<Tip<dim>> tipsOf(const RigidSurface<dim>& surface, const Box<dim>& box, double spacing)
{
	return std::visit([&](const auto& s) { return tips<dim>(s, box, spacing); }, surface);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::optional<SurfacePlace<dim>> placeOn<dim>(                                    \
		const RigidSurface<dim>&, const Vec<dim>&, const Faces<dim>&, const GoesOn<dim>&); \
	template std::vector<double> placeNumbers<dim>(const RigidSurface<dim>&);                  \
	template bool liesAlongSide<dim>(const RigidSurface<dim>&, const Tip<dim>&,                \
					 const Vec<dim>&, double, double);                         \
	template double distanceTo<dim>(const RigidSurface<dim>&, const Vec<dim>&);                \
	template BallSurface<dim> ballAbout<dim>(const RigidSurface<dim>&);                        \
	template std::vector<Tip<dim>> tipsOf<dim>(const RigidSurface<dim>&, const Box<dim>&,      \
						   double);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
