#include "contact/RigidSurface.hpp"
#include "contact/Facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace softgrain {

template <> Vec<2> normalOf<2>(const PlateSurface<2>& plate)
{
	const Vec<2> edge = plate.corner[1] - plate.corner[0];
	return Vec<2>(edge[1], -edge[0]).normalized();
}
template <> Vec<3> normalOf<3>(const PlateSurface<3>& plate)
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

namespace {

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

template <int dim> Vec<dim> nearestTo(const Vec<dim>& x, const BallSurface<dim>& ball)
{
	const Vec<dim> apart = x - ball.centre;
	return ball.centre + std::min(1., ball.radius / apart.norm()) * apart;
}

template <int dim> Vec<dim> nearestTo(const Vec<dim>& x, const PlateSurface<dim>& plate)
{
	return placeAt<dim>(plate, nearestOnFacet(x, plate.corner));
}

template <int dim> Vec<dim> nearestTo(const Vec<dim>& x, const BlockSurface<dim>& block)
{
	const Vec<dim> y = block.axes.transpose() * (x - block.centre);
	return block.centre + block.axes * y.cwiseMin(block.halfSides).cwiseMax(-block.halfSides);
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

template <int dim> double distanceTo(const RigidSurface<dim>& surface, const Vec<dim>& x)
{
	return std::visit([&](const auto& s) { return distanceOf<dim>(x, s); }, surface);
}

template <int dim> Vec<dim> nearestPlaceOn(const RigidSurface<dim>& surface, const Vec<dim>& x)
{
	return std::visit([&](const auto& s) { return nearestTo<dim>(x, s); }, surface);
}

template <int dim> BallSurface<dim> ballAbout(const RigidSurface<dim>& surface)
{
	return std::visit([](const auto& s) { return ballAboutSurface<dim>(s); }, surface);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template Vec<dim> placeAt<dim>(const PlateSurface<dim>&, const std::array<double, dim>&);  \
	template std::vector<double> placeNumbers<dim>(const RigidSurface<dim>&);                  \
	template double distanceTo<dim>(const RigidSurface<dim>&, const Vec<dim>&);                \
	template Vec<dim> nearestPlaceOn<dim>(const RigidSurface<dim>&, const Vec<dim>&);          \
	template BallSurface<dim> ballAbout<dim>(const RigidSurface<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
