// What contacts did to the energy in a step.
#pragma once

#include "Vector.hpp"

namespace softgrain {

/// Work of the contact impulses of one step, J (2D: J/m), split into the halves done at the
/// velocities before and after the impulse; their sum is exact for the kinetic energy.
struct ContactWork {
	struct Halves {
		double before = 0, after = 0;

		Halves& operator+=(const Halves& other)
		{
			before += other.before;
			after += other.after;
			return *this;
		}
	};
	Halves impact;   ///< lost by normal impulses (gained where an overlap is pushed out)
	Halves friction; ///< lost by friction
	Halves walls;    ///< done by moving planes and rigid bodies on the grains
	Halves cell;     ///< done on the grains by the motion of their images
	Halves cohesion; ///< taken by the tractions of interfaces (given back where they close)

	/// One half of the impact and the friction of a reaction r at a contact with this normal
	/// (unit, towards the body that r acts on) and relative velocity.
	template <int dim>
	void addReaction(double Halves::* half, const Vec<dim>& r, const Vec<dim>& normal,
			 const Vec<dim>& relative)
	{
		const Vec<dim> along = r.dot(normal) * normal;
		impact.*half -= 0.5 * along.dot(relative);
		friction.*half -= 0.5 * (r - along).dot(relative);
	}
	ContactWork& operator+=(const ContactWork& other)
	{
		impact += other.impact;
		friction += other.friction;
		walls += other.walls;
		cell += other.cell;
		cohesion += other.cohesion;
		return *this;
	}
};

} // namespace softgrain
