// How a step is to be made.
#pragma once

#include "contact/solve/SolverSettings.hpp"
#include "step/PhaseClock.hpp"

#include <functional>

namespace softgrain {

struct StepSettings {
	double dt = 0; ///< s
	SolverSettings solver;
	bool trackEnergy = false;
	bool trackRigidBodies = false; ///< the balance of all rigidPartners too
	bool rigidMotion = true;       ///< undeformed grains without contact move as rigid bodies
	bool sleep = true;             ///< damped grains that came to rest are left alone
	int threads = 1;
	PhaseClock* clock = nullptr; ///< gets the times of the phases
	/// Called with each grain that has been moved, by the thread that moved it and has all of
	/// it in its caches; must throw nothing.
	std::function<void(int)> moved = [](int) {};
};

} // namespace softgrain
