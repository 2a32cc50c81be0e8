// What sg.harden() needs of the scene beyond what Python can reach.
#pragma once

#include "Yade.hpp"

namespace yade {

/// Outline of the soft grain of a body where its State has it now, also if that was changed since
/// the last step, array (n, 3), m. Throws std::invalid_argument for another body.
boost::python::object presentOutline(int id);

/// Gives a clump the centre of mass, mass, inertia (about the centre, axes of space), velocity and
/// angular momentum (about the centre) of a body that it is to stand for. Its members stay where
/// they are. Throws std::invalid_argument for another body.
void becomeClump(int id, const Vector3r& centre, Real mass, const Matrix3r& inertia,
		 const Vector3r& velocity, const Vector3r& angularMomentum);

} // namespace yade
