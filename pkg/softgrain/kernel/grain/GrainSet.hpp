// A set of grains as the step sees them, whatever formulation moves them. The step calls the phases
// in the order in which they stand here; grains are named by their index in the set.
#pragma once

#include "Vectors.hpp"
#include "grain/Batch.hpp"
#include "grain/InternalForce.hpp"
#include "grain/Observables.hpp"
#include "grain/Scheme.hpp"

#include <memory>
#include <vector>

namespace softgrain {

/// Acceleration field of a body load on one grain: a + A r with r from the centre of mass.
template <int dim> struct BodyLoad {
	Vec<dim> acceleration = Vec<dim>::Zero(); ///< m/s^2
	Mat<dim> angular = Mat<dim>::Zero();      ///< skew, 1/s^2

	bool isZero() const { return acceleration.isZero(0) && angular.isZero(0); }
	/// Largest acceleration by which it differs within a radius, m/s^2.
	double difference(const BodyLoad& o, double radius) const
	{
		return (acceleration - o.acceleration).norm() +
		       radius * (angular - o.angular).norm();
	}
	bool operator==(const BodyLoad& o) const
	{
		return acceleration == o.acceleration && angular == o.angular;
	}
};

/// Sizes of what acts on a grain as a whole in a step, with moments over the radius of its rim, N
/// s.
struct WholeImpulses {
	double sum = 0;  ///< of all together
	double load = 0; ///< of its load
};

/// When the forces of a grain are computed: at steps that are multiples of its rate, to act until
/// the next of these (doc/decisions/0018-multirate.md).
struct ForceSchedule {
	int threads = 1;
	long step = 0; ///< number of the step at hand
	double dt = 0; ///< length of the last step, taken for that of the next ones, s; 0: unknown
};

/// How often the forces of a grain that has met stiffer ones are computed.
struct ForceInterval {
	int steps = 1; ///< from one computation to the next; its rate, if it has met none
	long met = 0;  ///< step in which it did so last, itself or through others
};

/// All that one grain goes on from, component by component, as its formulation keeps it: total
/// Lagrangian x of the nodes and v of the nodes ('flip': of the points); updated Lagrangian x and v
/// of the points, then of the contact nodes, and F of the points.
struct GrainState {
	std::vector<double> x;     ///< positions relative to the grain's origin, m
	std::vector<double> v;     ///< velocities half a step ago, m/s
	std::vector<double> F;     ///< deformation gradients, column by column
	std::vector<double> rigid; ///< RigidMotion::numbers of a grain that moves rigidly, x and v
				   ///< being what follows from it; else empty
	std::vector<double> held;  ///< forces that act beyond the next step; else empty
	std::vector<double> stiffening; ///< Stiffening::numbers, if measured; else empty
	std::vector<double> rest;  ///< RestWatch::numbers of a grain that comes to rest; else empty
	std::vector<double> sleep; ///< Activity::sleepNumbers of a grain that is asleep; else empty
};

/// Ball about the outline of a grain that moves rigidly.
template <int dim> struct RigidBounds {
	Vec<dim> centre = Vec<dim>::Zero(); ///< in space, m
	double radius = 0;                  ///< of the farthest contact node, m
	double bulge = 0;                   ///< how far the outline may lie out of its facets, m
	VectorRange<dim> velocities;        ///< of all places, m/s
};

/// Throws std::invalid_argument unless a saved list has the size that the discretisation needs.
void requireSize(const char* what, const std::vector<double>& numbers, int expected);

/// Mobility of a grain's contact nodes: `scale` times `table` is W_ss', 1/kg. The same laid out for
/// sweeps where it is known for good.
template <int dim> struct ContactMobility {
	const SparseRows<double>* table;
	const SurfaceMobility<dim>* surface;
	double scale;
};

/// A grain whose stiffening is to be measured, and the critical step that is long enough, s.
struct DueMeasurement {
	int grain;
	double enough;
};

template <int dim> class GrainSet {
public:
	virtual ~GrainSet() = default;

	virtual int grains() const = 0;
	virtual const GrainTemplate<dim>& reference() const = 0;
	virtual Condition condition() const = 0;
	virtual const GrainParameters<dim>& parameters(int g) const = 0;
	/// Of the undeformed grain without damping, s.
	virtual double criticalTimeStep(int g) const = 0;
	/// Square of the highest frequency as deformed now over that of the undeformed grain, at
	/// least 1: a bound, or what was measured of a deformation alike (Stiffening).
	virtual double stiffening(int g) const = 0;
	/// Whether it may be less than `stiffening` says.
	virtual bool mayMeasureStiffening(int) const { return false; }
	/// Measures the stiffening of these grains, which lie side by side, until it is known or
	/// the critical step, with damping, is known to be long enough. May be called for different
	/// grains at a time. Returns how often it computed the forces of a grain.
	virtual int measureStiffening(const std::vector<DueMeasurement>&) { return 0; }
	/// How much faster damping acts in the grain as deformed now, >= 1 (Damper).
	virtual double rateStiffening(int) const { return 1; }

	// --- grains that are not computed (doc/decisions/0014-inactive-grains.md) ---------------

	/// Grains are either computed ('active', all at the start) or move rigidly; the phases
	/// below hold for both, except that impulses and forces are for active grains.
	virtual bool isRigid(int) const { return false; }
	/// Whether a grain without contact may move rigidly: undeformed up to rounding, for which
	/// the report must be that of the present positions, and spinning slowly.
	virtual bool mayMoveRigidly(int) const { return false; }
	virtual void beginRigidMotion(int g);
	/// The nodes take over.
	virtual void endRigidMotion(int g);
	/// Whether a grain that moves rigidly does not move at all.
	virtual bool isMotionless(int) const { return false; }
	/// Asleep: at rest, and kept as it is. Phases are not called for such grains.
	virtual bool isAsleep(int) const { return false; }
	/// Time for which a grain has been at rest up to a small share of its elastic energy, in
	/// periods of its slowest vibration, the last dt included; the report must be that
	/// of the present positions. Always 0 where nothing damps.
	virtual double watchRest(int /*g*/, double /*dt*/) { return 0; }
	/// Before the next `move`: whether the forces of this step, which act for `kick`, balance
	/// as well as those of a grain at rest do.
	virtual bool isBalanced(int /*g*/, double /*kick*/) const { return false; }
	/// At the same time: what the step does to the grain as a whole, and its load of that.
	virtual WholeImpulses wholeImpulses(int g, double kick, const BodyLoad<dim>& load) const;
	/// Asleep: whether it may sleep on while forces on it differ by so much from those with
	/// which it fell asleep, N; a small share of this load is the most.
	virtual bool bears(int /*g*/, double /*force*/, const BodyLoad<dim>& /*load*/) const
	{
		return false;
	}
	/// Whether its load has driven it while it was at rest: what nothing bears, if it is
	/// little, is told by what has come together.
	virtual bool isDriven(int /*g*/, const BodyLoad<dim>& /*load*/) { return false; }
	/// Before the last `move`: the new velocities become 0. Returns the momentum that this
	/// takes away, N s.
	virtual Vec<dim> fallAsleep(int g);
	virtual void wake(int g);
	/// How often rigid motion or sleep of a grain began or ended.
	long changesOfActivity() const { return changesOfActivity_; }
	/// To be called after such changes.
	virtual void arrangeGrains() {}
	virtual RigidBounds<dim> rigidBounds(int g) const;

	// --- grains with steps of their own (doc/decisions/0018-multirate.md) --------------------

	virtual bool mayHoldForces() const { return false; }
	/// Forces of a grain are computed in every so many steps, 1 at the start.
	virtual void setRate(int g, int steps);
	/// How often that is done for now, from the next computation on.
	virtual ForceInterval interval(int) const { return {}; }
	virtual void setInterval(int, const ForceInterval&) {}

	// --- the phases of a step ---------------------------------------------------------------

	/// Internal forces and `report` of active grains, of the present positions; where they act
	/// for several steps, of the positions expected in the middle of these, and only in the
	/// first of them. Returns for how many grains they were computed. Parallel; the result does
	/// not depend on the number of threads.
	virtual int updateForces(const ForceSchedule& schedule) = 0;
	virtual const BulkReport& report(int g) const = 0;
	/// v* = v + kick (f/m + load).
	virtual void predictVelocities(int g, double kick, const BodyLoad<dim>& load) = 0;
	/// Valid until the grain moves. The table stays where it is for the life of the set.
	virtual ContactMobility<dim> contactMobility(int g) = 0;
	/// Velocities of the contact nodes after the present phase, into `at`.
	virtual void contactVelocities(int g, std::vector<Vec<dim>>& at) const = 0;
	/// The same at t_n - dt/2.
	virtual void contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const = 0;
	/// From the contact nodes to the velocities.
	virtual void applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse) = 0;
	virtual bool hasFiniteVelocities(int g) const = 0;
	/// 1/2 sum m v(t_n - dt/2) . v(t_n + dt/2), J.
	virtual double kineticEnergy(int g) const = 0;
	/// Adds the work of a load, the halves with the velocities before and after t_n, J.
	virtual void addLoadWork(int g, double kick, const BodyLoad<dim>& load, double& before,
				 double& after) const = 0;
	/// Adds what damping dissipates, in the same halves.
	virtual void addDampingLoss(int, double /*kick*/, double& /*before*/,
				    double& /*after*/) const
	{
	}
	/// What has to be done for several grains together before they move, if anything. Parallel.
	virtual bool preparesMove() const { return false; }
	virtual void prepareMove(int /*threads*/) {}
	/// The new velocities become the present ones, and the grain moves by dt.
	virtual void move(int g, double dt) = 0;
	/// Of the contact nodes, m/s.
	virtual VectorRange<dim> contactVelocityRange(int g) const = 0;
	/// Positions of the contact nodes into `at`.
	virtual void contactPositions(int g, std::vector<Vec<dim>>& at) const = 0;

	// --- contact on a common grid (ContactGeometry::nodes), where Scheme::validate allows it

	/// Positions and masses of the material points.
	virtual void massPoints(int g, std::vector<Vec<dim>>& position,
				std::vector<double>& mass) const;
	/// Until the grain moves, contact nodes are those whose velocities are the given sums of
	/// the velocities of material points (row: contact node, column: point).
	virtual void useContactNodes(int g, const SparseRows<double>& pointShares);

	// --- what others ask and set ------------------------------------------------------------

	virtual WholeGrain<dim> whole(int g) const = 0;
	/// 1/2 sum m v . v of the present velocities, J.
	virtual double presentKineticEnergy(int g) const = 0;
	virtual std::vector<PointResponse<dim>> points(int g) const = 0;
	/// Area (volume) of all points, m^2 (m^3).
	virtual double presentVolume(int g) const;
	/// Positions and velocities of the background nodes (updated Lagrangian: of the material
	/// points, since nothing persists at nodes).
	virtual std::vector<Vec<dim>> nodePositions(int g) const = 0;
	virtual std::vector<Vec<dim>> nodeVelocities(int g) const = 0;
	/// Places a grain undeformed: rotated, moving as a rigid body about its origin.
	virtual void place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
			   const Mat<dim>& spin) = 0;
	/// Adds a rigid motion: turns about the centre of mass, shifts, adds
	/// velocity + spin (x - centre).
	virtual void moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
				 const Vec<dim>& velocity, const Mat<dim>& spin) = 0;
	virtual GrainState state(int g) const = 0;
	/// Throws std::invalid_argument where the state does not fit the discretisation.
	virtual void setState(int g, const GrainState& state) = 0;

protected:
	/// What a load adds to the velocities of a grain in the time `kick`. (The centre of mass is
	/// a sum over the grain: only a load that turns it asks for it.)
	RigidVelocities<dim> kickOf(int g, const BodyLoad<dim>& load, double kick) const
	{
		RigidVelocities<dim> added { kick * load.acceleration, kick * load.angular };
		if (!load.angular.isZero(0)) added.centre = whole(g).centre;
		return added;
	}

	long changesOfActivity_ = 0;
};

/// Undeformed grains at their origins. Throws std::invalid_argument naming what is inadmissible.
template <int dim>
std::unique_ptr<GrainSet<dim>>
makeGrainSet(std::shared_ptr<const GrainTemplate<dim>> reference, Law law, Condition condition,
	     const std::vector<GrainParameters<dim>>& grains, const Scheme& scheme);

} // namespace softgrain
