// Motion of an undeformed grain as a rigid body (doc/decisions/0014-inactive-grains.md). With c the
// centre of mass, R the rotation, V its velocity, l the angular momentum over the mass, all times
// as those of the nodes (positions at t_n, velocities at t_n - dt/2):
//     V+ = V + kick a,    l+ = l + kick I(R) alpha,    I(R) = R I_0 R^T
//     c <- c + dt V+,     R <- exp(dt omega) R,        omega = I(R')^-1 l+
// for the body load a + alpha x r, with R' the rotation half a step later. Momentum and angular
// momentum are the variables, so both are kept to rounding; a nodal step turns nodes along the
// tangent instead, which differs in second order of omega dt.
#pragma once

#include "grain/Observables.hpp"

namespace softgrain {

/// What the rigid motion needs to know of a grain: about its centre of mass, undeformed.
template <int dim> struct RigidShape {
	double mass = 0;                    ///< kg (2D: kg/m)
	Vec<dim> centre = Vec<dim>::Zero(); ///< of mass, in the reference configuration, m
	Inertia<dim> inertia = Inertia<dim>::Identity(); ///< over the mass, I_0, m^2
};

template <int dim> struct RigidMotion {
	Vec<dim> centre = Vec<dim>::Zero(); ///< of mass, relative to the grain's origin, m
	Mat<dim> rotation = Mat<dim>::Identity();
	Vec<dim> velocity = Vec<dim>::Zero();
	Spin<dim> momentum = Spin<dim>::Zero();     ///< about the centre, over the mass, m^2/s
	Vec<dim> velocityNext = Vec<dim>::Zero();   ///< V+, being computed
	Spin<dim> momentumNext = Spin<dim>::Zero(); ///< l+

	Spin<dim> angularVelocity(const RigidShape<dim>& shape) const;
	/// Place of the particle X of the reference configuration, and the velocity that a place
	/// has by V and omega.
	Vec<dim> positionOf(const Vec<dim>& X, const RigidShape<dim>& shape) const
	{
		return centre + rotation * (X - shape.centre);
	}
	WholeGrain<dim> whole(const RigidShape<dim>& shape) const;
	/// Half of sum m v . w with v and w the velocities half a step before and after t_n, J.
	double kineticEnergy(const RigidShape<dim>& shape) const;

	/// Of a body load over the mass at a velocity and angular momentum (over the mass), W/kg.
	double power(const Vec<dim>& speed, const Spin<dim>& spinMomentum,
		     const Vec<dim>& acceleration, const Mat<dim>& angular) const;

	void accelerate(double kick, const Vec<dim>& acceleration, const Mat<dim>& angular,
			const RigidShape<dim>& shape);
	bool hasFiniteVelocities() const
	{
		return velocityNext.allFinite() && momentumNext.allFinite();
	}
	void move(double dt, const RigidShape<dim>& shape);
	/// Adds a motion as GrainSet::moveRigidly does.
	void add(const Mat<dim>& turn, const Vec<dim>& shift, const Vec<dim>& speed,
		 const Mat<dim>& spin, const RigidShape<dim>& shape);

	/// The state as numbers, for saving.
	std::vector<double> numbers() const;
	static constexpr int numberCount = dim + dim * dim + dim + spins<dim>;
	static RigidMotion fromNumbers(const std::vector<double>& numbers);
};

/// The motion of a grain that is undeformed, from its mean motion.
template <int dim> RigidMotion<dim> rigidMotionOf(const WholeGrain<dim>& whole);

} // namespace softgrain
