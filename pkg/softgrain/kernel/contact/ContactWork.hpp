// What contacts did to the energy in a step.
#pragma once

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
	Halves planes;   ///< done by moving planes and rigid bodies on the grains
	Halves cell;     ///< done on the grains by the motion of their images
	Halves cohesion; ///< taken by the tractions of interfaces (given back where they close)

	ContactWork& operator+=(const ContactWork& other)
	{
		impact += other.impact;
		friction += other.friction;
		planes += other.planes;
		cell += other.cell;
		cohesion += other.cohesion;
		return *this;
	}
};

} // namespace softgrain
