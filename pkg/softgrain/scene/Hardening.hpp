// What sg.harden() needs of the scene beyond what Python can reach.
#pragma once

#include "Yade.hpp"

namespace yade {

/// Gives a clump the centre of mass, mass, inertia (about the centre, axes of space), velocity and
/// angular momentum (about the centre) of a body that it is to stand for. Its members stay where
/// they are. Throws std::invalid_argument for another body.
void becomeClump(int id, const Vector3r& centre, Real mass, const Matrix3r& inertia,
		 const Vector3r& velocity, const Vector3r& angularMomentum);

} // namespace yade
