// The functors that find the contact points of soft grains, for YADE's InteractionLoop.
#pragma once

#include "Yade.hpp"
#include "assembly/RigidDescriptions.hpp"
#include "classes/SoftGrain.hpp"

#include <array>
#include <optional>

namespace yade {

/// What a soft grain sees of a rigid body with a shape that it can touch; none of another shape,
/// nor of a Wall that is held or moved: that is a plane (softgrain::WallDescription). A free Wall,
/// which has a mass, is the face of a block next to the grain and wider than it.
std::optional<softgrain::RigidBodyDescription> describeRigid(const Shape& shape, const State& state,
							     int id, const SoftGrain& grain);

/// In space.
std::array<Vector3r, 3> cornersOf(const Facet& facet, const State& state);

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

/// What the functors for rigid shapes (#1) have in common. YADE does not know of it: to dispatch,
/// saving and Python each of them is an IGeomFunctor.
class SearchOnRigid : public IGeomFunctor {
public:
	SearchOnRigid() { timingDeltas.reset(new TimingDeltas); }
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
		const Vector3r& shift2, const bool& force, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&,
		       const State&, const Vector3r& shift2, const bool& force,
		       const shared_ptr<Interaction>&) override;

private:
	/// Whether a shape is of the class that the functor was chosen for.
	virtual bool isFor(const Shape& shape) const = 0;
	/// Finds the contact points of a grain whose assembly is there. Returns the normal from the
	/// body to the grain, by which the pair is described as long as it bears nothing.
	virtual Vector3r search(const Shape& shape, const State& rigid, const SoftGrain& grain,
				const State& soft, Interaction& I,
				softgrain::PairContacts& pair) const;
};

/// The same, knowing the class of its shape: shapes may be exchanged while functors are kept.
template <class Rigid> class SearchOn : public SearchOnRigid {
	bool isFor(const Shape& shape) const override
	{
		return dynamic_cast<const Rigid*>(&shape) != nullptr;
	}
};

class Ig2_Wall_SoftGrain_SoftGeom : public SearchOn<Wall> {
public:
	FUNCTOR2D(Wall, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Wall, SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Wall_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Wall`, which moves as its :yref:`State.vel` says, and turns about its normal as :yref:`State.angVel` does.");
	// clang-format on

private:
	Vector3r search(const Shape& shape, const State& rigid, const SoftGrain& grain,
			const State& soft, Interaction& I,
			softgrain::PairContacts& pair) const override;
};
REGISTER_SERIALIZABLE(Ig2_Wall_SoftGrain_SoftGeom);

class Ig2_Sphere_SoftGrain_SoftGeom : public SearchOn<Sphere> {
public:
	FUNCTOR2D(Sphere, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Sphere, SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Sphere_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Sphere` that is free, held, moved, or member of a clump. In 2D the sphere is a disk in the plane of the grains, with the mass and inertia of its :yref:`State`; see sg.as_disks().");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Sphere_SoftGrain_SoftGeom);

class Ig2_Facet_SoftGrain_SoftGeom : public SearchOn<Facet> {
public:
	FUNCTOR2D(Facet, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Facet, SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Facet_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Facet`, which is touched from both sides and has no thickness. In 2D the facet is the segment in which it cuts the plane of the grains.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Facet_SoftGrain_SoftGeom);

class Ig2_Box_SoftGrain_SoftGeom : public SearchOn<Box> {
public:
	FUNCTOR2D(Box, SoftGrain);
	DEFINE_FUNCTOR_ORDER_2D(Box, SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Box_SoftGrain_SoftGeom, IGeomFunctor,
		"Finds the contact points of a :yref:`SoftGrain` on a :yref:`Box`. In 2D the box is a rectangle, turned about z only. Edges are felt at contact nodes and by points of them, but not where another :yref:`Facet`, :yref:`Box` or :yref:`Wall` goes on (seams).");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Box_SoftGrain_SoftGeom);

} // namespace yade
