#include "grain/RigidMotion.hpp"
#include "Numbers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

Mat<2> turnBy(const Spin<2>& angle)
{
	const double c = std::cos(angle[0]), s = std::sin(angle[0]);
	return (Mat<2>() << c, -s, s, c).finished();
}

Mat<3> turnBy(const Vec<3>& angle)
{
	const double size = angle.norm();
	if (size == 0) return Mat<3>::Identity();
	return Eigen::AngleAxisd(size, angle / size).toRotationMatrix();
}

/// Vector of a skew matrix: the inverse of spinMatrix.
Spin<2> axisOf(const Mat<2>& spin) { return Spin<2>(spin(1, 0)); }
Vec<3> axisOf(const Mat<3>& spin) { return { spin(2, 1), spin(0, 2), spin(1, 0) }; }

Inertia<2> rotatedInertia(const Inertia<2>& inertia, const Mat<2>&) { return inertia; }
Inertia<3> rotatedInertia(const Inertia<3>& inertia, const Mat<3>& R)
{
	return R * inertia * R.transpose();
}

Spin<2> rotatedAxis(const Mat<2>&, const Spin<2>& axis) { return axis; }
Spin<3> rotatedAxis(const Mat<3>& R, const Spin<3>& axis) { return R * axis; }

/// Keeps rounding from adding up to a strain: one step of Newton's method towards R^T R = 1.
template <int dim> Mat<dim> orthonormal(const Mat<dim>& R)
{
	return R * (1.5 * Mat<dim>::Identity() - 0.5 * R.transpose() * R);
}

template <int dim>
Spin<dim> rateOf(const Spin<dim>& momentum, const Mat<dim>& rotation, const RigidShape<dim>& shape)
{
	return rotatedInertia(shape.inertia, rotation).inverse() * momentum;
}

} // namespace

template <int dim> Spin<dim> RigidMotion<dim>::angularVelocity(const RigidShape<dim>& shape) const
{
	return rateOf<dim>(momentum, rotation, shape);
}

template <int dim> WholeGrain<dim> RigidMotion<dim>::whole(const RigidShape<dim>& shape) const
{
	WholeGrain<dim> w;
	w.mass = shape.mass;
	w.centre = centre;
	w.velocity = velocity;
	w.angularMomentum = shape.mass * momentum;
	w.inertia = shape.mass * rotatedInertia(shape.inertia, rotation);
	w.angularVelocity = angularVelocity(shape);
	w.rotation = rotation;
	return w;
}

template <int dim> double RigidMotion<dim>::kineticEnergy(const RigidShape<dim>& shape) const
{
	return 0.5 * shape.mass *
	       (velocity.dot(velocityNext) + angularVelocity(shape).dot(momentumNext));
}

template <int dim>
double RigidMotion<dim>::power(const Vec<dim>& speed, const Spin<dim>& spinMomentum,
			       const Vec<dim>& acceleration, const Mat<dim>& angular) const
{
	return acceleration.dot(speed) + axisOf(angular).dot(spinMomentum);
}

template <int dim>
void RigidMotion<dim>::accelerate(double kick, const Vec<dim>& acceleration,
				  const Mat<dim>& angular, const RigidShape<dim>& shape)
{
	velocityNext = velocity + kick * acceleration;
	momentumNext = momentum;
	if (!angular.isZero(0))
		momentumNext += kick * (rotatedInertia(shape.inertia, rotation) * axisOf(angular));
}

template <int dim> void RigidMotion<dim>::move(double dt, const RigidShape<dim>& shape)
{
	velocity = velocityNext;
	momentum = momentumNext;
	centre += dt * velocity;
	Spin<dim> rate = angularVelocity(shape);
	if (dt * dt * rate.squaredNorm() < 1e-32) return; // R would stay as it is, rounded
	if (dim == 3)
		for (int k = 0; k < 3; ++k) // each leaves an error smaller by omega dt
			rate = rateOf<dim>(momentum, turnBy(Spin<dim>(0.5 * dt * rate)) * rotation,
					   shape);
	rotation = orthonormal<dim>(turnBy(Spin<dim>(dt * rate)) * rotation);
}

template <int dim>
void RigidMotion<dim>::add(const Mat<dim>& turn, const Vec<dim>& shift, const Vec<dim>& speed,
			   const Mat<dim>& spin, const RigidShape<dim>& shape)
{
	centre += shift;
	rotation = orthonormal<dim>(turn * rotation);
	velocity = turn * velocity + speed;
	momentum = rotatedAxis(turn, momentum) +
		   rotatedInertia(shape.inertia, rotation) * axisOf(spin);
}

template <int dim> std::vector<double> RigidMotion<dim>::numbers() const
{
	return numbersOf(centre, rotation, velocity, momentum);
}

template <int dim>
RigidMotion<dim> RigidMotion<dim>::fromNumbers(const std::vector<double>& numbers)
{
	RigidMotion motion;
	NumbersInTurn(numbers).take(motion.centre, motion.rotation, motion.velocity,
				    motion.momentum);
	return motion;
}

template <int dim> RigidMotion<dim> rigidMotionOf(const WholeGrain<dim>& whole)
{
	RigidMotion<dim> motion;
	motion.centre = whole.centre;
	motion.rotation = whole.rotation;
	motion.velocity = whole.velocity;
	motion.momentum = whole.angularMomentum / whole.mass;
	return motion;
}

template struct RigidMotion<2>;
template struct RigidMotion<3>;
template RigidMotion<2> rigidMotionOf<2>(const WholeGrain<2>&);
template RigidMotion<3> rigidMotionOf<3>(const WholeGrain<3>&);

} // namespace softgrain
