#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"
#include "scene/ColliderWatch.hpp"
#include "scene/EnergyBooks.hpp"
#include "scene/EngineScene.hpp"
#include "scene/RigidContacts.hpp"
#include "scene/RigidPartners.hpp"
#include "scene/SoftInteractions.hpp"

namespace yade {

/// Conducts the step: its attributes are the user's settings and what is to be known of a step, and
/// its action calls in order those who do it: SceneAssembly, SoftBodies, SoftInteractions,
/// RigidPartners, RigidContacts and the kernel.
class SoftGrainIntegrator : public GlobalEngine {
public:
	void action() override;
	void
	postLoad(SoftGrainIntegrator&); ///< checks all attributes, throws std::invalid_argument
	/// Whether it has done its part of this step.
	bool hasPublishedIn(long step) const { return publishedIn_ == step && !ownScene_.isGone(); }
	bool hasPublishedSince(long step) const
	{
		return publishedIn_ >= step && !ownScene_.isGone();
	}
	/// Rigid spheres turned soft in this step.
	void noteSoftened(long step) { softenedIn_ = step; }
	py::dict energyDict() const;
	py::dict contactProblem() const;
	py::dict ratesDict() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftGrainIntegrator, GlobalEngine,
		"Advances all soft grains by one step: internal forces by total-Lagrangian MPM, contact dynamics of all contact points together, motion. Contacts of rigid bodies with each other under :yref:`Law2_ScGeom_FrictPhys_Nonsmooth` are solved in the same contact dynamics, also in a scene without soft grains. It stands after the InteractionLoop and before :yref:`NewtonIntegrator`, which moves rigid bodies. Free rigid bodies in these contacts take part in the contact dynamics with their mass and inertia, at the velocity that :yref:`NewtonIntegrator` would give them: whatever else puts forces on them stands before this engine, and *damping* must be 0 (or their :yref:`State.isDamped` False); it does not reach soft grains, which have the damping of their :yref:`SoftMat`. Of a soft grain it writes :yref:`State.pos`, *vel*, *ori* and *angVel* (centre of mass and mean rotation); changes that the user makes to them act on the grain as rigid motions. In a periodic cell engines that change :yref:`Cell.velGrad` stand before this one, and :yref:`Cell.homoDeform` acts on soft grains as on other bodies, as a body load. Forces and torques in :yref:`ForceContainer` and :yref:`NewtonIntegrator.gravity` act on it as body loads (weight: that of the unscaled mass, see :yref:`SoftMat.massScaling`). Reactions are added to the forces of both bodies.\n\nWhatever goes wrong stops the run with the grain, the point, the step and a hint; positions and velocities are then those before the step, readable and savable.",
		((Real, timeStepFraction, 0.85, Attr::triggerPostLoad, "Fraction of the critical time step that O.dt is kept at or up to 30 % below while grains deform (it changes seldom, by jumps; mostly it is a few per cent below), in (0, 1] [-]. Assigning O.dt by hand ends that: then O.dt is left alone and only refused when too large. An active :yref:`TimeStepper`, which must stand before, is for the rigid bodies: the smaller of both steps is taken."))
		((Real, tolerance, 1e-2, Attr::triggerPostLoad, "Residual of the contact conditions at which the sweeps of a step end, > 0 [-]. See *residual*."))
		((int, maxSweeps, 100, Attr::triggerPostLoad, "Cap on sweeps over all contacts in a step, and on those of a pair each time that it is solved on its own, which *sweeps* has besides, ≥ 1; below 4 grains at rest may vibrate ever more. Steps that hit it with a *residual* above *tolerance* are counted in *cappedSteps*."))
		((Real, overlapRelaxation, 0.1, Attr::triggerPostLoad, "Share of an overlap worked off per step, in [0, 1] [-]; at once would throw grains apart."))
		((Real, overlapSpeed, 1e-3, Attr::triggerPostLoad, "Cap on the speed at which overlaps are worked off, over the slowest wave speed of the grains, ≥ 0 [-]. Those below 0.05 of the spacing of material points that no load has pressed in lately are worked off more slowly, with the cube of the overlap (doc/theory.md, Contact). Rigid bodies that overlap each other are moved apart without gaining speed, and without a cap."))
		((Real, maxOverlap, 1, Attr::triggerPostLoad, "Overlap, of two bodies or of the arms of a polygon or a slender grain, at which the run stops, over the spacing of material points, of two rigid bodies over a tenth of the smaller radius, > 0 [-]."))
		((bool, rigidMotion, true, , "Whether grains that are undeformed and have no contact point within reach move as rigid bodies, at next to no cost: momentum and angular momentum are kept to rounding, and they are woken in the step in which a contact point comes within reach, before contacts are solved. Their nodes, stress and outline are made when asked for. Grains that spin at their rim with more than a hundredth of their wave speed, and formulation 'updated', are always computed. See doc/decisions/0014-inactive-grains.md."))
		((bool, multirate, false, , "Whether small or stiff grains take steps of their own: O.dt is that of the grain with the shortest critical step, contacts and motion go by it, and stresses and internal forces of a grain whose critical step, undeformed, is n times as long are computed every n-th step and act until the next time (*rates*). A grain that touches a faster and stiffer one is computed as often as that, and so are those like itself that touch it in turn, until they have met none for 1000 n steps. Momentum is kept to rounding, angular momentum over n steps; energies ripple as in a scene of slow grains alone with a time step of their own. Grains with formulation 'updated' or velocityUpdate 'flip' are computed in every step; a scene whose critical steps differ by less than a factor of two runs as without. O.dt should change seldom, as it does by itself. See doc/decisions/0018-multirate.md."))
		((bool, sleep, true, , "Whether damped grains (:yref:`SoftMat.massDamping`, :yref:`SoftMat.stiffnessDamping`) that came to rest sleep: nodes, stress and contact forces stay as they are, and nothing is searched, solved or moved for them. A grain falls asleep once its kinetic energy has been below 1e-8 of its elastic energy for four periods of its slowest vibration times the number of grains across, and all that it touches are at rest as well or sleep. (Across what is connected by contact points within reach and awake; this must lie on a Wall, a rigid body that is held, or on sleepers, of which none moves.) A sleeper is woken, with its impulses, when what its neighbours do to it has changed by more than 1e-3 of the force that belongs to its elastic energy, or by a hundredth of its weight, if that is less; by anything new within reach, by a Wall or rigid body that moves, was moved or let go, by a Wall of which the other side acts from now on, by a change of its load, State, friction or material, or when a partner is erased. Until then it is held where it is. What grains that fall asleep still had of kinetic energy and momentum is dropped and counted. Undeformed grains that touch nothing, do not move and bear no load sleep as well, damped or not. See doc/decisions/0014-inactive-grains.md."))
		((Real, interfaceRange, 0, Attr::triggerPostLoad, "Largest gap across which an interface acts (:yref:`SoftInterface.cohesionRange`, the final opening of a bond), ≥ 0 [m]: surfaces are searched that far for each other, and a pair with a larger range is refused. sg.engines(interface=) sets it."))
		((Real, criticalDt, 0, Attr::readonly, "Critical time step of the grains as deformed now, and of the bonds between them [s]: measured where it limits O.dt, else a lower bound. |yupdate|"))
		((int, contacts, 0, Attr::readonly, "Contact points within reach. |yupdate|"))
		((int, activeContacts, 0, Attr::readonly, "Contact points that carry force. |yupdate|"))
		((Real, sweeps, 0, Attr::readonly, "Sweeps of the last step: visits of contact points over their number, since a pair may be swept more often than the others. |yupdate|"))
		((Real, residual, 0, Attr::readonly, "How far the impulses of the last step are from solving the contact conditions, measured apart from the sweeps, in that part of the scene, of bodies connected by contact, where it is largest: size of the changes that would solve each contact alone, over the size of the impulses, both in the energy norm √(Σ W r²); between 0 and 2 [-]. Where rigid bodies that contact moves touch nothing that moves as prescribed, nor a cell that does, over what their impulses exchange with them, √(Σ r·(u - u_free)), but no less than a tenth of the former; without a bound then. |yupdate|"))
		((Real, largestResidual, 0, Attr::readonly, "Largest *residual* of a step so far [-]. |yupdate|"))
		((Real, overlap, 0, Attr::readonly, "Largest overlap in the last step over the spacing of material points, of two rigid bodies over a tenth of the smaller radius [-]. |yupdate|"))
		((Real, largestOverlap, 0, Attr::readonly, "Largest *overlap* of a step so far [-]. |yupdate|"))
		((int, templates, 0, Attr::readonly, "Sets of tables that the grains share: congruent grains (equal up to translation, rotation and size) of equal *zeta* and so on have one in common. |yupdate|"))
		((int, activeGrains, 0, Attr::readonly, "Grains computed in the last step; the others moved rigidly or slept. |yupdate|"))
		((int, sleepingGrains, 0, Attr::readonly, "Grains that slept in the last step. |yupdate|"))
		((Real, droppedMomentum, 0, Attr::readonly, "Momentum taken away from grains that fell asleep, and taken up by sleepers that are pushed otherwise than when they fell asleep, summed over them so far, whatever its direction [N s, 2D N s/m]. |yupdate|"))
		((Real, droppedEnergy, 0, Attr::readonly, "Kinetic energy taken away from grains that fell asleep so far [J, 2D J/m]. |yupdate|"))
		((Real, totalGrainSteps, 0, Attr::readonly, "Sum of *activeGrains* over all steps so far. |yupdate|"))
		((Real, steps, 0, Attr::readonly, "Steps so far. |yupdate|"))
		((Real, totalSweeps, 0, Attr::readonly, "Sweeps so far. |yupdate|"))
		((Real, pointsUpdated, 0, Attr::readonly, "Material points whose stress was computed, summed over the steps so far. |yupdate|"))
		((Real, pointsMeasured, 0, Attr::readonly, "The same where critical steps were measured (*criticalDt*); not in *pointsUpdated*. |yupdate|"))
		((Real, pairsSearched, 0, Attr::readonly, "Pairs of bodies searched for contact points, summed over the steps so far. |yupdate|"))
		((Real, candidatesTested, 0, Attr::readonly, "Contact nodes that these searches tested against the other body. |yupdate|"))
		((Real, contactsSwept, 0, Attr::readonly, "Visits of contact points by sweeps so far. |yupdate|"))
		((Real, cappedSteps, 0, Attr::readonly, "Steps so far whose *residual* was still above *tolerance* after *maxSweeps* sweeps. |yupdate|"))
		((Real, lostBonds, 0, Attr::readonly, "Bonds that were whole when their contact point vanished, so far: whether the surfaces went apart in one step or slid off each other, or a rigid sphere turned soft (:yref:`SoftenWhenLoaded`). |yupdate|"))
		((string, lastError, "", Attr::readonly, "What stopped the last run, also where YADE lost the exception. |yupdate|"))
		((Real, dtSet, 0, , "O.dt as last set by this engine or by sg.set_time_step [s]; any other O.dt is the user's."))
		((Real, dtOfSpheres, -1, Attr::hidden, "O.dt that was chosen for rigid spheres before the first of them turned soft, 0 where there were soft grains already [s]; negative: none turned."))
		((int, stepsToRaise, 0, Attr::hidden, "Steps in a row with a too short O.dt before it may be raised."))
		((Real, lastStep, 0, Attr::hidden, "Length of the last step [s]."))
		((long, assemblySteps, 0, Attr::hidden, "Steps of the assembly so far."))
		((Real, bondRate, 0, Attr::hidden, "Largest squared frequency of bonds in the last step [1/s²]."))
		((vector<Real>, energies, , Attr::hidden, "Energy balance of the last step [J]."))
		((vector<Real>, workSums, , Attr::hidden, "Sums of EnergyBalance: friction, impact, walls, loads, damping, sleep, cell, cohesion [J]."))
		((vector<Real>, rigidEnergies, , Attr::hidden, "RigidBalance of the last step [J]."))
		((vector<Real>, rigidWorkSums, , Attr::hidden, "Sums of RigidBalance: friction, impact, walls, cell, loads [J].")),
		timingDeltas.reset(new TimingDeltas);,
		.def("energy", &SoftGrainIntegrator::energyDict, "Energy balance at the beginning of the last step, summed while :yref:`O.trackEnergy<Omega.trackEnergy>` is on (RuntimeError while it is off): dict of kinetic, elastic, friction (dissipated), impact (dissipated by normal impulses), walls (work done by moving walls), cell (work done by a periodic cell that deforms, through contacts across its borders), loads (work of body loads, those of :yref:`Cell.homoDeform` among them), damping (dissipated by :yref:`SoftMat.massDamping` and :yref:`SoftMat.stiffnessDamping`), sleep (taken away by grains that fell asleep), cohesion (taken by the tractions of interfaces, negative while they have pulled surfaces together) [J, 2D J/m]. kinetic + elastic + friction + impact + damping + sleep + cohesion − walls − cell − loads stays constant. Where O.engines have :yref:`Law2_ScGeom_FrictPhys_Nonsmooth`, the same of all free rigid bodies and their contacts with each other (but for those that touch nothing and are damped by :yref:`NewtonIntegrator.damping`): rigidKinetic, rigidFriction, rigidImpact (0 or more but for rounding), rigidWalls (work of bodies that move as prescribed), rigidCell (work of the deforming cell), rigidLoads (work of all that acts on them besides contact dynamics, :yref:`NewtonIntegrator.gravity` among it) [J]; rigidKinetic + rigidFriction + rigidImpact − rigidWalls − rigidCell − rigidLoads stays constant while they touch no soft grain (what they do on those is in *walls*), up to what overlaps that are worked off change of their height, and the error of YADE's integrator for aspherical bodies (clumps). :yref:`O.energy<Omega.energy>` has rigidFriction and rigidImpact beside YADE's kinetic and gravWork.")
		.def("rates", &SoftGrainIntegrator::ratesDict, "Grains by their rate: dict of steps from one computation of the forces of a grain to the next, unless it has met stiffer grains : number of grains. {1: all} without :yref:`SoftGrainIntegrator.multirate`; empty before the first step.")
		.def("contactProblem", &SoftGrainIntegrator::contactProblem, "Contact problem of the last step as a dict of numpy arrays, with n contacts in dim dimensions, ready for ``numpy.savez``. Find impulses r with u = u_free + W r that satisfy 0 ≤ u_n + b ⊥ r_n ≥ 0, \\|r_t\\| ≤ mu r_n, sliding opposite to u_t at the bound. Keys: *normal* (n, dim), unit; *free_velocity* (n, dim), u_free [m/s]; *bias* (n), b [m/s]; *friction* (n), mu; *delassus_offset*, *delassus_column*, *delassus_value*, W [1/kg] in compressed sparse rows, n x n, each entry standing for itself times the identity of dim dimensions; *start* (n, dim), impulses the sweeps started from [N s]; *impulse* (n, dim), those they found [N s]. In 2D everything is per metre of thickness. Empty arrays before the first step and after one that failed.")
	);
	// clang-format on

	DECLARE_LOGGER;

private:
	void advance();
	bool assemble();
	void letAssemblyGo();
	/// Ends the step with an error, to be taken anew from its prologue; nothing is left of the
	/// problem of the step before.
	[[noreturn]] void fail(const std::string& message);
	void forgetOtherScene();
	void continueSums();
	void saveContinuation();
	void chooseTimeStep();
	void followDeformation(Real undeformed, bool hasStepper);
	Real longestBesideSpheres() const;
	void measureCriticalStep(Real enough);
	void limitKick();
	void warnOfStiffSpheres();
	void checkCollapsedStep(Real undeformed);
	void warnOfPressure();
	void warnOfOverlapsInCell();
	bool tracksRigidBodies() const;
	softgrain::StepSettings settings();
	void holdWalls();
	void keepBooks(const softgrain::StepReport& report);
	void publishReport(const softgrain::StepReport& report);
	void publishEnergy();
	void publishTimes();
	int threads() const;

	/// While a step is made. Between steps grains keep their assembly alone: YADE frees no
	/// engine that O.engines was once set to, and what that holds outlives O.reset().
	std::shared_ptr<softgrain::GrainAssembly> assembly_;
	std::weak_ptr<softgrain::GrainAssembly> lastAssembly_; ///< of the last step
	EngineScene ownScene_;
	bool hadGrains_ = false;                                  ///< in the last step
	std::shared_ptr<softgrain::GrainAssembly> withoutGrains_; ///< for scenes of rigid bodies
	InteractionOrder order_;
	RigidPartners partners_;
	RigidContacts rigidContacts_;
	ColliderWatch collider_;
	EnergyBooks energyBooks_;
	softgrain::PhaseClock clock_;
	long publishedIn_ = -1; ///< step in which it last came to its end
	long softenedIn_ = -1;  ///< step in which spheres turned soft last
	Real longestDt_ = 0;    ///< that the soft grains have asked for since it began to run, s
	std::size_t bodiesLookedAt_ = 0; ///< by warnOfStiffSpheres
	bool warnedOfPressure_ = false, warnedOfStiffness_ = false, warnedOfCollapse_ = false;
	bool hadSmallOverlaps_ = false, warnedOfOverlaps_ = false; ///< of rigid bodies in a cell
};
REGISTER_SERIALIZABLE(SoftGrainIntegrator);

/// Critical time step of the soft grains of a scene, undeformed, s; 0 if there are none.
Real criticalTimeStep(Scene& scene);

} // namespace yade
