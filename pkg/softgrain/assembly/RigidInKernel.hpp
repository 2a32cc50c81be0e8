// Descriptions of rigid bodies as the kernel takes them, in the dimension of the grains.
#pragma once

#include "assembly/RigidDescriptions.hpp"
#include "contact/RigidContact.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/RigidSurface.hpp"

#include <optional>
#include <string>

namespace softgrain {

/// Throws std::invalid_argument naming the body.
[[noreturn]] void refuse(const RigidBodyDescription& body, const std::string& why);

/// The surface of a rigid body as grains in the plane z see it. None where the plane misses it;
/// throws std::invalid_argument if it cannot be seen in that plane.
template <int dim>
std::optional<RigidSurface<dim>> surfaceIn(const RigidBodyDescription& body, double z);
template <> std::optional<RigidSurface<2>> surfaceIn<2>(const RigidBodyDescription& body, double z);
template <> std::optional<RigidSurface<3>> surfaceIn<3>(const RigidBodyDescription& body, double z);

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
