#include "checks/BodyChecks.hpp"
#include "Require.hpp"
#include "checks/HostChecks.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/Bodies.hpp"
#include "scene/PeriodicCell.hpp"

#include <cstdlib>

namespace yade {

namespace {

/// Of those that soft grains may touch, which would pass through what is no number.
void checkRigidShape(const Body& body)
{
	if (isA<Box>(body.shape)) {
		const Vector3r& extents = static_cast<const Box&>(*body.shape).extents;
		if (!(extents.minCoeff() >= 0))
			softgrain::refuse(nameOf(body) + ": half a side in shape.extents",
					  extents.minCoeff(), "[0, inf) m");
	} else if (isA<Sphere>(body.shape)) {
		const Real radius = static_cast<const Sphere&>(*body.shape).radius;
		if (!(radius > 0 && math::isfinite(radius)))
			softgrain::refuse(nameOf(body) + ": shape.radius", radius, "(0, inf) m");
	} else if (isA<Facet>(body.shape)) {
		const auto& vertices = static_cast<const Facet&>(*body.shape).vertices;
		for (const Vector3r& vertex : vertices)
			if (!math::isfinite(vertex.sum()))
				throw std::invalid_argument(nameOf(body) +
							    ": shape.vertices are not finite; "
							    "admissible: finite numbers");
	} else if (isA<Wall>(body.shape)) {
		const int sense = static_cast<const Wall&>(*body.shape).sense;
		if (std::abs(sense) > 1)
			softgrain::refuse(nameOf(body) + ": shape.sense", sense, "-1, 0, 1");
	}
}

/// (Of soft grains the state is checked where it was changed.)
void checkRigidBody(const Body& body)
{
	const State& state = *body.state;
	const std::pair<const char*, Real> sums[] { { "pos", state.pos.sum() },
						    { "ori", state.ori.coeffs().sum() },
						    { "vel", state.vel.sum() },
						    { "angVel", state.angVel.sum() } };
	for (const auto& [which, sum] : sums)
		if (!math::isfinite(sum))
			throw std::invalid_argument(nameOf(body) + ": state." + which +
						    " is not finite; admissible: finite numbers");
	checkRigidShape(body);
}

void checkClasses(const Body& body)
{
	const bool softShape = isA<SoftGrain>(body.shape);
	const bool softMaterial = isA<SoftMat>(body.material);
	if (!softShape) checkRigidBody(body);
	if (softShape && !softMaterial)
		throw std::invalid_argument(
			nameOf(body) + " has the soft shape SoftGrain but the material " +
			(body.material ? body.material->getClassName() : string("None")) +
			"; soft grains need a SoftMat");
	if (softMaterial && !softShape)
		throw std::invalid_argument(
			nameOf(body) + " has the material SoftMat but the rigid shape " +
			(body.shape ? body.shape->getClassName() : string("None")) +
			"; use sg.soften() or give it a rigid material such as FrictMat");
	if (softShape && (body.isClumpMember() || body.isClump()))
		throw std::invalid_argument(nameOf(body) +
					    " is a soft grain in a clump, which is not supported");
	if (softShape && body.state->blockedDOFs != State::DOF_ALL)
		throw std::invalid_argument(
			nameOf(body) +
			" is a soft grain with degrees of freedom left to NewtonIntegrator: "
			"state.blockedDOFs = '" +
			string(body.state->blockedDOFs_vec_get()) +
			"'; admissible: 'xyzXYZ', which sg.soften() and sg.soft_disk() set "
			"(SoftGrainIntegrator moves the grain, in 2D within its plane)");
}

void checkPeriodic(const Body& body, const Scene& scene)
{
	if (isA<Wall>(body.shape))
		throw std::invalid_argument(
			nameOf(body) +
			" is a Wall, but O.periodic = True: the collider of YADE never ends with "
			"its infinite box in a periodic cell; leave it out");
	if (isA<Box>(body.shape) && isSheared(scene))
		throw std::invalid_argument(nameOf(body) +
					    " is a Box in a sheared periodic cell, where the "
					    "collider of YADE would end "
					    "the process; use Facets, or keep O.cell.hSize and "
					    "O.cell.velGrad diagonal");
}

} // namespace

void checkBody(const Body& body, const Scene& scene)
{
	if (scene.isPeriodic) checkPeriodic(body, scene);
	checkSubdomain(body);
	checkClasses(body);
}

} // namespace yade
