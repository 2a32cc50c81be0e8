#include "contact/RigidSurface.hpp"
#include "contact/Facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace softgrain {

namespace {

template <int dim> using Faces = std::function<bool(const Vec<dim>&)>;
template <int dim> using Place = std::optional<SurfacePlace<dim>>;

template <int dim>
Place<dim> placeOnSurface(const BallSurface<dim>& ball, const Vec<dim>& x, const Faces<dim>&)
{
	const Vec<dim> apart = x - ball.centre;
	const double distance = apart.norm();
	if (!(distance > 0)) return std::nullopt;
	return SurfacePlace<dim> { apart / distance, distance - ball.radius };
}

/// About an edge or a corner: no side lies under `x`.
template <int dim>
Place<dim> placeBeyondEdge(const Vec<dim>& foot, const Vec<dim>& x, const Faces<dim>& faces)
{
	const double distance = (x - foot).norm();
	if (!(distance > 0)) return std::nullopt;
	const Vec<dim> normal = (x - foot) / distance;
	if (!faces(normal)) return std::nullopt;
	return SurfacePlace<dim> { normal, distance };
}

/// Plates that share an edge leave no slit between them: that much of a plate is added, over its
/// size.
constexpr double plateMargin = 1e-9;

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
Place<dim> placeOnSurface(const PlateSurface<dim>& plate, const Vec<dim>& x,
			  const Faces<dim>& faces)
{
	const auto weight = nearestOnFacet(x, plate.corner);
	Vec<dim> foot = Vec<dim>::Zero();
	for (int i = 0; i < dim; ++i)
		foot += weight[i] * plate.corner[i];
	const Vec<dim> normal = plateNormal(plate);
	const double height = (x - foot).dot(normal);
	const double size = (plate.corner[1] - plate.corner[0]).norm();
	if (((x - foot) - height * normal).norm() > plateMargin * size)
		return placeBeyondEdge<dim>(foot, x, faces);
	for (const double side : { 1., -1. })
		if (faces(side * normal)) return SurfacePlace<dim> { side * normal, side * height };
	return std::nullopt;
}

template <int dim>
Place<dim> placeOnSurface(const BlockSurface<dim>& block, const Vec<dim>& x,
			  const Faces<dim>& faces)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	const Vec<dim> foot = y.cwiseMax(-block.halfSides).cwiseMin(block.halfSides);
	if (((y - foot).array() != 0).count() > 1)
		return placeBeyondEdge<dim>(block.centre + block.axes * foot, x, faces);
	Place<dim> best;
	for (int a = 0; a < dim; ++a) {
		if (foot != y && foot[a] == y[a]) continue; // outside another side
		for (const double side : { 1., -1. }) {
			const double gap = side * y[a] - block.halfSides[a];
			const Vec<dim> normal = side * block.axes.col(a);
			if (foot != y && gap < 0) continue; // the side turned away
			if ((!best || gap > best->gap) && faces(normal))
				best = SurfacePlace<dim> { normal, gap };
		}
	}
	return best;
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

template <int dim> std::vector<BallSurface<dim>> tips(const BallSurface<dim>& ball)
{
	return { ball };
}

template <int dim> std::vector<BallSurface<dim>> tips(const PlateSurface<dim>& plate)
{
	std::vector<BallSurface<dim>> found;
	for (const Vec<dim>& corner : plate.corner)
		found.push_back({ corner, 0 });
	return found;
}

template <int dim> std::vector<BallSurface<dim>> tips(const BlockSurface<dim>& block)
{
	std::vector<BallSurface<dim>> found;
	for (int k = 0; k < 1 << dim; ++k) {
		Vec<dim> y = block.halfSides;
		for (int a = 0; a < dim; ++a)
			if (k >> a & 1) y[a] = -y[a];
		found.push_back({ block.centre + block.axes * y, 0 });
	}
	return found;
}

} // namespace

template <int dim>
std::optional<SurfacePlace<dim>> placeOn(const RigidSurface<dim>& surface, const Vec<dim>& x,
					 const std::function<bool(const Vec<dim>&)>& faces)
{
	return std::visit([&](const auto& s) { return placeOnSurface<dim>(s, x, faces); }, surface);
}

template <int dim> BallSurface<dim> ballAbout(const RigidSurface<dim>& surface)
{
	return std::visit([](const auto& s) { return ballAboutSurface<dim>(s); }, surface);
}

template <int dim> std::vector<BallSurface<dim>> tipsOf(const RigidSurface<dim>& surface)
{
	return std::visit([](const auto& s) { return tips<dim>(s); }, surface);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::optional<SurfacePlace<dim>> placeOn<dim>(                                    \
		const RigidSurface<dim>&, const Vec<dim>&,                                         \
		const std::function<bool(const Vec<dim>&)>&);                                      \
	template BallSurface<dim> ballAbout<dim>(const RigidSurface<dim>&);                        \
	template std::vector<BallSurface<dim>> tipsOf<dim>(const RigidSurface<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
