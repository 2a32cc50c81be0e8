// Soft grains as bodies of YADE: what others did to their State and put into O.forces goes to the
// assembly, and what the step made of the grains comes back to State and to the collider.
#pragma once

#include "scene/PeriodicCell.hpp"

#include <set>

namespace yade {

/// How far the sides of the box of a grain are from its outline when the collider runs, m: `margin`
/// at least, and more where surfaces look farther for each other.
Real roomInBox(const softgrain::GrainAssembly& assembly, int g, Real margin);

/// The bodies of the soft grains of an assembly, for one step.
class SoftBodies {
public:
	SoftBodies(Scene& scene, softgrain::GrainAssembly& assembly)
		: scene_(scene)
		, assembly_(assembly)
	{
	}

	/// Throws std::runtime_error naming a grain whose State the engine leaves out.
	void requireCarried(const NewtonIntegrator& newton) const;
	/// Throws std::runtime_error naming a grain that overlaps itself by more than `maxOverlap`
	/// (SoftGrainIntegrator.maxOverlap), looked for every so many steps.
	void stopOnSelfOverlap(Real maxOverlap, int threads) const;
	/// Changes of State since it was written, as assembleScene has found them in this step, are
	/// the user's: they act as rigid motions. A grain shifted by whole periods of the cell goes
	/// on as its image, and its State with it; returns the ids of all that were moved. Throws
	/// std::runtime_error for values that are no motion.
	std::set<int> applyUserMotions(const CellFlow& flow) const;
	/// Gravity, O.forces and the flow of a periodic cell as body loads. Throws
	/// std::runtime_error naming what is not finite.
	void applyLoads(const NewtonIntegrator& newton, const CellFlow& flow, int threads) const;
	/// NewtonIntegrator, next, adds the flow of a periodic cell to vel and angVel, then vel dt
	/// to pos, and turns ori by angVel dt; it lands on the grain.
	void publishMotion(int g, const CellFlow& flow) const;
	/// The same for grains that sleep, which nobody moves, where State was changed.
	void publishSleepers(const CellFlow& flow) const;
	/// After that: whether an outline is about to leave the box that the collider
	/// knows, which watches State.pos only.
	bool needCollider(int threads) const;

private:
	bool applyUserMotion(int g, const CellFlow& flow) const;
	softgrain::GrainLoad loadOf(int g, const NewtonIntegrator& newton,
				    const CellFlow& flow) const;
	bool isLoadedInPlane(int g) const;
	/// Throws, once a load has been found that is not in the plane of 2D grains.
	[[noreturn]] void refuseLoadsAcrossPlane() const;
	/// Throws, once a load has been found that is not finite.
	[[noreturn]] void refuseLoads(const NewtonIntegrator& newton, const CellFlow& flow) const;
	bool mayHaveMoved(int g) const;
	bool isInItsBox(int g) const;

	Scene& scene_;
	softgrain::GrainAssembly& assembly_;
};

} // namespace yade
