#include "contact/Lever.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace softgrain {

namespace {

/// Cosine of the angle up to which a facet may stand to a contact.
constexpr double leastCosine = 0.5;

template <int dim> Levers<dim> noLevers()
{
	Levers<dim> a;
	a.fill(Vec<dim>::Zero());
	return a;
}

} // namespace

Levers<2> leversOf(const std::array<Vec<2>, mostPartners<2>>& x, const Vec<2>& n, double gap)
{
	Levers<2> a = noLevers<2>();
	const Vec<2> edge = x[2] - x[1]; // the facet, between the nodes beside it
	const Vec<2> along = edge - edge.dot(n) * n;
	if (along.norm() < leastCosine * edge.norm()) return a;
	a[2] = gap / along.squaredNorm() * along;
	a[1] = -a[2];
	return a;
}

Levers<3> leversOf(const std::array<Vec<3>, mostPartners<3>>& x, const Vec<3>& n, double gap)
{
	Levers<3> a = noLevers<3>();
	const Vec<3> u = x[1] - x[0], v = x[2] - x[0], area = u.cross(v);
	const double across = area.dot(n);
	if (std::abs(across) < leastCosine * area.norm()) return a;
	a[1] = gap / across * v.cross(n);
	a[2] = gap / across * n.cross(u);
	a[0] = -a[1] - a[2];
	return a;
}

} // namespace softgrain
