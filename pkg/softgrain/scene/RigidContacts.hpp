// Contacts of rigid bodies with each other in a step: from YADE's interactions to the kernel, and
// the forces back (doc/decisions/0020-rigid-contact-dynamics.md).
#pragma once

#include "Yade.hpp"
#include "assembly/RigidDescriptions.hpp"

#include <boost/weak_ptr.hpp>
#include <cstdint>
#include <utility>
#include <vector>

namespace yade {

class Law2_ScGeom_FrictPhys_Nonsmooth;
class RigidPartners;

/// The interactions under Law2_ScGeom_FrictPhys_Nonsmooth. What a step needs is done in the order
/// in which the functions stand here.
class RigidContacts {
public:
	/// Lists them in the order of the sweeps, which must not depend on threads. Where O.engines
	/// have another object of the law than in the last step, those of the former one are among
	/// them, and other interactions of rigid bodies are left to be made anew. Throws
	/// std::runtime_error for a sphere too large for the periodic cell.
	void list(const Scene& scene);
	/// Whether O.engines had the law when listed.
	bool hasLaw() const { return !law_.expired(); }

	/// Describes the contacts, with the impulses of the last step, and numbers their bodies.
	/// Throws std::runtime_error for pairs that cannot be treated, and for an overlap beyond
	/// `maxOverlap` (SoftGrainIntegrator.maxOverlap).
	void describe(const Scene& scene, RigidPartners& partners, Real maxOverlap);
	/// Largest overlap of two bodies so described, over the smaller radius.
	Real deepestOverlap() const;
	/// The step leaves the impulses that it found in them.
	std::vector<softgrain::RigidContactDescription>& descriptions() { return contacts_; }
	/// Forces to FrictPhys, and their sums in the order of the sweeps on the bodies.
	void publish(Scene& scene);

private:
	struct Listed {
		std::uint64_t ids; ///< of its bodies, the lower one first
		Interaction* interaction;

		bool operator==(const Listed& other) const
		{
			return ids == other.ids && interaction == other.interaction;
		}
	};
	/// Bodies of an interaction: its two or, if both are spheres, the other way round where
	/// that puts the lower id first, since YADE's order may depend on threads.
	struct Pair {
		const Body *first, *second;
		bool twoSpheres, swapped;
	};
	struct Reaction {
		Vector3r force = Vector3r::Zero(), torque = Vector3r::Zero();
	};

	static Pair pairOf(const Interaction& I, const Scene& scene);
	static void requireTreatable(const Interaction& I, const Pair& pair);
	void stopOnOverlap(const RigidPartners& partners, Real maxOverlap) const;
	void leaveSeamsOut();
	void listContactsOnPlates();
	bool isSeam(const softgrain::RigidContactDescription& d, int sphere) const;
	void addReaction(const Body& body, const Vector3r& arm, const Vector3r& force);

	boost::weak_ptr<Law2_ScGeom_FrictPhys_Nonsmooth> law_; ///< that of O.engines when listed
	/// As YADE keeps them: now, and when `interactions_` were sorted.
	std::vector<Listed> found_, kept_;
	std::vector<Listed> interactions_;                         ///< in the order of the sweeps
	std::vector<Pair> pairs_;                                  ///< one for each
	std::vector<softgrain::RigidContactDescription> contacts_; ///< one for each
	std::vector<std::pair<int, int>> onPlates_; ///< spheres by id, contact on a facet or box
	std::vector<Reaction> reactions_;           ///< by id of the body
};

} // namespace yade
