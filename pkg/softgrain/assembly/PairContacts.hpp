// The contacts of a pair of bodies as YADE sees them, the dimension of the scene hidden.
#pragma once

#include "Fetch.hpp"
#include "assembly/SpaceVectors.hpp"
#include "contact/Contact.hpp"
#include "contact/Interface.hpp"
#include "contact/OverlapAccount.hpp"
#include "contact/Pressure.hpp"

#include <optional>
#include <string>
#include <vector>

namespace softgrain {

struct ContactRecord {
	ContactKey key;
	Vec3 point, normal, impulse; ///< normal and impulse act on the node's grain
	double gap;
	double twist = 0;         ///< ContactTwist, rad
	Vec3 pull = Vec3::Zero(); ///< impulse of the interface's tractions, besides, N s
	Bond bond = Bond::none;
	double damage = 0; ///< of the bond, in [0, 1]
};

/// What the contacts of a pair do to its first grain together.
struct SumOfImpulses {
	Vec3 normal = Vec3::Zero(), shear = Vec3::Zero(); ///< N s
	Vec3 point = Vec3::Zero(); ///< mean of the contact points by the size of their
	///< normal forces, on the first grain's side, m
	/// Mean of the normals of all contacts by the size of their normal forces, into the first
	/// grain, unit; zero without forces.
	Vec3 direction = Vec3::Zero();
	/// On a rigid body (no wall), about the RigidBodyDescription::position of its image, N m s.
	Vec3 moment = Vec3::Zero();
	int contacts = 0, active = 0; ///< those with an impulse
};

/// Contacts of one pair; its first grain has the lower index.
class PairContacts {
public:
	virtual ~PairContacts() = default;
	static constexpr int size2D = 448; ///< bytes of one in 2D, for those who ask for its memory
	/// Whether there is a contact point within reach, an overlap too deep for one, or a history
	/// to hand on.
	virtual bool isInUse() const = 0;
	/// The pair is asleep, and its impulses in the last step were those of the step before.
	virtual bool isKept() const = 0;
	virtual double deepest() const = 0; ///< largest overlap, in dr
	/// Adds what a search of the pair reads.
	virtual void addMemory(MemoryPieces& memory) const = 0;
	virtual void setFriction(double coefficient) = 0;
	/// In the coming step, of the image of the second body, beyond its own velocity, m/s.
	virtual void setImageVelocity(const Vec3& velocity) = 0;
	/// In the coming step, of the plane that a grain lies against, m/s.
	virtual void setPlaneVelocity(const Vec3& velocity) = 0;
	/// What acts besides friction (none: nothing), valid or not.
	virtual void setInterface(const std::optional<InterfaceLaw>& law) = 0;
	/// Throws std::invalid_argument if law and friction are not admissible for the pair, or if
	/// what it was saved with cannot be read.
	virtual void checkInterface() const = 0;
	/// Bonds the contact points that touch now; returns their number.
	virtual int bondTouching() = 0;
	virtual std::vector<double> interfaceHistory() const = 0; ///< for a save; empty: none
	virtual void restoreInterface(const std::vector<double>& saved) = 0;
	/// With a rigid body (no wall); `partner` is the number of its motion in the coming step.
	virtual bool hasRigidBody() const = 0;
	virtual void setPartner(int partner) = 0;
	virtual int firstGrain() const = 0;
	/// The other grain is the first from now on, in what is restored from it.
	virtual void swapGrains() = 0;
	virtual bool isOfTwoGrains() const = 0;
	virtual SumOfImpulses impulse() const = 0;
	virtual std::vector<ContactRecord> records() const = 0;
	/// Of the last step, one for each record.
	virtual std::vector<ContactPressure> pressures() const = 0;
	virtual double kick() const = 0; ///< time over which the impulses acted, s
	/// Puts saved impulses back; the next search carries them over to the contacts it finds.
	virtual void restore(const std::vector<ContactRecord>& saved) = 0;
	virtual OverlapAccount account() const = 0; ///< for a save
	virtual void restoreAccount(const OverlapAccount& saved) = 0;
	/// What a pair of which a grain sleeps has to be saved with besides its records; else
	/// empty.
	virtual std::vector<double> rest() const = 0;
	/// After `restore`: who sleeps goes on to do so.
	virtual void restoreRest(const std::vector<double>& saved) = 0;
	/// For checkInterface (searches run in parallel, where nothing may be thrown): "it was
	/// saved with", and how many figures.
	virtual void noteUnreadable(const std::string& what, std::size_t figures) = 0;
};

} // namespace softgrain
