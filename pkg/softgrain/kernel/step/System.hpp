// The step of the whole system: a list of named phases over sets of grains and their contacts.
#pragma once

#include "Threads.hpp"
#include "contact/ContactSolver.hpp"
#include "contact/Search.hpp"
#include "grain/GrainSet.hpp"
#include "step/Islands.hpp"
#include "step/PhaseClock.hpp"

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
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

/// Energies at t_n of rigid bodies as far as they are free, and of their contacts with each other,
/// J. kinetic = initial + walls + cell + loads - friction - impact, less what they did on grains
/// (EnergyBalance::planes).
struct RigidBalance {
	double kinetic = 0; ///< as EnergyBalance::kinetic
	double friction = 0, impact = 0;
	double walls = 0; ///< work of bodies (degrees of freedom) that move as prescribed
	double cell = 0;  ///< work of moving images
	double loads = 0; ///< work of all that acts on them besides contact dynamics
};

/// Energies at t_n, J (2D: J/m). kinetic + elastic = initial + work - friction - impact - damping
/// - sleep - cohesion up to rounding and the second-order error of the time integration.
struct EnergyBalance {
	double kinetic = 0; ///< 1/2 sum mI v(t_n - dt/2) . v(t_n + dt/2)
	double elastic = 0;
	double friction = 0; ///< dissipated by friction since the start
	double impact = 0;   ///< dissipated by normal impulses since the start
	double planes = 0; ///< work of moving planes and rigid bodies on the grains since the start
	double cell = 0;   ///< work of moving images on the grains since the start
	double loads = 0;  ///< work of body loads since the start
	double damping = 0;  ///< dissipated by damping since the start
	double sleep = 0;    ///< taken away by grains falling asleep since the start
	double cohesion = 0; ///< taken by the tractions of interfaces since the start
	RigidBalance rigid;  ///< as far as StepSettings::trackRigidBodies was on
};

/// Work done since the end of the last step, in counts: a change can be judged by them on a busy
/// machine, where times scatter.
struct WorkCounts {
	long points = 0;     ///< material points whose stress was computed
	long pairs = 0;      ///< pairs of bodies searched for contacts
	long candidates = 0; ///< contact nodes tested against another body
	long visits = 0;     ///< of contacts by sweeps: their number, summed over the sweeps
	long lostBonds = 0;  ///< whole when searches found their contact gone
};

struct StepReport {
	SolverReport solver;
	WorkCounts work;
	double deepest = 0; ///< largest overlap of the step, in dr
	double kick = 0; ///< time over which the forces at t_n acted; impulse / kick is a force, s
	int activeGrains = 0; ///< computed, not moved as rigid bodies nor asleep
	int sleepingGrains = 0;
	double droppedMomentum = 0; ///< sum over the grains that fell asleep, N s
	double droppedEnergy = 0;   ///< the kinetic energy they had, J
};

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

/// What a run needs besides the nodal state and the impulses to go on from where another stopped.
struct Continuation {
	EnergyBalance sums;  ///< works up to half a step after t_n
	double lastStep = 0; ///< length of the last step, s; 0 before the first
	long steps = 0;      ///< so far
	double bondRate = 0; ///< largest squared frequency of bonds on their own, 1/s^2
};

/// Whether a surface follows the state; it is renewed when it is asked for. Whoever asks first
/// renews it, others who ask meanwhile wait.
class Freshness {
public:
	Freshness() = default;
	Freshness(const Freshness& other) { *this = other; }
	Freshness& operator=(const Freshness& other)
	{
		state_.store(other.state_.load());
		return *this;
	}
	bool isFresh() const { return state_.load(std::memory_order_acquire) == fresh; }
	void expire() { state_.store(stale, std::memory_order_relaxed); }
	template <class Renew> void renew(Renew&& renewNow);

private:
	enum State : int { stale, busy, fresh };
	std::atomic<int> state_ { stale };
};

template <int dim> class System {
public:
	/// Adds a set; its grains get the next indices of the system.
	void add(std::unique_ptr<GrainSet<dim>> set);

	int grains() const { return static_cast<int>(place_.size()); }
	GrainSet<dim>& setOf(int g) { return *sets_[place_[g].set]; }
	const GrainSet<dim>& setOf(int g) const { return *sets_[place_[g].set]; }
	int indexInSet(int g) const { return place_[g].index; }
	/// With its surface as the state is. May be asked by several threads at a time.
	const ContactBody<dim>& body(int g) const
	{
		if (!surface_[g].isFresh()) renewSurface(g);
		return bodies_[g];
	}
	bool isRigid(int g) const { return setOf(g).isRigid(indexInSet(g)); }
	bool isAsleep(int g) const { return setOf(g).isAsleep(indexInSet(g)); }
	std::vector<BodyLoad<dim>>& loads() { return loads_; }
	/// Rigid bodies that take part in the contacts of the next step, with the velocities that
	/// they get without contact; the step changes them, and tells how far they are to be moved
	/// out of overlaps with each other besides.
	std::vector<RigidPartner<dim>>& rigidPartners() { return partners_; }
	/// Contacts of these with each other in the next step, in the order of the sweeps; they
	/// receive their impulses.
	std::vector<RigidContact<dim>>& rigidContacts() { return rigidContacts_; }
	/// Wakes a sleeping grain if the load is another.
	void setLoad(int g, const BodyLoad<dim>& load);
	/// The same for all grains; so many threads share the calls of `loadOf(g)`, which must
	/// throw nothing.
	template <class LoadOf> void setLoads(LoadOf&& loadOf, int threads);
	/// A grain about which something was changed by hand; the grains that it rests with follow
	/// in the next step.
	void wake(int g);
	/// What a sleeping grain is saved with besides its state: the load under which it sleeps
	/// and the number of its pairs in contact. Empty if it is awake.
	std::vector<double> sleepNumbers(int g) const;
	void restoreSleep(int g, const std::vector<double>& numbers);
	const EnergyBalance& energy() const { return energy_; }
	const Continuation& continuation() const { return continuation_; }
	void continueFrom(const Continuation& c)
	{
		continuation_ = c;
		energy_ = c.sums;
	}
	/// Smallest critical time step over the grains, undeformed, with their damping, s.
	double criticalTimeStep() const { return undeformedTimeStep_; }
	/// The same as deformed now, and with the bonds between grains; after `updateForces`.
	/// Grains that would make it shorter than `enough` are measured: what is longer than that
	/// may be too short.
	double presentCriticalTimeStep(double enough = std::numeric_limits<double>::infinity(),
				       int threads = 1);
	/// Material points whose stress was computed for that since this was asked for last.
	long takeMeasuredPoints() { return std::exchange(measuredPoints_, 0); }

	/// Whether forces of grains with a longer critical step are computed in every so many steps
	/// only: as often as fits into their own undeformed critical step. To be called after all
	/// sets were added.
	void setMultirate(bool on);
	/// Steps from one computation of the forces of a grain to the next.
	int rate(int g) const { return rate_[g]; }

	/// Renews contact-node positions and outlines from the state; those of grains that move
	/// rigidly when somebody asks. Called by `step` at its end; call it after setting state by
	/// hand.
	void updateSurfaces(int threads);
	void updateSurface(int g);
	/// After state was set by hand; by other means than those of GrainSet only at the start,
	/// while no grain holds forces.
	void invalidateForces() { forcesFresh_ = false; }
	/// Internal forces and tangent stiffening of the present positions; throws StepError for an
	/// inverted point. `step` uses them if they are fresh.
	void updateForces(int threads);

	/// Time over which the forces of a step of dt act, s: they act from the middle of the last
	/// step to the middle of this one.
	double kickTime(double dt) const;
	/// Time over which the impulses of the last step acted, s; 0 before the first.
	double lastKick() const { return lastKick_; }

	/// Distance within which gaps must be handed to `step`: none closes by more in a step.
	double reach(int first, int second, const PairImage<dim>& image, double dt) const;
	/// Tractions of interfaces act across gaps up to this, m; adds to every reach.
	void setInterfaceRange(double range) { interfaceRange_ = range; }
	double interfaceRange() const { return interfaceRange_; }
	double reach(int g, const Plane<dim>& plane, double dt) const;
	double reach(int g, const RigidSide<dim>& rigid, const PairImage<dim>& image,
		     double dt) const;
	/// Renews the contacts of a pair (of a grain and a plane or a rigid body) within reach for
	/// a step of dt; may be called by several threads at a time. Balls about both come
	/// first: false if they are so far apart that no surface was looked at, or
	/// both asleep.
	bool search(ContactList<dim>& list, double dt) const;
	/// Whether balls about two grains are so far apart that nothing lies within reach for a
	/// step of dt. False: the search must tell.
	bool areFarApart(int first, int second, const PairImage<dim>& image, double dt) const;
	/// Whether the box of a grain grown by a margin lies within a box.
	bool isInside(int g, const Box<dim>& box, double margin) const;

	/// Contact problem of the last step, solved.
	ContactProblem<dim> contactProblem() const { return solver_.problem(); }

	/// Advances all grains by dt. `lists` hold the contacts of t_n and receive their impulses;
	/// those with a rigid body name their entry of `rigidPartners`.
	StepReport step(const StepSettings& settings, std::vector<ContactList<dim>*> lists);

private:
	struct Place {
		int set, index;
	};
	/// Of a grain in a step, J: its energy at t_n, and what was done on it besides contact.
	struct GrainWork {
		double kinetic = 0;
		ContactWork::Halves loads, damping;
	};
	/// A ball about a grain's outline.
	struct Ball {
		Vec<dim> centre;
		double radius;
	};
	/// phase(grain in the system, its set, its index there)
	template <class Phase>
	void forEachOf(const std::vector<int>& grains, int threads, Phase&& phase);

	void renewSurface(int g) const;
	void measureSurface(int g) const;
	Ball ballAbout(int g) const;
	bool isFarFrom(int g, const Plane<dim>& plane, double reach) const;
	bool isFarFrom(int g, const RigidSide<dim>& rigid, double reach) const;
	double outsideReach(double reach) const;
	std::vector<char> sortLists(std::vector<ContactList<dim>*>& lists,
				    StepReport& report) const;
	void chooseInactiveGrains(std::vector<ContactList<dim>*>& lists,
				  const std::vector<char>& touched, const StepSettings& settings,
				  StepReport& report);
	void move(const std::vector<ContactList<dim>*>& lists, const std::vector<char>& touched,
		  const StepSettings& settings, StepReport& report);
	void endStep(double dt);
	void chooseRigidGrains(const std::vector<char>& touched, const StepSettings& settings);
	void listGrains();
	std::vector<int> ratesOf(const std::vector<double>& timeSteps) const;

	bool liesStill(const ContactList<dim>& list) const;
	void wakeGrains(const std::vector<ContactList<dim>*>& lists, double kick, bool sleep);
	void findRestedGrains(const std::vector<ContactList<dim>*>& lists,
			      const std::vector<char>& touched, const StepSettings& settings);
	Islands islandsInContact(const std::vector<ContactList<dim>*>& lists) const;
	void keepBalanced(const std::vector<ContactList<dim>*>& lists, double kick);
	ContactWork workOfContacts();
	void fallAsleep(const std::vector<ContactList<dim>*>& lists, StepReport& report);
	void measureSleepers();

	double timeStepOf(int g, double stiffening, double rateStiffening) const;
	double presentTimeStepOf(int g) const;
	double deformedTimeStep(double enough, int threads);
	void renewOutline(int g);
	void followMotion(int g, double dt);
	void updateGridNodes(int g) const;
	void useGridNodes(const std::vector<ContactList<dim>*>& lists);
	void beginInterfaces(const std::vector<ContactList<dim>*>& lists, double kick, double dt);
	void measureBonds(const std::vector<ContactList<dim>*>& lists);
	double areaMobility(int g) const;
	double rigidAreaMobility(const ContactList<dim>& list) const;
	void predictVelocities(const std::vector<char>& touched, const StepSettings& settings);
	void gatherContacts(int g, bool trackEnergy);
	void stopAtInfinite() const;
	void checkImpulses(const SolverReport& solved, const std::vector<char>& touched);
	void correctVelocities(int g, const std::vector<char>& touched,
			       const StepSettings& settings);
	void measureWorks(int g);
	void balanceEnergy(const ContactWork& work, double dropped);
	void balanceRigidBodies();

	std::vector<std::unique_ptr<GrainSet<dim>>> sets_;
	std::vector<Place> place_;
	mutable std::vector<ContactBody<dim>> bodies_;    ///< where `surface_` is fresh
	std::vector<std::vector<Vec<dim>>> lastPosition_; ///< of the contact nodes, m
	mutable std::vector<Freshness> surface_;
	enum Activity : char { active, rigid, asleep };
	std::vector<Activity> listed_; ///< by grain: the list it is in
	long listedChanges_ = -1;      ///< of activity, of all sets, when the lists were made
	std::vector<int> active_, asleep_;
	std::vector<int> awake_;   ///< active and rigid
	std::vector<int> rested_;  ///< falling asleep in the step at hand
	std::vector<int> resting_; ///< by sleeping grain: its pairs in contact; -1: woken
	/// Critical steps of the undeformed grains and of the sleeping ones as deformed, the
	/// smallest, s.
	double undeformedTimeStep_ = std::numeric_limits<double>::infinity(),
	       sleepersTimeStep_ = std::numeric_limits<double>::infinity();
	std::vector<BodyLoad<dim>> loads_;
	std::vector<RigidPartner<dim>> partners_; ///< of the step at hand
	std::vector<RigidPartner<dim>> free_;     ///< the same before the solve, for their balance
	std::vector<RigidContact<dim>> rigidContacts_;
	std::vector<int> rate_; ///< by grain
	bool multirate_ = false, ratesChosen_ = false;
	ContactSolver<dim> solver_;
	std::vector<char> finite_;     ///< by grain, of the step at hand
	std::vector<GrainWork> works_; ///< by grain; only where energies are tracked
	EnergyBalance energy_;         ///< at the last t_n
	Continuation continuation_;
	double lastKick_ = 0;
	double gridSpacing_ = 0; ///< ContactGeometry::nodes: the largest h of all grains, m
	double interfaceRange_ = 0;
	bool damped_ = false; ///< a grain has damping
	bool bondsAsleep_ = false;
	bool rebounds_ = false; ///< a pair of the step at hand has a restitution
	bool forcesFresh_ = false;
	long updatedPoints_ = 0;  ///< since the end of the last step
	long measuredPoints_ = 0; ///< not yet taken
};

template <int dim> template <class LoadOf> void System<dim>::setLoads(LoadOf&& loadOf, int threads)
{
	const int count = grains();
	std::vector<char> changed(count);
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int g = 0; g < count; ++g) {
		const BodyLoad<dim> load = loadOf(g);
		changed[g] = !(load == loads_[g]);
		loads_[g] = load;
	}
	for (int g = 0; g < count; ++g)
		if (changed[g]) wake(g);
}

template <int dim>
template <class Phase>
void System<dim>::forEachOf(const std::vector<int>& chosen, int threads, Phase&& phase)
{
	const int count = static_cast<int>(chosen.size());
#pragma omp parallel for schedule(static) num_threads(threadsFor(count, threads))
	for (int k = 0; k < count; ++k) {
		const int g = chosen[k];
		phase(g, *sets_[place_[g].set], place_[g].index);
	}
}

} // namespace softgrain
