// What O.periodic means for soft grains: how a pair sees its second body, what the flow of the cell
// does to velocities, boxes for the collider (doc/decisions/0021-periodic-cells.md).
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <optional>

namespace yade {

/// Cell.velGrad as NewtonIntegrator will set it in the step at hand; zero where nothing is
/// periodic, 1/s.
Matrix3r comingVelGrad(const Scene& scene);

/// Place of the image of body #2 of an interaction that body #1 sees, relative to body #2, m.
Vector3r imageShift(const Scene& scene, const Interaction& I);

/// The same as a pair takes it, whose second body is #2 of the interaction or else #1.
softgrain::ImageDescription imageOf(const Scene& scene, const Interaction& I, bool secondIsBody2);

/// Where a body is taken to be.
struct PlacedBody {
	Body::id_t id;
	Vector3r place; ///< m
};
/// By which whole periods a body comes nearest to another, m.
Vector3r shiftToNearest(const Scene& scene, const PlacedBody& body, const PlacedBody& to);

/// YADE's collider tells by which periods two bodies come near each other when it finds the pair,
/// and leaves that as it is while their boxes overlap in any way: not where the cell flips, or a
/// body is put elsewhere, nor of bodies longer than half the cell. The bodies meet in the images
/// that are nearest (checkCell: no others, or others that go on like them). `place1`, `place2`:
/// where the search takes bodies #1 and #2 to be, m.
void chooseNearestImage(const Scene& scene, const Vector3r& place1, const Vector3r& place2,
			Interaction& I);

/// After a soft grain was shifted by hand. If by whole periods, as by Cell.wrap, be it in the step
/// at hand or before the cell moved for it, its interactions then name other images, those that are
/// where the former ones were; returns these periods as they are now, m.
std::optional<Vector3r> followWrap(const Scene& scene, const Body& grain, const Vector3r& shift,
				   Real tolerance);

/// What NewtonIntegrator does to every body in the step at hand for the flow of the cell
/// (Cell.homoDeform): v += dt convection v + change x, spin += spinChange.
struct CellFlow {
	Matrix3r change = Matrix3r::Zero();     ///< 1/s
	Matrix3r convection = Matrix3r::Zero(); ///< 1/s
	Vector3r spinChange = Vector3r::Zero(); ///< 1/s

	bool isZero() const { return change.isZero(0) && convection.isZero(0); }
	/// What is added to the velocity, m/s.
	Vector3r added(const Vector3r& position, const Vector3r& velocity, Real dt) const
	{
		return dt * (convection * velocity) + change * position;
	}
	/// The velocity that becomes `after`, m/s.
	Vector3r before(const Vector3r& position, const Vector3r& after, Real dt) const;
};
CellFlow cellFlow(const Scene& scene, const NewtonIntegrator& newton);

/// From space to the coordinates of the collider's boxes, for boxes made when the cell had the
/// given lengths: places that keep their share of the cell keep their place in these.
Matrix3r toBoxes(const Scene& scene, const Vector3r& cellSize);

/// Whether the cell is sheared, or going to be in the step at hand.
bool isSheared(const Scene& scene);

/// Throws std::runtime_error where the periodic cell is one that soft grains, or the rigid bodies
/// beside them, cannot be in.
void checkCell(const Scene& scene, const softgrain::GrainAssembly& assembly);

/// In a step that is refused: the next one begins anew, with the cell as it was before YADE
/// deformed it for this one, whose O.dt may have been wrong. (Not one engine at a time.)
void takeBackPrologue(Scene& scene);

/// The box that the collider has of a body, in lengths of the base vectors.
Vector3r spanInCell(const Scene& scene, const Bound& bound);

/// The same for a rigid body that grains (`grain` in a message) may touch, the longest of which
/// span so much; along the first `dim` base vectors.
void checkRigidSpan(const Scene& scene, const Body& body, const Vector3r& grains, int dim,
		    const char* grain);

/// The same for a body in the contact dynamics that may touch others on all sides; along the first
/// `axes` base vectors.
void checkSpan(const Scene& scene, const Body& body, int axes);

} // namespace yade
