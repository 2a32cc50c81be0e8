// Rigid bodies in the contacts of a step: what NewtonIntegrator will do with them, and what the
// step does to them besides.
#pragma once

#include "assembly/RigidDescriptions.hpp"
#include "scene/PeriodicCell.hpp"

#include <vector>

namespace yade {

/// The bodies that touch something in the step at hand, numbered as contacts name them. A member of
/// a clump stands for its clump, whose motion it has.
class RigidPartners {
public:
	/// Forgets those of the last step. `flow` is that of the cell in the step at hand, `kick`
	/// (s) the time for which loads act in it; scene and integrator must outlive the step.
	/// O.forces hold by now all that acts on the bodies besides contact dynamics.
	void begin(Scene& scene, const NewtonIntegrator& newton, const CellFlow& flow, Real kick);

	/// Number of a body, which is described when first asked for. Throws std::runtime_error for
	/// one that NewtonIntegrator would not move by exactly the impulses it gets.
	int numberOf(const Body& body);
	/// The body itself or its clump.
	const Body& moverOf(const Body& body) const;
	/// Those that touch nothing as well, for a balance of energies that knows their flight, but
	/// for those that NewtonIntegrator damps.
	/// They fly as they would without: loads act for O.dt.
	void addFreeBodies();
	/// Whether forces change the motion of a body.
	bool isFree(const Body& body) const;

	/// By number; the step leaves in them how far bodies that overlap are to be moved apart.
	std::vector<softgrain::RigidMotionDescription>& motions() { return motions_; }
	bool isHeld(int number) const;
	/// NewtonIntegrator lets loads act for O.dt: where that has changed, what is missing to the
	/// kick, or too much, is added to O.forces.
	void publishLoads() const;
	/// Out of overlaps, besides what NewtonIntegrator will do; it takes members of clumps
	/// along.
	void moveApart() const;

private:
	struct Load {
		Real kick;                                                    ///< s
		Vector3r force = Vector3r::Zero(), torque = Vector3r::Zero(); ///< N, N m
	};

	int numberOfMover(const Body& mover, Real kick);
	softgrain::RigidMotionDescription motionOf(const Body& body, Load& load) const;

	Scene* scene_ = nullptr;
	const NewtonIntegrator* newton_ = nullptr;
	CellFlow flow_;
	Real kick_ = 0; ///< s
	std::vector<softgrain::RigidMotionDescription> motions_;
	std::vector<Load> loads_;   ///< by number; of held bodies none
	std::vector<int> movers_;   ///< ids of the bodies that move so
	std::vector<int> numberOf_; ///< by id; -1: none
};

} // namespace yade
