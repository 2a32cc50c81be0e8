#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"
#include "scene/StateChange.hpp"

#include <atomic>

namespace yade {

class SoftMat;
struct AssembledMaterial;
struct DrawnOutline;

class SoftGrain : public Shape {
public:
	/// The system this grain computes in, and its index there; null until the scene is
	/// assembled.
	std::shared_ptr<softgrain::GrainAssembly> assembly;
	int index = -1;
	/// What the assembly was built with, to notice changes of the material; shared by grains
	/// of one material that were assembled together.
	std::shared_ptr<const AssembledMaterial> assembledMaterial;
	/// Motion of the whole grain as last written to State, to notice what the user changes.
	softgrain::GrainMotion written;
	Vector3r boundCell = Vector3r::Zero(); ///< Cell.size when the bound was made, m
	/// For renderers: what one last saw, or a step has left since. Set and read atomically.
	std::shared_ptr<const DrawnOutline> drawn;

	softgrain::TemplateRecipe recipe() const;
	softgrain::Scheme scheme() const;
	softgrain::GrainDescription describe(const Body& body) const;
	/// Another one of its shape, in no assembly.
	shared_ptr<SoftGrain> undeformed() const;
	/// Copies the state from the assembly to the saved attributes.
	void fetchState();

	void postLoad(SoftGrain&); ///< checks all attributes, throws std::invalid_argument
	void preSave(SoftGrain&) { fetchState(); }

	py::object outlineArray();
	py::object facetsArray();
	Matrix3r presentInertia();
	py::object nodesArray();
	py::object nodalVelocitiesArray();
	py::dict pointArrays();
	bool movesRigidly();
	bool sleeps();
	py::dict energyDict();
	Real presentVolume();
	Real undeformedVolume();

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftGrain, Shape,
		"Deformable grain: a disk, rectangle, superdisk or polygon (dim = 2, in the xy-plane, all quantities per unit thickness) or a ball or cuboid (dim = 3) solved by the material point method on its own background grid. One grain is one :yref:`Body`; its :yref:`State` holds the motion of the grain as a whole. The attributes are set when the grain is made and do not change.",
		((Real, radius, 1, Attr::readonly, "Radius of the undeformed grain; of a block half its shortest side, of a superdisk its shorter half axis, of a polygon that of the largest circle inside; > 0 [m]."))
		((string, form, "ball", Attr::readonly, "Outline of the undeformed grain: 'ball' (disk in 2D), 'block' (rectangle in 2D, sides along the axes of the grain), in 2D also 'superdisk' (|x/a|ⁿ + |y/b|ⁿ = 1, an ellipse for n = 2) and 'polygon'."))
		((Vector3r, aspect, Vector3r(1, 1, 1), Attr::readonly, "Half sides of a block, half axes of a superdisk over *radius*: the smallest component is 1, the largest at most 100, in 2D the last one is 1; (1, 1, 1) for other forms [-]."))
		((Real, exponent, 2, Attr::readonly, "Exponent n of a superdisk, in [1.25, 20] [-]."))
		((vector<Vector2r>, vertices, , Attr::readonly, "Vertices of a polygon about its centroid over *radius*, counter-clockwise, without crossings; the largest circle inside has radius 1 [-]."))
		((vector<int>, corners, , Attr::readonly, "Those vertices of a polygon at which the outline has a kink, ascending; through the others it runs smoothly."))
		((int, dim, 2, Attr::readonly, "2 or 3."))
		((Real, zeta, 0.11, Attr::readonly, "Relative resolution ζ = 2 dr/D = dr/radius with dr the spacing of material points, in [0.001, 0.5] [-]. Cost grows as ζ⁻³ in 2D; for errors see doc/validation.md."))
		((int, order, 3, Attr::readonly, "Order of the B-splines: 1, 2 or 3."))
		((Real, nodeSpacing, 1.25, Attr::readonly, "Spacing of background nodes h/dr, in [1.25, 4] [-]: larger is coarser and allows longer steps."))
		((Real, surfaceSpacing, 1, Attr::readonly, "Spacing of surface nodes over dr, in [0.5, 4] [-]; above 1 blocks under load sink into each other between nodes, above 1.25 disks, too. Where the grain is coarse (zeta above 0.2 at the default nodeSpacing) they are denser than this says, by up to 0.77."))
		((string, quadrature, "cutCell", Attr::readonly, "Where the material points lie: 'cutCell' (lattice cells cut with the outline, weights exact) or 'lattice' (uniform weights; not for polygons)."))
		((string, contact, "surface", Attr::readonly, "What touches: 'surface' (nodes on the outline against the other outline), "
			"'points' (boundary points as disks of diameter dr) or 'nodes' (nodes of a grid in space that get mass from two bodies; for comparison only)."))
		((string, formulation, "total", Attr::readonly, "'total' (total Lagrangian: grid and shape functions stay in the reference configuration) or 'updated' (updated Lagrangian: a grid fixed in space, shape functions made anew in every step; order 2 or 3). 'updated' is there for comparison: slower and less accurate."))
		((string, velocityUpdate, "nodal", Attr::readonly, "Where velocities live from step to step with formulation 'total': 'nodal' (at the background nodes; conserves energy and angular momentum) or 'flip' (at the material points, mapped to the nodes and back in every step, the classical cycle; for comparison). With formulation 'updated' always at the points."))
		((Real, picShare, 0, Attr::readonly, "Where velocities live at the points: share of the nodal velocity itself (PIC) instead of its change (FLIP) that points take over in a step, in [0, 1] [-]. Damps; doc/decisions/0005-formulations.md."))
		((string, volumetric, "pointwise", Attr::readonly, "How the law sees the change of volume: 'pointwise', or 'projected' on a coarser space of pressures, for Poisson's ratios above 0.48 or so in plane strain and 3D: no oscillating pressures, small contacts not too stiff, at some 1.7 times the cost of the bulk."))
		((string, basis, "splines", Attr::readonly, "What the displacements are made of: 'splines' (B-splines on the background grid) or 'triangles' (linear triangles with sides of about dr that follow the outline: finite elements, for disks, with formulation 'total', velocityUpdate 'nodal' and contact 'surface'). 'triangles' is there for comparison."))
		((Vector3r, stateOrigin, Vector3r::Zero(), Attr::hidden, "Origin of savedPositions."))
		((vector<Real>, savedPositions, , Attr::hidden, "Positions of the state (GrainState) relative to stateOrigin as last fetched."))
		((vector<Real>, savedVelocities, , Attr::hidden, "Velocities of the state as last fetched."))
		((vector<Real>, savedGradients, , Attr::hidden, "Deformation gradients of the state as last fetched (formulation 'updated')."))
		((vector<Real>, savedRigidMotion, , Attr::hidden, "Motion of a grain that moves rigidly as last fetched; else empty."))
		((vector<Real>, savedForces, , Attr::hidden, "Forces that act beyond the next step (SoftGrainIntegrator.multirate) as last fetched; else empty."))
		((vector<Real>, savedStiffening, , Attr::hidden, "How much deformation shortens the critical time step, as last measured; else empty."))
		((vector<Real>, savedRest, , Attr::hidden, "What a grain that comes to rest or sleeps goes on from, as last fetched; else empty."))
		((vector<Real>, savedSleep, , Attr::hidden, "Load and number of pairs with which a grain sleeps as last fetched; else empty.")),
		createIndex();,
		.def("outline", &SoftGrain::outlineArray, "Present positions of the contact nodes, in 2D counter-clockwise: array (n, 3) [m]. A change of *State* by a script, which acts in the next step, is in this and all that is read of the grain already.")
		.def("facets", &SoftGrain::facetsArray, "Facets of the outline, as indices of *outline()*: array (n, dim) of int; in 2D the segments in order around the grain, in 3D triangles with the normal outwards. None (0, dim) with contact 'points'.")
		.def("inertia", &SoftGrain::presentInertia, "Present tensor of inertia about the centre of mass, axes of space [kg m²]; in 2D about z alone [kg m]. :yref:`State.inertia` has its mean.")
		.def("nodes", &SoftGrain::nodesArray, "Present positions of the background nodes (formulation 'updated': of the material points, since nodes keep nothing): array (n, dim) [m].")
		.def("nodeVelocities", &SoftGrain::nodalVelocitiesArray, "Velocities of the background nodes (formulation 'updated': of the material points) half a step ago: array (n, dim) [m/s].")
		.def("points", &SoftGrain::pointArrays, "Fields at the material points, a dict of arrays: position (n, 3) [m], F (n, 3, 3) deformation gradient [-], cauchy (n, 3, 3) Cauchy stress [Pa], volume (n,) present volume [m³, 2D m²].")
		.def("isRigid", &SoftGrain::movesRigidly, "Whether the grain moves as a rigid body: undeformed and untouched, so that nothing of it needs to be computed (:yref:`SoftGrainIntegrator.rigidMotion`).")
		.def("isAsleep", &SoftGrain::sleeps, "Whether the grain sleeps: at rest, and left as it is until something changes (:yref:`SoftGrainIntegrator.sleep`).")
		.def("energy", &SoftGrain::energyDict, "Energies of the grain [J, 2D J/m], a dict: kinetic (of the present velocities), elastic (at the beginning of the last step; 0 before the first).")
		.def("undeformedVolume", &SoftGrain::undeformedVolume, "Volume of the undeformed grain [m³] (2D: area [m²]).")
		.def("volume", &SoftGrain::presentVolume, "Present volume [m³] (2D: area [m²]), Σ Vp0 J.")
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftGrain, Shape);

private:
	softgrain::GrainAssembly& assembled();
	/// Of the State of its body, which is none where that is another one by now.
	StateChange shownChange();
};
REGISTER_SERIALIZABLE(SoftGrain);

class Bo1_SoftGrain_Aabb : public BoundFunctor {
public:
	void go(const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3,
		const Body* body) override;
	void postLoad(Bo1_SoftGrain_Aabb&);
	bool hasMargin() const { return margin > 0 && math::isfinite(margin); }
	FUNCTOR1D(SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Bo1_SoftGrain_Aabb, BoundFunctor,
		"Box about the present outline of a :yref:`SoftGrain`, enlarged by *margin*. :yref:`SoftGrainIntegrator` calls for a new run of the collider when the outline of a grain leaves its box.",
		((Real, margin, 0.05, Attr::triggerPostLoad, "Enlargement of the box over the radius of the grain, > 0 [-], at least 0.2 *zeta*; larger: fewer runs of the collider, more candidate pairs."))
	);
	// clang-format on
	DECLARE_LOGGER;

private:
	void reportMissingIntegrator();

	std::atomic<bool> reported_ { false }; ///< or not missing; bodies come in parallel
};
REGISTER_SERIALIZABLE(Bo1_SoftGrain_Aabb);

} // namespace yade
