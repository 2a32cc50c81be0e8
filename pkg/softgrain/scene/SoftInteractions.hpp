// The interactions of soft grains in a step: what the InteractionLoop found is brought up to date
// and checked, and gets the forces that were solved.
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <memory>
#include <set>
#include <vector>

namespace yade {

class RigidPartners;
class SoftGrain;

/// Interactions of a scene by the ids of their bodies, an order that seldom changes from step to
/// step.
class InteractionOrder {
public:
	/// Of those for which the function holds.
	template <class Belongs>
	const std::vector<Interaction*>& of(InteractionContainer& all, const Belongs& belongs);

private:
	static bool isBefore(const Interaction* a, const Interaction* b);
	/// What stands at an address may be another interaction by now.
	bool isSorted() const;

	std::vector<Interaction*> present_, sortedFrom_, sorted_;
};

/// Made in every step. What a step needs is done in the order in which the functions stand here.
class SoftInteractions {
public:
	/// All real ones, in an order that does not depend on threads. Those of grains that were
	/// added or changed since the InteractionLoop, or moved by the user (ids
	/// `moved`: SoftBodies::applyUserMotions), are searched again. Throws std::runtime_error
	/// for pairs for which there is no contact treatment.
	SoftInteractions(Scene& scene, const std::shared_ptr<softgrain::GrainAssembly>& assembly,
			 InteractionOrder& order, const std::set<int>& moved);

	/// Throws for rigid bodies and interfaces that are not admissible, saying which, and for an
	/// overlap beyond `maxOverlap` (SoftGrainIntegrator.maxOverlap).
	void check(Real maxOverlap) const;
	/// Engines since the InteractionLoop may have changed the flow of the cell, and how walls
	/// move.
	void updateVelocities(const NewtonIntegrator& newton) const;
	/// Tells the pairs the numbers of their rigid bodies.
	void numberPartners(RigidPartners& partners) const;
	const std::vector<softgrain::PairContacts*>& pairs() const { return pairs_; }
	/// To the interactions in parallel, then to O.forces in the order of the interactions.
	void publish(const RigidPartners& partners, int threads) const;

private:
	/// What an interaction does to its bodies. A rigid body (no wall that is a plane) gets its
	/// share by `addReactions`.
	struct PairForce {
		int id1, id2;
		bool rigid1, rigid2;
		Vector3r onBody2; ///< N
	};

	void renew(Interaction& I, const std::set<int>& moved) const;
	const Body& rigidBodyOf(const Interaction& I) const;
	const SoftGrain& softGrainOf(const Interaction& I) const;
	void checkRigidBodies() const;
	void checkWall(const Interaction& I) const;
	void checkInterfaces() const;
	void stopOnOverlap(Real maxOverlap) const;
	void publishSum(const Interaction& I) const;
	PairForce forceOf(const Interaction& I) const;
	void addReactions(const Interaction& I, const RigidPartners& partners) const;

	Scene& scene_;
	std::shared_ptr<softgrain::GrainAssembly> assembly_;
	std::vector<Interaction*> interactions_;
	std::vector<softgrain::PairContacts*> pairs_; ///< of the interactions
};

} // namespace yade
