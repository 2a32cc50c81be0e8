// Contact dynamics of rigid bodies with each other as YADE sees it: its own ScGeom and FrictPhys,
// functors that find pairs before they touch, and a law that leaves the rest to
// SoftGrainIntegrator.
#pragma once

#include "Yade.hpp"

#include <atomic>

namespace yade {

/// Pairs are held within this gap, over the radius of the (smaller) sphere: a gap that may close
/// in a step must be known before it has closed.
constexpr Real nonsmoothReach = 0.05;

#define SOFTGRAIN_AHEAD_FUNCTOR(Shape1, Base, Name)                                                \
	class Name : public Base {                                                                 \
	public:                                                                                    \
		bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,          \
			const State&, const Vector3r& shift2, const bool& force,                   \
			const shared_ptr<Interaction>&) override;                                  \
		FUNCTOR2D(Shape1, Sphere);                                                         \
		DEFINE_FUNCTOR_ORDER_2D(Shape1, Sphere);                                           \
		YADE_CLASS_BASE_DOC(                                                               \
			Name, Base,                                                                \
			"As :yref:`" #Base "`, but makes the interaction while the bodies are "    \
			"still apart by up to a twentieth of the (smaller) sphere's radius, as "   \
			":yref:`Law2_ScGeom_FrictPhys_Nonsmooth` needs it; "                       \
			":yref:`ScGeom.penetrationDepth` is negative then. The collider must "     \
			"find them that early: ``Bo1_Sphere_Aabb(aabbEnlargeFactor=1.05)``.");     \
	};                                                                                         \
	REGISTER_SERIALIZABLE(Name);
SOFTGRAIN_AHEAD_FUNCTOR(Sphere, Ig2_Sphere_Sphere_ScGeom, Ig2_Sphere_Sphere_ScGeom_Ahead)
SOFTGRAIN_AHEAD_FUNCTOR(Facet, Ig2_Facet_Sphere_ScGeom, Ig2_Facet_Sphere_ScGeom_Ahead)
SOFTGRAIN_AHEAD_FUNCTOR(Box, Ig2_Box_Sphere_ScGeom, Ig2_Box_Sphere_ScGeom_Ahead)
SOFTGRAIN_AHEAD_FUNCTOR(Wall, Ig2_Wall_Sphere_ScGeom, Ig2_Wall_Sphere_ScGeom_Ahead)
#undef SOFTGRAIN_AHEAD_FUNCTOR

class Law2_ScGeom_FrictPhys_Nonsmooth : public LawFunctor {
public:
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	FUNCTOR2D(ScGeom, FrictPhys);
	YADE_CLASS_BASE_DOC_ATTRS(
		Law2_ScGeom_FrictPhys_Nonsmooth, LawFunctor,
		"Contact dynamics of a :yref:`Sphere`, free, held or member of a clump, with a "
		":yref:`Sphere`, :yref:`Facet`, :yref:`Box` or :yref:`Wall`: unilateral contact "
		"with Coulomb friction, without stiffness "
		"(:yref:`NormShearPhys.kn` and *ks* are not used). It keeps the books of the "
		"pair; all contacts of the step, those of soft grains among them, are solved "
		"together by :yref:`SoftGrainIntegrator`, which puts the forces into "
		":yref:`NormShearPhys.normalForce` and *shearForce* and on both bodies. It is "
		"meant for interactions that exist before bodies touch: see "
		":yref:`Ig2_Sphere_Sphere_ScGeom_Ahead` and its like.",
		((shared_ptr<MatchMaker>, restitution, , ,
		  "Coefficient of restitution e by pair of materials, in [0, 1] [-]; a number "
		  "stands for all pairs, None for 0: what comes into contact in a step leaves with "
		  "e times the normal speed at which it came (Newton). Bodies that rest on each "
		  "other are not shaken by it. Values are checked in the step.")));
	DECLARE_LOGGER;

private:
	/// Whether O.engines still have such a law: interactions keep the functors that they began
	/// with.
	bool isInUse();

	/// Whether it was looked who solves the contacts; pairs come in parallel.
	std::atomic<bool> checked_ { false };
	/// Twice the step in which it was asked last, plus the answer.
	std::atomic<long> inUse_ { -1 };
};
REGISTER_SERIALIZABLE(Law2_ScGeom_FrictPhys_Nonsmooth);

/// The law where O.engines have it, and what calls it; null where they have not.
struct NonsmoothLaw {
	shared_ptr<Law2_ScGeom_FrictPhys_Nonsmooth> law;
	shared_ptr<LawDispatcher> dispatcher;
};
NonsmoothLaw nonsmoothLawOf(const Scene& scene);

} // namespace yade
