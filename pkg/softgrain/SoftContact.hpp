// Contacts of soft grains as YADE sees them: one interaction per pair of bodies, its many contact
// points in one SoftGeom, solved together by SoftGrainIntegrator.
#pragma once

#include "GrainAssembly.hpp"
#include "SoftGrain.hpp"
#include "SoftMat.hpp"
#include "Yade.hpp"

#include <optional>

namespace yade {

class SoftGeom : public GenericSpheresContact {
public:
	/// Contacts of the pair in `assembly`; its first grain has the lower index.
	std::shared_ptr<softgrain::GrainAssembly> assembly;
	std::unique_ptr<softgrain::PairContacts> pair;

	/// Makes `pair` one of `present`, its impulses taken over from the last assembly or the
	/// saved ones.
	void bind(const std::shared_ptr<softgrain::GrainAssembly>& present);
	void preSave(SoftGeom&);
	py::dict contactArrays() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftGeom, GenericSpheresContact,
		"Contact points of a pair of bodies of which at least one is a :yref:`SoftGrain`. Of the attributes of the base class, *normal* points from #1 to #2, and *contactPoint* is the mean of the contact points.",
		((vector<int>, savedKeys, , Attr::hidden, "side, node, other of each contact point when saved."))
		((vector<Vector3r>, savedImpulses, , Attr::hidden, "Impulses when saved."))
		((vector<Real>, savedRest, , Attr::hidden, "What a sleeping pair goes on from when saved; else empty.")),
		createIndex();,
		.def("contacts", &SoftGeom::contactArrays, "Contact points within reach, a dict of arrays: point (n, 3), in a periodic cell on the side of the grain with the lower index [m], normal (n, 3) on the grain that owns the node, gap (n,) [m], impulse (n, 3) of the last step on that grain [N s], force (n, 3) the same over the time it acted [N, 2D N/m], area (n,) share of the node in the outline [m², 2D m], pressure (n,) and shear (n, 3), the tangential traction, on that grain at the node, from all impulses of the pair averaged over about one spacing of background nodes [Pa] (all three 0 unless the geometry is 'surface'; forces of single nodes scatter, see doc/theory.md), side (n,) 0 if the node belongs to the grain with the lower index, 1 otherwise, node (n,).")
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftGeom, GenericSpheresContact);
};
REGISTER_SERIALIZABLE(SoftGeom);

/// What a soft grain sees of a rigid body with a shape that it can touch; none of another shape,
/// nor of a Wall that is held or moved: that is a plane (softgrain::WallDescription). A free Wall,
/// which has a mass, is the face of a block next to the grain and wider than it.
std::optional<softgrain::RigidBodyDescription> describeRigid(const Shape& shape, const State& state,
							     int id, const SoftGrain& grain);

class SoftPhys : public NormShearPhys {
public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(SoftPhys, NormShearPhys,
		"Friction of a pair, and the sum of its contact forces. *kn* and *ks* are no parameters of the method, which has none: between soft grains they hold the harmonic mean of the Young's moduli times 1 m, for :yref:`GlobalStiffnessTimeStepper` only; with a free rigid body 0, since contact does not limit its time step; with one that is held or moved the Young's modulus times 1 m (3D: times the grain's diameter), about the stiffness of the grain, for :yref:`TriaxialStressController`.",
		((Real, tangensOfFrictionAngle, 0, , "Coefficient of Coulomb friction μ, ≥ 0 [-]."))
		((int, contacts, 0, Attr::readonly, "Contact points within reach. |yupdate|"))
		((int, activeContacts, 0, Attr::readonly, "Contact points that carry force. |yupdate|")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftPhys, NormShearPhys);
};
REGISTER_SERIALIZABLE(SoftPhys);

class Ig2_SoftGrain_SoftGrain_SoftGeom : public IGeomFunctor {
public:
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;
	FUNCTOR2D(SoftGrain, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(SoftGrain, SoftGrain);
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(
		Ig2_SoftGrain_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of two :yref:`SoftGrains<SoftGrain>`.", ,
		timingDeltas.reset(new TimingDeltas););
};
REGISTER_SERIALIZABLE(Ig2_SoftGrain_SoftGrain_SoftGeom);

class Ig2_Wall_SoftGrain_SoftGeom : public IGeomFunctor {
public:
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;
	FUNCTOR2D(Wall, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Wall, SoftGrain);
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(
		Ig2_Wall_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Wall`, "
		"which moves as its :yref:`State.vel` says.",
		, timingDeltas.reset(new TimingDeltas););
};
REGISTER_SERIALIZABLE(Ig2_Wall_SoftGrain_SoftGeom);

class Ig2_Sphere_SoftGrain_SoftGeom : public IGeomFunctor {
public:
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;
	FUNCTOR2D(Sphere, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Sphere, SoftGrain);
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(
		Ig2_Sphere_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Sphere` that is free, "
		"held, "
		"moved, or member of a clump. In 2D the sphere is a disk in the plane of the "
		"grains, "
		"with the mass and inertia of its :yref:`State`; see sg.as_disks().",
		, timingDeltas.reset(new TimingDeltas););
};
REGISTER_SERIALIZABLE(Ig2_Sphere_SoftGrain_SoftGeom);

class Ig2_Facet_SoftGrain_SoftGeom : public IGeomFunctor {
public:
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;
	FUNCTOR2D(Facet, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Facet, SoftGrain);
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(Ig2_Facet_SoftGrain_SoftGeom, IGeomFunctor,
				       "Finds the contact points of a :yref:`SoftGrain` on a "
				       ":yref:`Facet`, which is touched "
				       "from both sides and has no thickness. In 2D the facet is "
				       "the segment in which it cuts "
				       "the plane of the grains.",
				       , timingDeltas.reset(new TimingDeltas););
};
REGISTER_SERIALIZABLE(Ig2_Facet_SoftGrain_SoftGeom);

class Ig2_Box_SoftGrain_SoftGeom : public IGeomFunctor {
public:
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;
	FUNCTOR2D(Box, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Box, SoftGrain);
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(Ig2_Box_SoftGrain_SoftGeom, IGeomFunctor,
				       "Finds the contact points of a :yref:`SoftGrain` on a "
				       ":yref:`Box`. In 2D the box is a "
				       "rectangle, turned about z only. In 3D an edge of the box "
				       "is felt at contact nodes and "
				       "by the corners of the box.",
				       , timingDeltas.reset(new TimingDeltas););
};
REGISTER_SERIALIZABLE(Ig2_Box_SoftGrain_SoftGeom);

class Ip2_SoftMat_SoftMat_SoftPhys : public IPhysFunctor {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&,
		const shared_ptr<Interaction>&) override;
	FUNCTOR2D(SoftMat, SoftMat);
	YADE_CLASS_BASE_DOC(Ip2_SoftMat_SoftMat_SoftPhys, IPhysFunctor,
			    "Friction of two soft grains: μ = tan(min(φ₁, φ₂)).");
};
REGISTER_SERIALIZABLE(Ip2_SoftMat_SoftMat_SoftPhys);

class Ip2_FrictMat_SoftMat_SoftPhys : public IPhysFunctor {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&,
		const shared_ptr<Interaction>&) override;
	FUNCTOR2D(FrictMat, SoftMat);
	YADE_CLASS_BASE_DOC(Ip2_FrictMat_SoftMat_SoftPhys, IPhysFunctor,
			    "Friction of a rigid body and a soft grain: μ = tan(min(φ₁, φ₂)).");
};
REGISTER_SERIALIZABLE(Ip2_FrictMat_SoftMat_SoftPhys);

class Law2_SoftGeom_SoftPhys_Nonsmooth : public LawFunctor {
public:
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	FUNCTOR2D(SoftGeom, SoftPhys);
	YADE_CLASS_BASE_DOC(Law2_SoftGeom_SoftPhys_Nonsmooth, LawFunctor,
			    "Unilateral contact with Coulomb friction, without stiffness. It keeps "
			    "the books of the pair; all contacts of the step are solved together "
			    "by :yref:`SoftGrainIntegrator`.");
};
REGISTER_SERIALIZABLE(Law2_SoftGeom_SoftPhys_Nonsmooth);

} // namespace yade
