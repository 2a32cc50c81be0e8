// Motion of a rigid body that soft grains touch: what an impulse on it does to its velocities.
#pragma once

#include "Spin.hpp"
#include "Vector.hpp"

#include <algorithm>
#include <limits>

namespace softgrain {

/// Whatever is held (a degree of freedom, or the whole body) has an inverse mass or inertia of 0
/// there and moves as prescribed.
template <int dim> struct RigidPartner {
	Vec<dim> centre = Vec<dim>::Zero();         ///< of mass, m
	Vec<dim> velocity = Vec<dim>::Zero();       ///< at t_n + dt/2, being solved, m/s
	Spin<dim> spin = Spin<dim>::Zero();         ///< the same, 1/s
	Vec<dim> freeVelocity = Vec<dim>::Zero();   ///< the velocity without impulses, m/s
	Spin<dim> freeSpin = Spin<dim>::Zero();     ///< the same, 1/s
	Vec<dim> velocityBefore = Vec<dim>::Zero(); ///< at t_n - dt/2, m/s
	Spin<dim> spinBefore = Spin<dim>::Zero();   ///< 1/s
	Vec<dim> inverseMass = Vec<dim>::Zero();    ///< along each axis of space, 1/kg
	/// In the axes of space, 1/(kg m^2).
	Inertia<dim> inverseInertia = Inertia<dim>::Zero();

	Vec<dim> shift = Vec<dim>::Zero();  ///< out of overlaps, besides its motion, m
	Spin<dim> turn = Spin<dim>::Zero(); ///< the same, rad

	/// Whether impulses change its motion.
	bool moves() const { return !inverseMass.isZero(0) || !inverseInertia.isZero(0); }
	/// Whether it moves as it stands, impulses apart.
	bool hasVelocity() const { return !velocity.isZero(0) || !spin.isZero(0); }
	/// Of its point at `arm` from the centre.
	Vec<dim> velocityAt(const Vec<dim>& arm) const
	{
		return velocity + spinCross<dim>(spin, arm);
	}
	Vec<dim> velocityBeforeAt(const Vec<dim>& arm) const
	{
		return velocityBefore + spinCross<dim>(spinBefore, arm);
	}
	/// The velocities are those without impulses.
	void noteFree()
	{
		freeVelocity = velocity;
		freeSpin = spin;
	}
	Vec<dim> freeVelocityAt(const Vec<dim>& arm) const
	{
		return freeVelocity + spinCross<dim>(freeSpin, arm);
	}
	void push(const Vec<dim>& arm, const Vec<dim>& J)
	{
		velocity += inverseMass.cwiseProduct(J);
		spin += inverseInertia * moment<dim>(arm, J);
	}
	/// What is prescribed of a spin of the body.
	Spin<dim> heldOf(const Spin<dim>& omega) const
	{
		return (inverseInertia.diagonal().array() == 0).select(omega, 0);
	}
	Spin<dim> heldSpin() const { return heldOf(spin); }
	/// What is prescribed of the velocity of its point, where that of the body is v, omega.
	Vec<dim> heldAt(const Vec<dim>& arm, const Vec<dim>& v, const Spin<dim>& omega) const
	{
		const Vec<dim> held = (inverseMass.array() == 0).select(v, 0);
		return held + spinCross<dim>(heldOf(omega), arm);
	}
	/// Sum of mass times the product of two velocities of the body, where it is free, J.
	double massProduct(const Vec<dim>& v, const Spin<dim>& omega, const Vec<dim>& v2,
			   const Spin<dim>& omega2) const
	{
		double product = 0;
		for (int a = 0; a < dim; ++a)
			if (inverseMass[a] > 0) product += v[a] * v2[a] / inverseMass[a];
		const Spin<dim> held =
			(inverseInertia.diagonal().array() == 0).template cast<double>();
		Inertia<dim> solvable = inverseInertia;
		solvable.diagonal() += held;
		const Spin<dim> turning = omega2 - held.cwiseProduct(omega2);
		return product + omega.dot(solvable.inverse() * turning);
	}
	Vec<dim> shiftAt(const Vec<dim>& arm) const { return shift + spinCross<dim>(turn, arm); }
	bool isDisplaced() const { return !shift.isZero(0) || !turn.isZero(0); }
	/// As `push`, by an impulse times a time, kg m.
	void displace(const Vec<dim>& arm, const Vec<dim>& J)
	{
		shift += inverseMass.cwiseProduct(J);
		turn += inverseInertia * moment<dim>(arm, J);
	}
	/// Velocity of the point at `arm` by an impulse there, 1/kg: symmetric, and no multiple of
	/// the identity where the body can turn.
	Mat<dim> mobilityAt(const Vec<dim>& arm) const
	{
		Mat<dim> W;
		for (int a = 0; a < dim; ++a) {
			const Vec<dim> J = Vec<dim>::Unit(a);
			W.col(a) = inverseMass.cwiseProduct(J) +
				   spinCross<dim>(inverseInertia * moment<dim>(arm, J), arm);
		}
		return W;
	}
};

/// What is prescribed of the motion of some bodies. (A velocity that all have in common drives
/// nothing: it is that of whoever looks at them.)
template <int dim> class HeldMotion {
public:
	void add(const RigidPartner<dim>& body)
	{
		turns_ = turns_ || !body.heldSpin().isZero(0);
		for (int a = 0; a < dim; ++a)
			if (body.inverseMass[a] == 0) {
				low_[a] = std::min(low_[a], body.velocity[a]);
				high_[a] = std::max(high_[a], body.velocity[a]);
			}
	}
	/// Of a plane, m/s.
	void add(const Vec<dim>& velocity)
	{
		low_ = low_.cwiseMin(velocity);
		high_ = high_.cwiseMax(velocity);
	}
	/// Velocity of an image beyond that of its body, m/s.
	void addDrift(const Vec<dim>& drift) { turns_ = turns_ || !drift.isZero(0); }
	/// Whether they turn, flow with a cell, or move against each other.
	bool isFelt() const { return turns_ || (high_.array() > low_.array()).any(); }

private:
	Vec<dim> low_ = Vec<dim>::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
	bool turns_ = false;
};

} // namespace softgrain
