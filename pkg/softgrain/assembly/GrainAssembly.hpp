// The kernel as YADE sees it: grains by index, vectors in three dimensions, the dimension of the
// scene hidden. No YADE header, no physics.
#pragma once

#include "Fetch.hpp"
#include "assembly/ContactProblemArrays.hpp"
#include "assembly/GrainDescription.hpp"
#include "assembly/NeighbourBoxes.hpp"
#include "assembly/PairContacts.hpp"
#include "assembly/RigidDescriptions.hpp"
#include "step/System.hpp"

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

namespace softgrain {

/// One grain as a rigid body would show.
struct GrainMotion {
	double mass, inertia; ///< inertia about z in 2D, mean principal one in 3D
	Vec3 position, velocity, angularVelocity;
	Rotation orientation;
};

/// Accelerations of a body load on one grain, m/s^2 and 1/s^2.
struct GrainLoad {
	Vec3 acceleration = Vec3::Zero(), angularAcceleration = Vec3::Zero();
};

/// Energies of one grain, J (2D: J/m).
struct GrainEnergy {
	double kinetic; ///< of the present velocities
	double elastic; ///< at the beginning of the last step; 0 before the first
};

/// Fields at the material points of a grain.
struct PointFields {
	std::vector<Vec3> position;
	std::vector<Mat3> F, cauchy; ///< cauchy in Pa, with the out-of-plane stress in 2D
	std::vector<double> volume;  ///< present one, m^2 (m^3)
};

/// What the host notes about the grains of an assembly, for itself.
struct HostNotes {
	LoopMemory searches; ///< what its loop of searches reads
	NeighbourBoxes neighbours;
	/// By grain, whether it has published that the grain sleeps: nothing changes until it is
	/// awake again.
	std::vector<char> publishedAsleep;
	/// By grain, whether its copy of the motion may not be what it published; of a new
	/// assembly, that is not known.
	std::vector<char> moved;
	Mat3 cell = Mat3::Zero(); ///< periods of a periodic scene as last seen, in columns, m
	int unbounded = -1;       ///< first body whose bounding box is to be looked at; or -1
	bool hasPlates = false;   ///< whether there are rigid bodies with flat faces
	/// Step in which it was looked at the engines last, before contacts were searched.
	std::atomic<long> checkedIn { -1 };
	/// Engines were found that would end the process at a contact: there is to be none.
	bool isUnfit = false;

	void setFit(bool fit)
	{
		if (fit && isUnfit) moved.assign(moved.size(), true); // not searched meanwhile
		isUnfit = !fit;
	}
};

class GrainAssembly {
public:
	virtual ~GrainAssembly() = default;
	/// Builds the system of all grains, with the templates of `last` (may be null) as far as
	/// they serve; throws std::invalid_argument naming the grain, the parameter and the
	/// admissible range.
	static std::shared_ptr<GrainAssembly> create(const std::vector<GrainDescription>& grains,
						     const GrainAssembly* last = nullptr);
	/// For contacts of rigid bodies alone, in three dimensions.
	static std::shared_ptr<GrainAssembly> createWithoutGrains();

	virtual int grains() const = 0;
	virtual int templates() const = 0;           ///< that the grains share
	int idOf(int g) const { return id_[g]; }     ///< of the body of the host
	virtual double criticalTimeStep() const = 0; ///< of the undeformed grains, s
	/// As deformed now, s; found out as far as it is shorter than `enough`.
	virtual double presentCriticalTimeStep(double enough, int threads) = 0;
	virtual long takeMeasuredPoints() = 0; ///< TimeSteps::takeMeasuredPoints
	/// TimeSteps::setMultirate and TimeSteps::rate.
	virtual void setMultirate(bool on) = 0;
	virtual int rate(int g) const = 0;
	/// System::kickTime, System::limitKick.
	virtual double kickTime(double dt) const = 0;
	virtual void limitKick(double longest) = 0;
	/// Surfaces::setInterfaceRange; false if it was that. Whatever sleeps is looked at once
	/// more.
	virtual bool setInterfaceRange(double range) = 0;
	virtual double interfaceRange() const = 0;
	virtual double reachAtRest(int g) const = 0;  ///< Surfaces::reachAtRest, m
	virtual double slowestWave() const = 0;       ///< smallest speed of pressure waves, m/s
	virtual double pointSpacing(int g) const = 0; ///< dr, m
	virtual void updateForces(int threads) = 0;   ///< throws StepError
	virtual bool isRigid(int g) const = 0;        ///< moves as a rigid body
	virtual bool isAsleep(int g) const = 0;       ///< at rest, and left as it is
	HostNotes host;

	virtual std::unique_ptr<PairContacts> newPair() const = 0;
	/// Of the grain `first` and the image of the other.
	virtual void search(PairContacts& pair, int first, int second,
			    const ImageDescription& image, double dt) const = 0;
	/// Whether the balls about two grains already tell that there is nothing to search.
	virtual bool areFarApart(int first, int second, const ImageDescription& image,
				 double dt) const = 0;
	virtual void search(PairContacts& pair, int g, const WallDescription& wall,
			    double dt) const = 0;
	/// No contact with such a wall, whatever there was: its other side acts.
	virtual void separate(PairContacts& pair, int g, const WallDescription& wall) const = 0;
	/// A body that checkRigidBody refuses counts as an infinite overlap. `others`: rigid bodies
	/// about the grain as it sees them, asked for where it meets an edge of this one, which may
	/// be a seam of both.
	virtual void search(PairContacts& pair, int g, const RigidBodyDescription& body,
			    const std::function<std::vector<RigidBodyDescription>()>& others,
			    const ImageDescription& image, double dt) const = 0;
	/// Throws std::invalid_argument if grains cannot touch the body, saying why.
	virtual void checkRigidBody(const RigidBodyDescription& body) const = 0;
	/// `partners`: motions of the rigid bodies in contact, as the pairs number them. Contacts
	/// of these with each other are swept in the given order. In 2D throws
	/// std::invalid_argument for one whose normal is neither in the plane nor across it.
	virtual StepReport step(const StepSettings& settings,
				const std::vector<PairContacts*>& pairs,
				std::vector<RigidMotionDescription>& partners,
				std::vector<RigidContactDescription>& rigidContacts) = 0;
	virtual ContactProblemArrays contactProblem() const = 0; ///< of the last step, solved
	virtual void forgetContactProblem() = 0;                 ///< none until the next step

	/// Of all grains g; so many threads share the calls of `loadOf`, which must throw nothing.
	/// Another load than before wakes a sleeping grain, and so does `moveRigidly`.
	virtual void setLoads(const std::function<GrainLoad(int g)>& loadOf, int threads) = 0;
	virtual GrainMotion motion(int g) const = 0;
	/// Present inertia about the centre of mass, axes of space; in 2D about z alone.
	virtual Mat3 inertia(int g) const = 0;
	/// What a force and a torque (N, N m) on the grain as it is now do to its velocity and
	/// spin.
	virtual GrainLoad load(int g, const Vec3& force, const Vec3& torque) const = 0;
	/// Adds a rigid motion: turns by `turn` about the centre of mass, shifts, adds velocities.
	virtual void moveRigidly(int g, const Rotation& turn, const Vec3& shift,
				 const Vec3& velocity, const Vec3& angularVelocity) = 0;

	virtual EnergyBalance energy() const = 0;
	virtual GrainEnergy energy(int g) const = 0;
	virtual Continuation continuation() const = 0;
	virtual void continueFrom(const Continuation& state) = 0;

	/// About the outline, in coordinates that `map` makes of those of space.
	virtual Box<3> box(int g, const Mat3& map) const = 0;
	/// Whether the box grown by a margin lies within a box, in the dimensions of the scene.
	virtual bool isInside(int g, const Box<3>& outer, double margin) const = 0;
	/// The same in such coordinates.
	virtual bool isInside(int g, const Box<3>& outer, double margin, const Mat3& map) const = 0;
	virtual std::vector<Vec3> outline(int g) const = 0; ///< positions of the contact nodes
	/// selfOverlap over the spacing of material points, of grains that may meet themselves;
	/// else 0.
	virtual double overlapWithItself(int g) const = 0;
	/// Numbers of the nodes of its facets, `dim` numbers a facet, in 2D in order around it;
	/// empty with contact 'points'.
	virtual std::vector<int> facets(int g) const = 0;
	virtual PointFields points(int g) const = 0;
	virtual double presentVolume(int g) const = 0;    ///< m^2 (m^3)
	virtual double undeformedVolume(int g) const = 0; ///< m^2 (m^3)
	/// Of the background nodes.
	virtual std::vector<Vec3> nodePositions(int g) const = 0;
	virtual std::vector<Vec3> nodeVelocities(int g) const = 0;
	/// Present state and its origin as GrainDescription takes them.
	virtual GrainState state(int g, Vec3& origin) const = 0;

protected:
	std::vector<int> id_; ///< of the body of the host, by index in the system
};

} // namespace softgrain
