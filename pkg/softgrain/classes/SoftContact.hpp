// Contacts of soft grains as YADE sees them: one interaction per pair of bodies, its many contact
// points in one SoftGeom, found by the functors of SoftSearch.hpp and solved together by
// SoftGrainIntegrator.
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"
#include "classes/SoftMat.hpp"

namespace yade {

class SoftGeom : public GenericSpheresContact {
public:
	/// Contacts of the pair in `assembly`; its first grain has the lower index.
	std::shared_ptr<softgrain::GrainAssembly> assembly;
	std::unique_ptr<softgrain::PairContacts> pair;

	/// Makes `pair` one of `present`, where `first` is its first grain, its impulses taken over
	/// from the last assembly or the saved ones.
	void bind(const std::shared_ptr<softgrain::GrainAssembly>& present, int first);
	void preSave(SoftGeom&);
	/// Id of the body that contact points of side 0 belong to; -1 before a search.
	int firstBody() const;
	py::dict contactArrays() const;
	int bondTouching();
	int wholeBonds() const; ///< bonds that hold

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftGeom, GenericSpheresContact,
		"Contact points of a pair of bodies of which at least one is a :yref:`SoftGrain`. Of the attributes of the base class, *normal* points from #1 to #2: the mean of the normals of all contact points by the size of their forces, from centre to centre while there is no force. *contactPoint* is the mean of the contact points by the size of their normal forces, *refR1* and *refR2* are the distances from there to the centres along the normal (of a :yref:`Sphere` its radius; :yref:`Wall`, :yref:`Facet` and :yref:`Box` have that of the grain), radii while there is no force. Functions of YADE that take a pair for two spheres (:yref:`Gl1_NormPhys`, :yref:`yade.utils.fabricTensor`) find force chains in them.",
		((int, savedFirst, Body::ID_NONE, Attr::hidden, "Id of the first body of the pair when saved."))
		((vector<int>, savedKeys, , Attr::hidden, "side, node, other of each contact point when saved."))
		((vector<Vector3r>, savedImpulses, , Attr::hidden, "Impulses when saved."))
		((vector<Vector3r>, savedNormals, , Attr::hidden, "Normals when saved."))
		((vector<Real>, savedTwists, , Attr::hidden, "Turns about them in the step after they were solved, when saved [rad]."))
		((Real, savedAccount, 0, Attr::hidden, "What overlaps have lately taken from the bodies, when saved [J]."))
		((int, savedGrace, softgrain::stepsOfAccount, Attr::hidden, "Steps left, when saved, in which overlaps that were there from the start are worked off at full speed."))
		((vector<Real>, savedRest, , Attr::hidden, "What a pair of which a grain sleeps goes on from when saved; else empty."))
		((vector<Real>, savedInterface, , Attr::hidden, "What an interface law remembers when saved; else empty.")),
		createIndex();,
		.def("contacts", &SoftGeom::contactArrays, "Contact points within reach, a dict of arrays: point (n, 3), in a periodic cell beside the grain *first* [m], normal (n, 3) on the grain that owns the node, gap (n,) [m], impulse (n, 3) of the last step on that grain, reaction and tractions of :yref:`SoftInterface` together [N s], force (n, 3) the same over the time it acted [N, 2D N/m], area (n,) share of the node in the outline [m², 2D m], pressure (n,) and shear (n, 3), the tangential traction, on that grain at the node, from all impulses of the pair averaged over about one spacing of background nodes [Pa] (all three 0 unless the geometry is 'surface'; forces of single nodes scatter, see doc/theory.md), side (n,) 0 if the node belongs to the grain *first*, 1 otherwise, node (n,), -1 where two sharp edges cross, which stand for no area, bond (n,) 0 if there never was one, 1 while it holds, 2 once it is broken, damage (n,) of the bond in [0, 1].")
		.add_property("first", &SoftGeom::firstBody, "Id of the grain that contact points of side 0 belong to; -1 before a search.")
		.def("bond", &SoftGeom::bondTouching, "Bond the contact points that touch now (gap below a hundredth of the spacing of material points, or a force in the last step), whatever they were before; returns their number. 0 unless :yref:`SoftPhys.interface` has a bondStrength and a step has been made with it; RuntimeError where no step was made since O.load.")
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftGeom, GenericSpheresContact);

private:
	bool isSavedWhole() const;
	std::vector<softgrain::ContactRecord> savedRecords() const;
};
REGISTER_SERIALIZABLE(SoftGeom);

class SoftInterface : public Serializable {
public:
	softgrain::InterfaceLaw law() const
	{
		return { tangensOfDynamicFrictionAngle,
			 cohesion,
			 cohesionRange,
			 bondStrength,
			 bondEnergy,
			 bondStiffness,
			 bondAtTouch,
			 restitution };
	}

	void check(Real friction) const { law().validate(friction); }

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftInterface, Serializable,
		"What the surfaces of a pair do to each other besides unilateral contact with one coefficient of friction: dynamic friction, cohesion, bonds, restitution; those that are 0 do not act. Values are checked in the step, which refuses what is not admissible. Cohesion and bonds need grains with contact = 'surface' and :yref:`SoftGrainIntegrator.interfaceRange`. See doc/theory.md, Interfaces.",
		((Real, tangensOfDynamicFrictionAngle, -1, , "Coefficient of friction μ_d of contact points that slid in the last step, in [0, μ_s] [-]; those that stuck have μ_s = :yref:`SoftPhys.tangensOfFrictionAngle`. A point that carries less than μ_d times its pressure sticks again. Negative: μ_s for all."))
		((Real, cohesion, 0, , "Constant traction σ_c by which the surfaces attract each other wherever they are nearer than *cohesionRange*, ≥ 0 [Pa] (Dugdale). Work of separation: σ_c × cohesionRange."))
		((Real, cohesionRange, 0, , "Gap δ up to which *cohesion* acts, > 0 where it does [m]."))
		((Real, bondStrength, 0, , "Largest traction of a bond, ≥ 0 [Pa]; 0: there are no bonds."))
		((Real, bondEnergy, 0, , "Energy to break a bond, in whatever mixture of opening and slip, > 0 where there are bonds [J/m²]; its traction falls to nothing at the opening 2 bondEnergy/bondStrength."))
		((Real, bondStiffness, 0, , "Traction over opening (and slip) of an undamaged bond, > bondStrength²/(2 bondEnergy) [Pa/m]; 0: such that *bondStrength* is met at a tenth of the final opening. Stiff bonds shorten the critical time step, which knows of them."))
		((bool, bondAtTouch, true, , "Whether contact points bond as soon as they touch. A broken bond does not form again before its point has been out of reach. False: only by SoftGeom.bond()."))
		((Real, restitution, 0, , "Coefficient of restitution e, in [0, 1] [-], between a soft grain and a rigid body: what comes into contact in a step leaves with e times the speed at which it came, point by point.")),
		/* ctor */,
		.def("check", &SoftInterface::check, "ValueError naming the attribute that is not admissible beside a coefficient of static friction, the argument [-].")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(SoftInterface);

class SoftPhys : public NormShearPhys {
public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(SoftPhys, NormShearPhys,
		"Friction of a pair, and the sum of its contact forces. *kn* and *ks* are no parameters of the method, which has none: between soft grains they hold the harmonic mean of the Young's moduli times 1 m, for :yref:`GlobalStiffnessTimeStepper` only; with a free rigid body 0, since contact does not limit its time step; with one that is held or moved ρ c A/dt (c the speed of pressure waves, A the square of the grain's diameter, in 2D its diameter), the change of the force over the way of the wall within a step, for :yref:`TriaxialStressController`.",
		((Real, tangensOfFrictionAngle, 0, , "Coefficient of Coulomb friction μ, ≥ 0 [-]; with an *interface* that has a dynamic one: of contact points that stick."))
		((shared_ptr<SoftInterface>, interface, , , "What acts besides; None: nothing."))
		((int, contacts, 0, Attr::readonly, "Contact points within reach. |yupdate|"))
		((int, activeContacts, 0, Attr::readonly, "Contact points that carry force. |yupdate|")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftPhys, NormShearPhys);
};
REGISTER_SERIALIZABLE(SoftPhys);

/// What the functors of both kinds of pairs have in common.
class Ip2_SoftPhys : public IPhysFunctor {
public:
	/// Gives the interaction its SoftPhys. Throws nothing: the step checks the values.
	void makePhys(const shared_ptr<Interaction>& I, const Material& m1, const Material& m2,
		      Real frictionAngle1, Real frictionAngle2, Real stiffness) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Ip2_SoftPhys, IPhysFunctor,
		"Parameters by pair of materials, read when the contact is made; a number stands for all pairs. Where a pair has no match and the algorithm of the MatchMaker is not 'val', the friction angle is computed from those of the materials (0 by 'zero'), and the others are as if they were not given. See :yref:`SoftInterface` for their meaning; sg.engines(interface=) sets both functors.",
		((shared_ptr<MatchMaker>, frictAngle, , , "Angle of friction φ [rad]; None: min(φ₁, φ₂). μ = tan φ."))
		((shared_ptr<MatchMaker>, dynamicFrictAngle, , , "Angle of dynamic friction, ≤ φ [rad]; None: φ."))
		((shared_ptr<MatchMaker>, cohesion, , , ":yref:`SoftInterface.cohesion` [Pa]."))
		((shared_ptr<MatchMaker>, cohesionRange, , , ":yref:`SoftInterface.cohesionRange` [m]."))
		((shared_ptr<MatchMaker>, bondStrength, , , ":yref:`SoftInterface.bondStrength` [Pa]."))
		((shared_ptr<MatchMaker>, bondEnergy, , , ":yref:`SoftInterface.bondEnergy` [J/m²]."))
		((shared_ptr<MatchMaker>, bondStiffness, , , ":yref:`SoftInterface.bondStiffness` [Pa/m]."))
		((bool, bondAtTouch, true, , ":yref:`SoftInterface.bondAtTouch`."))
		((shared_ptr<MatchMaker>, restitution, , , ":yref:`SoftInterface.restitution` [-]; of pairs with a rigid body only."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(Ip2_SoftPhys);

class Ip2_SoftMat_SoftMat_SoftPhys : public Ip2_SoftPhys {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&,
		const shared_ptr<Interaction>&) override;
	FUNCTOR2D(SoftMat, SoftMat);
	YADE_CLASS_BASE_DOC(Ip2_SoftMat_SoftMat_SoftPhys, Ip2_SoftPhys,
			    "Friction, cohesion and bonds of two soft grains.");
};
REGISTER_SERIALIZABLE(Ip2_SoftMat_SoftMat_SoftPhys);

class Ip2_FrictMat_SoftMat_SoftPhys : public Ip2_SoftPhys {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&,
		const shared_ptr<Interaction>&) override;
	FUNCTOR2D(FrictMat, SoftMat);
	YADE_CLASS_BASE_DOC(
		Ip2_FrictMat_SoftMat_SoftPhys, Ip2_SoftPhys,
		"Friction, cohesion, bonds and restitution of a rigid body and a soft grain.");
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
