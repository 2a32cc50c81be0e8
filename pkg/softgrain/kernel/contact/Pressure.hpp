// Contact pressure and shear traction from the impulses of contact dynamics.
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactBody.hpp"
#include "contact/Interface.hpp"

#include <Eigen/Core>

#include <vector>

namespace softgrain {

/// Traction at a contact node and the area it stands for.
struct ContactPressure {
	double area = 0;     ///< share of the node in the outline, along the normal, m (3D: m^2)
	double pressure = 0; ///< Pa, > 0 for compression
	Eigen::Vector3d shear = Eigen::Vector3d::Zero(); ///< tangential traction, Pa
};

/// For each contact of a pair, the traction on the grain that owns the node, at the node.
///
/// Forces on single nodes are no measure of it: there are more contact nodes than background nodes
/// at a boundary, so patterns of forces exist that no background node feels, and the solver leaves
/// any of them. What the grain feels of forces f_s, on nodes and as the partner of the other
/// grain's nodes, are sum_s N_I(X_s) f_s. Hence, with the outward area vectors a_s of the nodes,
///
///     p_s = - n . sum_s' K_ss' f_s' / n . sum_s' K_ss' a_s',    K_ss' = sum_I N_I(X_s) N_I(X_s'),
///
/// n = - (normal of the contact) the outward direction: an average over about a grid step h. The
/// shear traction is the rest of sum K f over the same area.
///
/// `kick`: time over which the impulses acted, s. Needs a surface (facets); else all are zero.
template <int dim>
std::vector<ContactPressure>
contactPressures(const ContactBody<dim>& first, const ContactBody<dim>* second,
		 const std::vector<Contact<dim>>& contacts, double kick);

/// What each contact of a pair stands for: the share of its node in the outline, its area along the
/// normal of the contact, half of it if the nodes of both bodies are contacts, and the spread of
/// the gap by the slope of the outline (at a sharp node none). Ends of a rigid body stand for
/// nothing.
template <int dim>
std::vector<ContactArea> contactAreas(const ContactBody<dim>& first, const ContactBody<dim>* second,
				      const std::vector<Contact<dim>>& contacts);

} // namespace softgrain
