// What laws compute with.
#pragma once

#include "lanes/Parts.hpp"

namespace softgrain {

/// Kinematics in, response out, of one material point in every lane of a part.
template <int dim, class Part = WholeLanes> struct PointLanes {
	using Numbers = typename Part::Numbers;
	Numbers F[dim][dim]; ///< deformation gradient
	Numbers P[dim][dim]; ///< first Piola-Kirchhoff stress, Pa
	Numbers J;           ///< det of F (in 2D of its in-plane part)
	Numbers energy;      ///< strain energy per reference volume, Pa
	/// (Largest tangent modulus of acceleration waves over that of the undeformed material);
	/// the critical time step falls with its square root.
	Numbers stiffening;
};

/// What closes the third dimension of a grain of the plane, in every lane.
struct OutOfPlane {
	Lanes stretch = Lanes {} + 1; ///< F33
	Lanes stress = {};            ///< Cauchy stress sigma33, Pa
};

} // namespace softgrain
