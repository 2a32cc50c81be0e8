#pragma once

#include "Yade.hpp"
#include "scene/EngineScene.hpp"

#include <limits>

namespace yade {

class WallStressController : public GlobalEngine {
public:
	void action() override;
	/// Checks all attributes; throws std::invalid_argument (ValueError in Python).
	void postLoad(WallStressController&);
	Vector3r stress();
	Vector3r strain();

	/// What of the soft grains of a scene the motion of a wall goes by.
	struct Packing {
		Real impedance = 0;                                  ///< largest rho c, Pa s/m
		Real density = 0;                                    ///< largest one, kg/m^3
		Real radius = std::numeric_limits<Real>::infinity(); ///< smallest one, m
	};

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(WallStressController, GlobalEngine,
		"Loads soft grains in a box of :yref:`walls<Wall>` or :yref:`boxes<Box>`, along each axis by a given stress or strain rate, as :yref:`TriaxialStressController` does for spheres. The upper wall of each pair moves, the lower one stays as it is. A wall under stress is a free rigid body with one degree of freedom: it is pushed by stress times the present area between the other walls, and slowed down by a dashpot; what it takes to reach the stress comes out of the same contact dynamics as everything else, and once it is at rest the stress is held exactly, whatever the stiffness of the packing. Its weight is taken off; its mass is *drag* ρ A R, as they are in each step, with R of the smallest grain, unless the script gives it another one while it is pushed. Once it is pushed no more, as this engine is dead or gone, it is held again where it is, with a warning; a velocity that it is given then counts. This engine stands between :yref:`InteractionLoop` and :yref:`SoftGrainIntegrator`. Doc: doc/decisions/0023-laboratory-loading.md.",
		((vector<int>, walls, , Attr::triggerPostLoad, "Ids of the walls: lower and upper one along x, along y and, in 3D, along z: 4 or 6."))
		((Vector3r, goal, Vector3r::Zero(), Attr::triggerPostLoad, "Along each axis the stress, ≤ 0 (tension is positive, as for :yref:`TriaxialStressController`) [Pa], or the rate of logarithmic strain, negative for compression [1/s]; see *stressMask*. May be changed while running."))
		((int, stressMask, 7, Attr::triggerPostLoad, "Axes along which *goal* is a stress: sum of 1 (x), 2 (y), 4 (z); in [0, 7]."))
		((Real, drag, 1, Attr::triggerPostLoad, "Dashpot of a wall under stress over the largest impedance ρ c of a grain (:yref:`SoftMat.waveImpedance`) times the area, > 0 [-]. 1 swallows waves that come back from the packing; before it touches, the wall moves with stress/(drag ρ c)."))
		((vector<Real>, initialLengths, , Attr::readonly, "Distances of the walls when this engine first ran [m]. |yupdate|")),
		,
		.def("stress", &WallStressController::stress, "Stress of the contacts on the walls in the last step along x, y and z, mean of both walls, tension positive [Pa].")
		.def("strain", &WallStressController::strain, "Logarithmic strain along x, y and z since this engine first ran, compression negative [-].")
	);
	// clang-format on

private:
	void lookAtPresentScene();
	int axes() const { return static_cast<int>(walls.size()) / 2; }
	Body& wall(int axis, bool upper) const;
	Real length(int axis) const;
	Real area(int axis) const;
	void checkWalls() const;
	void checkAlone() const;
	void pushWall(int axis, const Packing& packing);
	void requireStable(const Body& body, Real least) const;
	void moveWall(int axis);

	EngineScene ownScene_;
};
REGISTER_SERIALIZABLE(WallStressController);

/// Sum of the contact forces on a body in the last step, from its interactions, N.
Vector3r contactForceOn(const Body& body);

} // namespace yade
