#include "assembly/RigidInKernel.hpp"
#include "contact/Facets.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace softgrain {

namespace {

/// Cosine from which an axis counts as that of the plane, up to rounding.
constexpr double alongAxis = 1 - 1e-12;
/// Over the side of a triangle: cuts that are shorter are none.
constexpr double shortestCut = 1e-9;
/// Of a unit normal that YADE computed.
constexpr double normalRounding = 1e-9;

/// Throws std::invalid_argument naming the body.
[[noreturn]] void refuse(const RigidBodyDescription& body, const std::string& why)
{
	throw std::invalid_argument("rigid body #" + std::to_string(body.id) + " " + why);
}

/// The surface as grains in the plane z see it. None where the plane misses it; throws
/// std::invalid_argument if it cannot be seen in that plane.
template <int dim>
std::optional<RigidSurface<dim>> surfaceIn(const RigidBodyDescription& body, double z);

/// Where a facet meets the plane of the grains: the ends of a segment, or less than two places. One
/// that stands on the plane, or hangs from it, does so with its edge.
std::vector<Vec<2>> cutOfFacet(const std::array<Vec3, 3>& corner, double z)
{
	std::vector<Vec<2>> cut, upon;
	for (int i = 0; i < 3; ++i) {
		const Vec3 a = corner[i], b = corner[(i + 1) % 3];
		const double ha = a[2] - z, hb = b[2] - z;
		if (ha == 0) upon.push_back(a.head<2>());
		if ((ha < 0) != (hb < 0)) cut.push_back((a + ha / (ha - hb) * (b - a)).head<2>());
	}
	return upon.size() == 2 ? upon : cut;
}

template <> std::optional<RigidSurface<2>> surfaceIn<2>(const RigidBodyDescription& body, double z)
{
	using Form = RigidBodyDescription::Form;
	const Vec<2> centre = body.position.head<2>();
	if (body.form == Form::ball) {
		if (std::abs(body.position[2] - z) > planeTolerance * body.size[0])
			refuse(body, "is a Sphere near 2D soft grains with its centre at z = " +
					     std::to_string(body.position[2]) +
					     ", out of their plane z = " + std::to_string(z) +
					     "; put it into that plane");
		return BallSurface<2> { centre, body.size[0] };
	}
	if (body.form == Form::block) {
		const Mat3 axes = body.orientation.toRotationMatrix();
		if (std::abs(axes(2, 2)) < alongAxis)
			refuse(body,
			       "is a Box near 2D soft grains that is turned about x or y; turn "
			       "it about z only");
		if (std::abs(body.position[2] - z) > body.size[2]) return std::nullopt;
		return BlockSurface<2> { centre, axes.topLeftCorner<2, 2>(), body.size.head<2>() };
	}
	const std::vector<Vec<2>> cut = cutOfFacet(body.corner, z);
	const double size = (body.corner[1] - body.corner[0]).norm();
	if (cut.size() < 2 || (cut[1] - cut[0]).norm() < shortestCut * size) return std::nullopt;
	return PlateSurface<2> { { cut[0], cut[1] } };
}

template <> std::optional<RigidSurface<3>> surfaceIn<3>(const RigidBodyDescription& body, double)
{
	using Form = RigidBodyDescription::Form;
	if (body.form == Form::ball) return BallSurface<3> { body.position, body.size[0] };
	if (body.form == Form::block)
		return BlockSurface<3> { body.position, body.orientation.toRotationMatrix(),
					 body.size };
	return PlateSurface<3> { body.corner };
}

} // namespace

template <int dim>
std::optional<RigidSurface<dim>> RigidSight<dim>::surfaceOf(const RigidBodyDescription& body) const
{
	if (contact == ContactGeometry::nodes)
		refuse(body, "is near soft grains with contact = 'nodes', which touch Walls and "
			     "each other only; use contact = 'surface'");
	return surfaceIn<dim>(body, z);
}

template <int dim>
typename RigidSight<dim>::Found RigidSight<dim>::find(const RigidBodyDescription& body) const
{
	try {
		return { surfaceOf(body) };
	} catch (const std::invalid_argument&) {
		return { std::nullopt, true };
	}
}

template <int dim>
std::vector<SurfaceBeside<dim>>
RigidSight<dim>::beside(int id, const std::vector<RigidBodyDescription>& bodies) const
{
	std::vector<SurfaceBeside<dim>> surfaces;
	for (const RigidBodyDescription& body : bodies)
		if (const Found found = find(body); found.surface)
			surfaces.push_back({ *found.surface, body.id < id });
	return surfaces;
}

template <int dim>
void describe(RigidSide<dim>& side, const RigidSurface<dim>& surface,
	      const RigidBodyDescription& body, const Vec<dim>& shift)
{
	const BallSurface<dim> about = ballAbout<dim>(surface);
	side.surface = surface;
	side.pivot = toKernel<dim>(body.pivot) + shift;
	side.velocities.middle = toKernel<dim>(body.velocity);
	side.velocities.spread =
		(body.velocity - toSpace<dim>(side.velocities.middle)).norm() + // across the plane
		body.angularVelocity.norm() * ((about.centre - side.pivot).norm() + about.radius);
}

std::optional<Vec3> placeInPlane(const RigidBodyDescription& plate, const Vec3& x)
{
	const auto cut = surfaceIn<2>(plate, x.z());
	if (!cut) return std::nullopt;
	const auto& corner = std::get<PlateSurface<2>>(*cut).corner;
	const auto weight = nearestOnFacet(x.head<2>(), corner);
	const Vec<2> place = weight[0] * corner[0] + weight[1] * corner[1];
	return Vec3(place[0], place[1], x.z());
}

template <int dim> RigidPartner<dim> partnerOf(const RigidMotionDescription& d)
{
	RigidPartner<dim> p;
	p.centre = toKernel<dim>(d.centre);
	p.velocity = toKernel<dim>(d.freeVelocity);
	p.spin = angularToKernel<dim>(d.freeAngularVelocity);
	p.velocityBefore = toKernel<dim>(d.velocity);
	p.spinBefore = angularToKernel<dim>(d.angularVelocity);
	p.inverseMass = toKernel<dim>(d.inverseMass);
	p.inverseInertia = d.inverseInertia.bottomRightCorner<spins<dim>, spins<dim>>();
	return p;
}

template <int dim> std::optional<RigidContact<dim>> contactOf(const RigidContactDescription& d)
{
	if (dim == 2 && std::abs(d.normal[2]) > normalRounding) {
		if (std::abs(d.normal[2]) > 1 - normalRounding) return std::nullopt;
		std::ostringstream message;
		message << "two rigid bodies touch at (" << d.point.transpose()
			<< ") m, out of the plane of 2D soft grains: put their centres into that "
			   "plane and keep them there, a clump as well (state.blockedDOFs = 'zXY')";
		throw std::invalid_argument(message.str());
	}
	return RigidContact<dim> { d.first,
				   d.second,
				   toKernel<dim>(d.point),
				   toKernel<dim>(d.normal),
				   d.gap,
				   d.size,
				   d.friction,
				   toKernel<dim>(d.impulse),
				   toKernel<dim>(d.image.shift),
				   toKernel<dim>(d.image.velocity),
				   d.restitution };
}

RigidBodyDescription displaced(RigidBodyDescription body, const Vec3& shift)
{
	body.position += shift;
	body.pivot += shift;
	for (Vec3& corner : body.corner)
		corner += shift;
	return body;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template struct RigidSight<dim>;                                                           \
	template void describe<dim>(RigidSide<dim>&, const RigidSurface<dim>&,                     \
				    const RigidBodyDescription&, const Vec<dim>&);                 \
	template RigidPartner<dim> partnerOf<dim>(const RigidMotionDescription&);                  \
	template std::optional<RigidContact<dim>> contactOf<dim>(const RigidContactDescription&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
