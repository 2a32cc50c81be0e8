// The grain as a whole: what a rigid body would show.
#pragma once

#include "Spin.hpp"
#include "grain/Batch.hpp"

#include <Eigen/Dense>

namespace softgrain {

/// Velocities of a rigid motion.
template <int dim> struct RigidVelocities {
	Vec<dim> velocity = Vec<dim>::Zero(); ///< at `centre`, m/s
	Mat<dim> spin = Mat<dim>::Zero();     ///< skew, 1/s
	Vec<dim> centre = Vec<dim>::Zero();   ///< m

	Vec<dim> at(const Vec<dim>& x) const { return velocity + spin * (x - centre); }
};

/// Momenta and mean motion of one grain.
template <int dim> struct WholeGrain {
	double mass = 0;                      ///< kg (2D: kg/m)
	Vec<dim> centre = Vec<dim>::Zero();   ///< centre of mass relative to the grain's origin, m
	Vec<dim> velocity = Vec<dim>::Zero(); ///< of the centre of mass, m/s
	Spin<dim> angularMomentum = Spin<dim>::Zero(); ///< about the centre of mass
	Inertia<dim> inertia = Inertia<dim>::Zero();   ///< present
	Spin<dim> angularVelocity = Spin<dim>::Zero(); ///< inertia^-1 angularMomentum, 1/s
	Mat<dim> rotation = Mat<dim>::Identity(); ///< mean rotation: nearest to the motion X -> x

	/// Of a rigid body with these momenta.
	RigidVelocities<dim> rigidVelocities() const;
};

/// A part of a grain with mass: background node or material point.
template <int dim> struct Particle {
	double mass;   ///< kg
	Vec<dim> x, v; ///< relative to the grain's origin, m; m/s
	Vec<dim> X;    ///< in the reference configuration, any unit
};

/// Of `count` particles, `particle(i)` being the i-th.
template <int dim, class ParticleAt> WholeGrain<dim> wholeOf(int count, ParticleAt&& particle);

/// Of the background nodes of grain `g`.
template <int dim> WholeGrain<dim> wholeGrain(const Batch<dim>& batch, int g);
template <> WholeGrain<2> wholeGrain(const Batch<2>& batch, int g);
template <> WholeGrain<3> wholeGrain(const Batch<3>& batch, int g);

/// Kinetic energy 1/2 sum_I mI v_I . w_I, J (2D: J/m). With v and w the velocities half a step
/// before and after t_n it is, with the elastic energy at t_n, the exact invariant of the linear
/// scheme.
template <int dim>
double kineticEnergy(const Batch<dim>& batch, const NodalField<dim>& v, const NodalField<dim>& w,
		     int g);

/// sum_I mI v_I, N s (2D: N s/m).
template <int dim> Vec<dim> momentum(const Batch<dim>& batch, const NodalField<dim>& v, int g);

/// Whether all components at the nodes of grain `g` are finite.
template <int dim> bool isFinite(const NodalField<dim>& field, int g, int nodes);

// --- implementation -----------------------------------------------------------------------------

template <int dim> RigidVelocities<dim> WholeGrain<dim>::rigidVelocities() const
{
	return { velocity, spinMatrix<dim>(angularVelocity), centre };
}

namespace detail {

inline Spin<2> pointInertia(const Vec<2>& r) { return Spin<2>(r.squaredNorm()); }
inline Mat<3> pointInertia(const Vec<3>& r)
{
	return r.squaredNorm() * Mat<3>::Identity() - r * r.transpose();
}

/// Rotation nearest to A in the sense of the polar decomposition.
template <int dim> Mat<dim> nearestRotation(const Mat<dim>& A);
template <> Mat<2> nearestRotation(const Mat<2>& A);
template <> Mat<3> nearestRotation(const Mat<3>& A);

} // namespace detail

template <int dim, class ParticleAt> WholeGrain<dim> wholeOf(int count, ParticleAt&& particle)
{
	WholeGrain<dim> whole;
	for (int i = 0; i < count; ++i) {
		const Particle<dim> p = particle(i);
		whole.mass += p.mass;
		whole.centre += p.mass * p.x;
		whole.velocity += p.mass * p.v;
	}
	whole.centre /= whole.mass;
	whole.velocity /= whole.mass;
	Mat<dim> motion = Mat<dim>::Zero();
	for (int i = 0; i < count; ++i) {
		const Particle<dim> p = particle(i);
		const Vec<dim> r = p.x - whole.centre;
		whole.angularMomentum += p.mass * moment<dim>(r, p.v - whole.velocity);
		whole.inertia += p.mass * detail::pointInertia(r);
		motion += p.mass * r * p.X.transpose();
	}
	whole.angularVelocity = whole.inertia.inverse() * whole.angularMomentum;
	whole.rotation = detail::nearestRotation<dim>(motion);
	return whole;
}

} // namespace softgrain
