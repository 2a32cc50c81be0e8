// Interface laws in the step: what they need before the solve, and what their bonds ask of the time
// step.
#pragma once

#include "contact/ContactBody.hpp"
#include "contact/ContactList.hpp"
#include "contact/RigidPartner.hpp"

#include <vector>

namespace softgrain {

template <int dim> class Interfaces {
public:
	/// Before velocities are predicted.
	void begin(const std::vector<ContactList<dim>*>& lists, double kick, double dt);
	/// Whether a pair of the step at hand has a restitution.
	bool rebound() const { return rebound_; }
	/// Bonds asleep count as when they fell asleep: `lists` with the pairs of sleepers.
	void noteSleepers(const std::vector<ContactList<dim>*>& lists);
	/// The rate of bonds between grains of which the solve knows mobilities, and rigid bodies.
	void measureBonds(const std::vector<ContactList<dim>*>& lists,
			  const std::vector<ContactBody<dim>>& bodies,
			  const std::vector<RigidPartner<dim>>& partners);
	/// Largest squared frequency of bonds on their own, 1/s^2.
	double bondRate() const { return bondRate_; }
	void continueFrom(double bondRate) { bondRate_ = bondRate; }

private:
	bool rebound_ = false;
	bool bondsAsleep_ = false;
	double bondRate_ = 0;
};

} // namespace softgrain
