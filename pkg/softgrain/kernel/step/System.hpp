// The step of the whole system: a list of named phases over sets of grains and their contacts.
#pragma once

#include "contact/solve/ContactSolver.hpp"
#include "step/Activity.hpp"
#include "step/Energies.hpp"
#include "step/Grains.hpp"
#include "step/Interfaces.hpp"
#include "step/StepSettings.hpp"
#include "step/Surfaces.hpp"
#include "step/TimeSteps.hpp"

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace softgrain {

/// What goes wrong in a step. Positions and velocities are those before the step.
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

/// Work done since the end of the last step, in counts: a change can be judged by them on a busy
/// machine, where times scatter.
struct WorkCounts {
	long points = 0;     ///< material points whose stress was computed
	long pairs = 0;      ///< pairs of bodies searched for contacts
	long candidates = 0; ///< contact nodes tested against another body
	long visits = 0;     ///< of contacts by sweeps: their number, summed over the sweeps
	long lostBonds = 0;  ///< whole when searches found their contact gone, less those handed on
	long handedOnBonds = 0; ///< of contacts that went on on the next surface of a floor
};

struct StepReport {
	SolverReport solver;
	WorkCounts work;
	double deepest = 0; ///< largest overlap of the step, in dr
	double kick = 0; ///< time over which the forces at t_n acted; impulse / kick is a force, s
	int activeGrains = 0; ///< computed, not moved as rigid bodies nor asleep
	int sleepingGrains = 0;
	DroppedMotion dropped; ///< by falling asleep, and taken up by sleepers
};

/// What a run needs besides the nodal state and the impulses to go on from where another stopped.
struct Continuation {
	EnergyBalance sums;  ///< works up to half a step after t_n
	double lastStep = 0; ///< length of the last step, s; 0 before the first
	long steps = 0;      ///< so far
	double bondRate = 0; ///< largest squared frequency of bonds on their own, 1/s^2
};

/// What moves together: grains, their contacts, and the phases of a step, each of which is one
/// function here. Every other concern of the grains has a class of its own.
template <int dim> class System {
public:
	System() = default;
	System(const System&) = delete; // the parts look at the grains
	System& operator=(const System&) = delete;

	/// Adds a set; its grains get the next indices of the system.
	void add(std::unique_ptr<GrainSet<dim>> set);

	int grains() const { return grains_.count(); }
	GrainSet<dim>& setOf(int g) { return grains_.setOf(g); }
	const GrainSet<dim>& setOf(int g) const { return grains_.setOf(g); }
	int indexInSet(int g) const { return grains_.indexInSet(g); }
	bool isRigid(int g) const { return grains_.isRigid(g); }
	bool isAsleep(int g) const { return grains_.isAsleep(g); }
	const ContactBody<dim>& body(int g) const { return surfaces_.body(g); }
	std::vector<BodyLoad<dim>>& loads() { return grains_.loads(); }

	Surfaces<dim>& surfaces() { return surfaces_; }
	const Surfaces<dim>& surfaces() const { return surfaces_; }
	TimeSteps<dim>& timeSteps() { return timeSteps_; }
	const TimeSteps<dim>& timeSteps() const { return timeSteps_; }
	Activity<dim>& activity() { return activity_; }
	const Activity<dim>& activity() const { return activity_; }
	/// Smallest critical time step over the grains, undeformed, with their damping, s.
	double criticalTimeStep() const { return timeSteps_.undeformed(); }
	/// TimeSteps::present, with the bonds of the last step.
	double presentCriticalTimeStep(double enough = std::numeric_limits<double>::infinity(),
				       int threads = 1);
	/// TimeSteps::setMultirate.
	void setMultirate(bool on);

	/// Rigid bodies that take part in the contacts of the next step, with the velocities that
	/// they get without contact; the step changes them, and tells how far they are to be moved
	/// out of overlaps with each other besides.
	std::vector<RigidPartner<dim>>& rigidPartners() { return partners_; }
	/// Contacts of these with each other in the next step, in the order of the sweeps; they
	/// receive their impulses.
	std::vector<RigidContact<dim>>& rigidContacts() { return rigidContacts_; }

	const EnergyBalance& energy() const { return energies_.balance(); }
	Continuation continuation() const;
	void continueFrom(const Continuation& c);

	/// Surfaces::updateAll; the forces are those of before, and not to be used.
	void updateSurfaces(int threads);
	/// After state was set by hand; by other means than those of GrainSet only at the start,
	/// while no grain holds forces.
	void invalidateForces() { forcesFresh_ = false; }
	/// Internal forces and tangent stiffening of the present positions; throws StepError for an
	/// inverted point. `step` uses them if they are fresh.
	void updateForces(int threads);

	/// Time over which the forces of a step of dt act, s: they act from the middle of the last
	/// step to the middle of this one.
	double kickTime(double dt) const;
	/// It is no longer than this from now on, s.
	void limitKick(double longest) { longestKick_ = longest; }
	/// Time over which the impulses of the last step acted, s; 0 before the first.
	double lastKick() const { return lastKick_; }

	/// Surfaces::search; false also for a pair that sleeps.
	bool search(ContactList<dim>& list, double dt) const;

	/// Contact problem of the last step, solved.
	ContactProblem<dim> contactProblem() const { return solver_.problem(); }
	/// There is none until the next step.
	void forgetContactProblem() { solver_.forget(); }

	/// Advances all grains by dt. `lists` hold the contacts of t_n and receive their impulses;
	/// those with a rigid body name their entry of `rigidPartners`.
	StepReport step(const StepSettings& settings, std::vector<ContactList<dim>*> lists);

private:
	std::vector<char> sortLists(std::vector<ContactList<dim>*>& lists,
				    StepReport& report) const;
	void chooseInactiveGrains(std::vector<ContactList<dim>*>& lists,
				  const std::vector<char>& touched, const StepSettings& settings,
				  StepReport& report);
	void predictVelocities(const std::vector<char>& touched, const StepSettings& settings);
	void gatherContacts(int g, bool trackEnergy);
	void gatherContactsAtRest(int g, bool trackEnergy);
	void stopAtInfinite() const;
	void checkImpulses(const SolverReport& solved, const std::vector<char>& touched);
	void move(const std::vector<ContactList<dim>*>& lists, const std::vector<char>& touched,
		  const StepSettings& settings, StepReport& report);
	void balanceEnergy(const StepSettings& settings, const StepReport& report);
	ContactWork workOfContacts();
	void endStep(double dt, double kick);

	Grains<dim> grains_;
	Surfaces<dim> surfaces_ { grains_ };
	TimeSteps<dim> timeSteps_ { grains_ };
	Activity<dim> activity_ { grains_, surfaces_ };
	Interfaces<dim> interfaces_;
	Energies<dim> energies_ { grains_ };
	ContactSolver<dim> solver_;
	std::vector<RigidPartner<dim>> partners_; ///< of the step at hand
	std::vector<RigidContact<dim>> rigidContacts_;
	std::vector<ContactList<dim>*> sleeping_; ///< left out of the step at hand
	std::vector<char> finite_;                ///< by grain, of the step at hand
	long steps_ = 0;
	double lastStep_ = 0, lastKick_ = 0;                           ///< s
	double longestKick_ = std::numeric_limits<double>::infinity(); ///< s
	bool forcesFresh_ = false;
	long updatedPoints_ = 0; ///< since the end of the last step
};

} // namespace softgrain
