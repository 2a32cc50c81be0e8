// The step of the whole system: a list of named phases over sets of grains and their contacts.
#pragma once

#include "contact/ContactSolver.hpp"
#include "contact/Search.hpp"
#include "grain/GrainSet.hpp"
#include "step/PhaseClock.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace softgrain {

/// What goes wrong in a step. The state is that before the step.
struct StepError : std::runtime_error {
	StepError(int whichGrain, int whichPoint, const std::string& what)
		: std::runtime_error(what)
		, grain(whichGrain)
		, point(whichPoint)
	{
	}
	int grain; ///< index in the system
	int point; ///< material point, or -1
};

/// Energies at t_n, J (2D: J/m). kinetic + elastic = initial + work - friction - impact up to
/// rounding and the second-order error of the time integration.
struct EnergyBalance {
	double kinetic = 0; ///< 1/2 sum mI v(t_n - dt/2) . v(t_n + dt/2)
	double elastic = 0;
	double friction = 0; ///< dissipated by friction since the start
	double impact = 0;   ///< dissipated by normal impulses since the start
	double planes = 0;   ///< work of moving planes on the grains since the start
	double loads = 0;    ///< work of body loads since the start
};

/// Work done since the end of the last step, in counts: a change can be judged by them on a busy
/// machine, where times scatter.
struct WorkCounts {
	long points = 0;     ///< material points whose stress was computed
	long pairs = 0;      ///< pairs of bodies searched for contacts
	long candidates = 0; ///< contact nodes tested against another body
	long visits = 0;     ///< of contacts by sweeps: their number, summed over the sweeps
};

struct StepReport {
	SolverReport solver;
	WorkCounts work;
	double deepest = 0;    ///< largest overlap of the step, in dr
	double stiffening = 1; ///< largest over all grains
	double kick = 0; ///< time over which the forces at t_n acted; impulse / kick is a force, s
};

struct StepSettings {
	double dt = 0; ///< s
	SolverSettings solver;
	bool trackEnergy = false;
	int threads = 1;
	PhaseClock* clock = nullptr; ///< gets the times of the phases
};

/// What a run needs besides the nodal state and the impulses to go on from where another stopped.
struct Continuation {
	EnergyBalance sums;  ///< works up to half a step after t_n
	double lastStep = 0; ///< length of the last step, s; 0 before the first
};

template <int dim> class System {
public:
	/// Adds a set; its grains get the next indices of the system.
	void add(std::unique_ptr<GrainSet<dim>> set);

	int grains() const { return static_cast<int>(place_.size()); }
	GrainSet<dim>& setOf(int g) { return *sets_[place_[g].set]; }
	const GrainSet<dim>& setOf(int g) const { return *sets_[place_[g].set]; }
	int indexInSet(int g) const { return place_[g].index; }
	const ContactBody<dim>& body(int g) const { return bodies_[g]; }
	std::vector<BodyLoad<dim>>& loads() { return loads_; }
	const EnergyBalance& energy() const { return energy_; }
	const Continuation& continuation() const { return continuation_; }
	void continueFrom(const Continuation& c)
	{
		continuation_ = c;
		energy_ = c.sums;
	}
	/// Smallest undeformed critical time step over the grains, s.
	double criticalTimeStep() const;

	/// Renews contact-node positions and outlines from the state. Called by `step` at its end;
	/// call it after setting state by hand.
	void updateSurfaces(int threads);
	void updateSurface(int g);
	void invalidateForces() { forcesFresh_ = false; } ///< after state was set by hand
	/// Internal forces and tangent stiffening of the present positions; throws StepError for an
	/// inverted point. `step` uses them if they are fresh.
	void updateForces(int threads);
	double stiffening() const;

	/// Time over which the impulses of the last step acted, s; 0 before the first.
	double lastKick() const { return lastKick_; }

	/// Distance within which gaps must be handed to `step`: no node travels further in a step.
	double reach(int first, int second, double dt) const;
	double reach(int g, const Plane<dim>& plane, double dt) const;

	/// Contact problem of the last step, solved.
	ContactProblem<dim> contactProblem() const { return solver_.problem(); }

	/// Advances all grains by dt. `lists` hold the contacts of t_n and receive their impulses.
	StepReport step(const StepSettings& settings, std::vector<ContactList<dim>*> lists);

private:
	struct Place {
		int set, index;
	};
	/// phase(grain in the system, its set, its index there)
	template <class Phase> void forEachGrain(int threads, Phase&& phase);

	double renewOutline(int g);
	double kickTime(double dt) const;
	void updateGridNodes(int g);
	void useGridNodes(const std::vector<ContactList<dim>*>& lists);
	void predictVelocities(const StepSettings& settings);
	void gatherContacts(const std::vector<char>& touched, const StepSettings& settings);
	void applyContactImpulses(const std::vector<char>& touched, const StepSettings& settings);
	void checkVelocities() const;
	void balanceEnergy(const ContactWork& work, double kick);

	std::vector<std::unique_ptr<GrainSet<dim>>> sets_;
	std::vector<Place> place_;
	std::vector<ContactBody<dim>> bodies_;
	std::vector<std::vector<Vec<dim>>> lastPosition_; ///< of the contact nodes, m
	std::vector<BodyLoad<dim>> loads_;
	ContactSolver<dim> solver_;
	EnergyBalance energy_; ///< at the last t_n
	Continuation continuation_;
	double lastKick_ = 0;
	double gridSpacing_ = 0; ///< ContactGeometry::nodes: the largest h of all grains, m
	bool forcesFresh_ = false;
	long updatedPoints_ = 0; ///< since the end of the last step
};

} // namespace softgrain
