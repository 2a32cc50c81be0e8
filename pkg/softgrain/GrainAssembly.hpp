// The kernel as YADE sees it: grains by index, vectors in three dimensions, the dimension of the
// scene hidden. No YADE header, no physics.
#pragma once

#include "ContactProblemArrays.hpp"
#include "contact/Pressure.hpp"
#include "step/System.hpp"

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace softgrain {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Rotation = Eigen::Quaterniond;

/// One grain to be assembled. Throughout, 2D grains lie in the xy-plane.
struct GrainDescription {
	int id = -1; ///< of the YADE body
	int dim = 2;
	TemplateRecipe recipe;
	Scheme scheme;
	Law law = Law::neoHookean;
	Condition condition = Condition::planeStrain;
	ElasticConstants constants;
	Damping damping;
	double radius = 0;                   ///< m
	Vec3 position = Vec3::Zero();        ///< of the centre, m
	Vec3 velocity = Vec3::Zero();        ///< m/s
	Vec3 angularVelocity = Vec3::Zero(); ///< 1/s
	Rotation orientation = Rotation::Identity();
	Vec3 origin = Vec3::Zero(); ///< of the positions in `state`, m
	GrainState state;           ///< to go on from; empty: undeformed
};

/// A rigid plane wall with prescribed motion.
struct WallDescription {
	int id; ///< of the YADE body
	Vec3 point, normal, velocity;
};

/// Surface of a rigid body with its motion. In 2D: a disk, the segment in which a triangle cuts the
/// plane of the grains, a rectangle.
struct RigidBodyDescription {
	enum class Form { ball, plate, block };
	int id; ///< of the YADE body with this surface
	Form form;
	Vec3 position, velocity, angularVelocity;
	Rotation orientation;
	Vec3 size;                  ///< of a ball: the radius; of a block: half sides, m
	std::array<Vec3, 3> corner; ///< of a plate, in space
};

/// How a grain sees its partner in a periodic cell: displaced by a period, and moving with the
/// cell.
struct ImageDescription {
	Vec3 shift = Vec3::Zero();    ///< from the partner to its image, m
	Vec3 velocity = Vec3::Zero(); ///< of the shift, m/s
};

/// A rigid body in the contacts of a step: what it weighs and how it moves.
struct RigidMotionDescription {
	Vec3 centre;                            ///< of mass, m
	Vec3 velocity, angularVelocity;         ///< half a step ago
	Vec3 freeVelocity, freeAngularVelocity; ///< in half a step, without contact
	Vec3 inverseMass;                       ///< along each axis of space, 1/kg; 0: held
	Mat3 inverseInertia;                    ///< in the axes of space, 1/(kg m^2); 0: held
	/// By the step: out of overlaps with other rigid bodies, besides the motion, m and rad.
	Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
};

/// Two rigid bodies where they touch, or may in the coming step.
struct RigidContactDescription {
	int first, second;  ///< numbers of their RigidMotionDescription
	Vec3 point, normal; ///< m; unit, from the first to the second
	double gap;         ///< m, negative for an overlap
	double size;        ///< what the spacing of material points is to soft grains, m
	double friction;    ///< mu
	Vec3 impulse;       ///< on the second, N s: the last one, after a step the solved one
};

/// One grain as a rigid body would show.
struct GrainMotion {
	double mass, inertia; ///< inertia about z in 2D, mean principal one in 3D
	Vec3 position, velocity, angularVelocity;
	Rotation orientation;
};

/// Energies of one grain, J (2D: J/m).
struct GrainEnergy {
	double kinetic; ///< of the present velocities
	double elastic; ///< at the beginning of the last step; 0 before the first
};

struct ContactRecord {
	ContactKey key;
	Vec3 point, normal, impulse; ///< normal and impulse act on the node's grain
	double gap;
	Vec3 pull = Vec3::Zero(); ///< impulse of the interface's tractions, besides, N s
	Bond bond = Bond::none;
	double damage = 0; ///< of the bond, in [0, 1]
};

/// What the contacts of a pair do to its first grain together.
struct SumOfImpulses {
	Vec3 normal = Vec3::Zero(), shear = Vec3::Zero(); ///< N s
	Vec3 point = Vec3::Zero(); ///< mean of the contact points, on the first grain's side, m
	/// On a rigid body (no wall), about the RigidBodyDescription::position of its image, N m s.
	Vec3 moment = Vec3::Zero();
	int contacts = 0, active = 0; ///< those with an impulse
};

/// Contacts of one pair; its first grain has the lower index.
class PairContacts {
public:
	virtual ~PairContacts() = default;
	/// Whether there is a contact point within reach, or an overlap too deep for one.
	virtual bool hasContact() const = 0;
	/// The pair is asleep, and its impulses in the last step were those of the step before.
	virtual bool isKept() const = 0;
	virtual double deepest() const = 0; ///< largest overlap, in dr
	virtual void setFriction(double coefficient) = 0;
	/// In the coming step, of the image of the second body, beyond its own velocity, m/s.
	virtual void setImageVelocity(const Vec3& velocity) = 0;
	/// What acts besides friction (none: nothing), valid or not.
	virtual void setInterface(const std::optional<InterfaceLaw>& law) = 0;
	/// Throws std::invalid_argument if law and friction are not admissible for the pair.
	virtual void checkInterface() const = 0;
	/// Bonds the contact points that touch now; returns their number.
	virtual int bondTouching() = 0;
	virtual std::vector<double> interfaceHistory() const = 0; ///< for a save; empty: none
	virtual void restoreInterface(const std::vector<double>& saved) = 0;
	/// With a rigid body (no wall); `partner` is the number of its motion in the coming step.
	virtual bool hasRigidBody() const = 0;
	virtual void setPartner(int partner) = 0;
	virtual int firstGrain() const = 0;
	virtual SumOfImpulses impulse() const = 0;
	virtual std::vector<ContactRecord> records() const = 0;
	/// Of the last step, one for each record.
	virtual std::vector<ContactPressure> pressures() const = 0;
	virtual double kick() const = 0; ///< time over which the impulses acted, s
	/// Puts saved impulses back; the next search carries them over to the contacts it finds.
	virtual void restore(const std::vector<ContactRecord>& saved) = 0;
	/// What a sleeping pair has to be saved with besides its records; empty if awake.
	virtual std::vector<double> rest() const = 0;
	/// After `restore`: the pair sleeps on.
	virtual void restoreRest(const std::vector<double>& saved) = 0;
};

/// Fields at the material points of a grain.
struct PointFields {
	std::vector<Vec3> position;
	std::vector<Mat3> F, cauchy; ///< cauchy in Pa, with the out-of-plane stress in 2D
	std::vector<double> volume;  ///< present one, m^2 (m^3)
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
	virtual int templates() const = 0; ///< that the grains share
	virtual int idOf(int g) const = 0;
	virtual double criticalTimeStep() const = 0;        ///< of the undeformed grains, s
	virtual double presentCriticalTimeStep() const = 0; ///< as deformed now, s
	/// System::setMultirate and System::rate.
	virtual void setMultirate(bool on) = 0;
	virtual int rate(int g) const = 0;
	virtual double kickTime(double dt) const = 0; ///< System::kickTime
	/// System::setInterfaceRange.
	virtual void setInterfaceRange(double range) = 0;
	virtual double interfaceRange() const = 0;
	virtual double slowestWave() const = 0;       ///< smallest speed of pressure waves, m/s
	virtual double pointSpacing(int g) const = 0; ///< dr, m
	virtual void updateForces(int threads) = 0;   ///< throws StepError
	virtual bool isRigid(int g) const = 0;        ///< moves as a rigid body
	virtual bool isAsleep(int g) const = 0;       ///< at rest, and left as it is

	virtual std::unique_ptr<PairContacts> newPair() const = 0;
	/// Of the grain `first` and the image of the other.
	virtual void search(PairContacts& pair, int first, int second,
			    const ImageDescription& image, double dt) const = 0;
	virtual void search(PairContacts& pair, int g, const WallDescription& wall,
			    double dt) const = 0;
	/// A body that checkRigidBody refuses counts as an infinite overlap.
	virtual void search(PairContacts& pair, int g, const RigidBodyDescription& body,
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

	/// Another load than before wakes a sleeping grain, and so does `moveRigidly`.
	virtual void setLoad(int g, const Vec3& acceleration, const Vec3& angularAcceleration) = 0;
	virtual GrainMotion motion(int g) const = 0;
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
	virtual PointFields points(int g) const = 0;
	virtual double undeformedVolume(int g) const = 0; ///< m^2 (m^3)
	/// Of the background nodes, `dim` numbers a node.
	virtual std::vector<double> nodePositions(int g) const = 0;
	virtual std::vector<double> nodeVelocities(int g) const = 0;
	/// Present state and its origin as GrainDescription takes them.
	virtual GrainState state(int g, Vec3& origin) const = 0;
};

} // namespace softgrain
