#include "contact/search/RigidTips.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace softgrain {

namespace {

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

/// (Of a body that turns corners are off by rounding, another one in each step; numbers of points
/// must not be, where an edge is a whole number of spacings long.)
int partsOf(double length, double spacing)
{
	constexpr double rounding = 1 - 1e-9;
	return std::max(1, static_cast<int>(std::ceil(rounding * length / spacing)));
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
		const int parts = partsOf((b - a).norm(), spacing);
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

std::vector<ConvexEdge> edges(const BallSurface<3>&, double) { return {}; }

std::vector<ConvexEdge> edges(const PlateSurface<3>& plate, double)
{
	std::vector<ConvexEdge> found;
	for (int i = 0; i < 3; ++i) {
		const Vec<3>&a = plate.corner[i], &b = plate.corner[(i + 1) % 3];
		const Vec<3> away = plate.corner[(i + 2) % 3] - a, along = (b - a).normalized();
		const Vec<3> side = (away - away.dot(along) * along).normalized();
		found.push_back({ { a, b }, { side, side } });
	}
	return found;
}

std::vector<ConvexEdge> edges(const BlockSurface<3>& block, double spacing)
{
	const Skeleton<3> skeleton = skeletonOf(block);
	std::vector<ConvexEdge> found;
	for (const auto& [from, to] : skeleton.edge) {
		ConvexEdge edge { { skeleton.corner[from], skeleton.corner[to] }, {} };
		const Vec<3> y =
			block.axes.transpose() * (0.5 * (edge.from + edge.to) - block.centre);
		std::array<int, 2> across;
		int sides = 0;
		for (int a = 0; a < 3; ++a)
			if (!((from ^ to) >> a & 1)) across[sides++] = a;
		const auto wider = std::minmax(across[0], across[1], [&](int a, int b) {
					   return block.halfSides[a] < block.halfSides[b];
				   }).second;
		for (int i : { 0, 1 }) {
			const bool isNarrow = 2 * block.halfSides[across[i]] < spacing;
			const int a = isNarrow ? wider : across[i];
			edge.side[i] = -std::copysign(1., y[a]) * block.axes.col(a);
		}
		found.push_back(edge);
	}
	return found;
}

template <int dim> using Side = std::optional<Vec<dim>>; // its normal

template <int dim>
Side<dim> along(const BallSurface<dim>&, const Vec<dim>&, const Vec<dim>&, double, double)
{
	return std::nullopt;
}

template <int dim>
Side<dim> along(const PlateSurface<dim>& plate, const Vec<dim>&, const Vec<dim>& normal,
		double cosine, double)
{
	const Vec<dim> side = normalOf<dim>(plate);
	const double across = normal.dot(side);
	if (std::abs(across) <= cosine) return std::nullopt;
	return -std::copysign(1., across) * side;
}

/// Whether the side of a block across axis `a` is so narrow that no node need be on it.
template <int dim> bool isNarrow(const BlockSurface<dim>& block, int a, double spacing)
{
	for (int b = 0; b < dim; ++b)
		if (b != a && 2 * block.halfSides[b] < spacing) return true;
	return false;
}

template <int dim>
Side<dim> along(const BlockSurface<dim>& block, const Vec<dim>& place, const Vec<dim>& normal,
		double cosine, double spacing)
{
	const Vec<dim> y = block.axes.transpose() * (place - block.centre);
	Side<dim> found;
	double closest = cosine;
	for (int a = 0; a < dim; ++a) {
		const double rounding = 1e-9 * block.halfSides.maxCoeff();
		if (std::abs(y[a]) < block.halfSides[a] - rounding) continue;
		if (isNarrow<dim>(block, a, spacing)) continue;
		const double across = normal.dot(block.axes.col(a));
		const bool hasBothSides = block.halfSides[a] <= rounding;
		const double side =
			hasBothSides ? -std::copysign(1., across) : std::copysign(1., y[a]);
		if (-side * across <= closest) continue;
		closest = -side * across;
		found = side * block.axes.col(a);
	}
	return found;
}

} // namespace

template <int dim>
std::optional<Vec<dim>> sideAlong(const RigidSurface<dim>& surface, const Vec<dim>& place,
				  const Vec<dim>& normal, double angle, double spacing)
{
	return std::visit(
		[&](const auto& s) {
			return along<dim>(s, place, normal, std::cos(angle), spacing);
		},
		surface);
}

template <int dim>
std::vector<Tip<dim>> tipsOf(const RigidSurface<dim>& surface, const Box<dim>& box, double spacing)
{
	return std::visit([&](const auto& s) { return tips<dim>(s, box, spacing); }, surface);
}

std::vector<ConvexEdge> edgesOf(const RigidSurface<3>& surface, double spacing)
{
	return std::visit([&](const auto& s) { return edges(s, spacing); }, surface);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::optional<Vec<dim>> sideAlong<dim>(const RigidSurface<dim>&, const Vec<dim>&, \
							const Vec<dim>&, double, double);          \
	template std::vector<Tip<dim>> tipsOf<dim>(const RigidSurface<dim>&, const Box<dim>&,      \
						   double);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
