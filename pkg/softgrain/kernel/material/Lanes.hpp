// The unit of the bulk computation: the same material point of `laneWidth` congruent grains.
#pragma once

namespace softgrain {

/// Grains handled side by side, one per SIMD lane. Eight doubles fill an AVX-512 register.
constexpr int laneWidth = 8;

using Lanes = double[laneWidth];

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

} // namespace softgrain

/// Marks a function over lanes: it is compiled for several instruction sets with everything it
/// calls inlined, and the best one for the machine is picked when the program starts.
#define SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS                                                         \
	__attribute__((flatten, target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
