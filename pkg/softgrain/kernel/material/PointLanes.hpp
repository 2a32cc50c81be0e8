// What laws compute with.
#pragma once

#include "lanes/Lanes.hpp"

namespace softgrain {

/// Kinematics in, response out, of one material point in every lane.
template <int dim> struct PointLanes {
	Lanes F[dim][dim]; ///< deformation gradient
	Lanes P[dim][dim]; ///< first Piola-Kirchhoff stress, Pa
	Lanes J;           ///< det of F (in 2D of its in-plane part)
	Lanes energy;      ///< strain energy per reference volume, Pa
	/// (Largest tangent modulus of acceleration waves over that of the undeformed material);
	/// the critical time step falls with its square root.
	Lanes stiffening;
};

/// What closes the third dimension of a grain of the plane, in every lane.
struct OutOfPlane {
	Lanes stretch = Lanes {} + 1; ///< F33
	Lanes stress = {};            ///< Cauchy stress sigma33, Pa
};

} // namespace softgrain
