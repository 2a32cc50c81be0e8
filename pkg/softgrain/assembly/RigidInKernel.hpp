// Descriptions of rigid bodies as the kernel takes them, in the dimension of the grains.
#pragma once

#include "assembly/RigidDescriptions.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/RigidSide.hpp"
#include "contact/RigidSurface.hpp"
#include "contact/solve/RigidContact.hpp"

#include <optional>
#include <vector>

namespace softgrain {

/// How the grains see rigid bodies.
template <int dim> struct RigidSight {
	double z;                ///< of the plane of grains in 2D, m
	ContactGeometry contact; ///< by which the grains touch

	struct Found {
		std::optional<RigidSurface<dim>> surface; ///< none: a plate off the plane
		bool refused = false;
	};

	/// The surface of a body; none where the plane misses it. Throws std::invalid_argument if
	/// grains cannot touch it.
	std::optional<RigidSurface<dim>> surfaceOf(const RigidBodyDescription& body) const;
	/// The same, where nothing may be thrown.
	Found find(const RigidBodyDescription& body) const;
	/// Surfaces of the bodies that are not refused, beside that of `id`; searches on those that
	/// are will tell. On seams those with lower ids come first.
	std::vector<SurfaceBeside<dim>>
	beside(int id, const std::vector<RigidBodyDescription>& bodies) const;
};

/// The surface and motion of a body, displaced by `shift`, for a search.
template <int dim>
void describe(RigidSide<dim>& side, const RigidSurface<dim>& surface,
	      const RigidBodyDescription& body, const Vec<dim>& shift);

/// The place of a plate nearest to `x` in the plane z = const of that, if the plate meets the
/// plane.
std::optional<Vec3> placeInPlane(const RigidBodyDescription& plate, const Vec3& x);

template <int dim> RigidPartner<dim> partnerOf(const RigidMotionDescription& d);

/// None for a contact across the plane of 2D grains, in which it does nothing; throws
/// std::invalid_argument for one that is neither in it nor across.
template <int dim> std::optional<RigidContact<dim>> contactOf(const RigidContactDescription& d);

/// The body a period further.
RigidBodyDescription displaced(RigidBodyDescription body, const Vec3& shift);

} // namespace softgrain
