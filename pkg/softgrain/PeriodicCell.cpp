#include "PeriodicCell.hpp"
#include "SoftGrain.hpp"

#include <sstream>

namespace yade {

Matrix3r comingVelGrad(const Scene& scene)
{
	if (!scene.isPeriodic) return Matrix3r::Zero();
	const Cell& cell = *scene.cell;
	const bool assigned = cell.velGradChanged || !cell.nextVelGrad.isZero(0);
	return assigned ? cell.nextVelGrad : cell.velGrad;
}

Vector3r imageShift(const Scene& scene, const Interaction& I)
{
	return scene.isPeriodic ? scene.cell->intrShiftPos(I.cellDist) : Vector3r(Vector3r::Zero());
}

softgrain::ImageDescription imageOf(const Scene& scene, const Interaction& I, bool secondIsBody2)
{
	if (!scene.isPeriodic || I.cellDist == Vector3i::Zero()) return {};
	const Vector3r shift = imageShift(scene, I), velocity = comingVelGrad(scene) * shift;
	if (secondIsBody2) return { shift, velocity };
	return { -shift, -velocity };
}

Vector3r CellFlow::before(const Vector3r& position, const Vector3r& after, Real dt) const
{
	if (isZero()) return after;
	const Matrix3r growth = Matrix3r::Identity() + dt * convection;
	return growth.inverse() * (after - change * position);
}

CellFlow cellFlow(const Scene& scene, const NewtonIntegrator& newton)
{
	CellFlow flow;
	if (!scene.isPeriodic || scene.cell->homoDeform == Cell::HOMO_NONE) return flow;
	flow.change = comingVelGrad(scene) - newton.prevVelGrad;
	if (scene.cell->homoDeform >= Cell::HOMO_VEL) flow.convection = newton.prevVelGrad;
	const Matrix3r turn = 0.5 * (flow.change - flow.change.transpose());
	flow.spinChange = Vector3r(-turn(1, 2), turn(0, 2), -turn(0, 1));
	return flow;
}

Matrix3r toBoxes(const Scene& scene, const Vector3r& cellSize)
{
	return cellSize.asDiagonal() * scene.cell->hSize.inverse();
}

namespace {

bool leavesPlane(const Matrix3r& m)
{
	return m(0, 2) != 0 || m(1, 2) != 0 || m(2, 0) != 0 || m(2, 1) != 0;
}

void checkPlane(const Scene& scene)
{
	const Matrix3r L = comingVelGrad(scene);
	if (leavesPlane(scene.cell->hSize))
		throw std::runtime_error(
			"O.cell.hSize couples z with x or y, but the soft grains are 2D; its "
			"third base vector must be along z, the others in the xy-plane");
	if (leavesPlane(L) || L(2, 2) != 0)
		throw std::runtime_error(
			"O.cell.velGrad has components of z, but the soft grains are 2D; "
			"only its xx, xy, yx and yy may differ from 0");
}

} // namespace

/// Two bodies have one interaction in YADE, and so may touch on one side only.
void checkSpan(const Scene& scene, const Body& body, int axes)
{
	for (int axis = 0; body.bound && axis < axes; ++axis) {
		const Real span = body.bound->max[axis] - body.bound->min[axis],
			   size = scene.cell->getSize()[axis];
		if (span <= 0.5 * size) continue;
		const bool soft = dynamic_cast<const SoftGrain*>(body.shape.get());
		std::ostringstream message;
		message << (soft ? "soft grain #" : "rigid body #") << body.getId() << " spans "
			<< span << " m along base vector " << axis
			<< " of the periodic cell (with the margins of the collider), more than "
			<< "the admissible half of its length " << size
			<< " m: it might touch the same " << (soft ? "grain" : "body")
			<< " on two sides. Use a larger cell" << (soft ? " with more grains" : "");
		throw std::runtime_error(message.str());
	}
}

void checkCell(const Scene& scene, const softgrain::GrainAssembly& assembly)
{
	if (!scene.isPeriodic) return;
	for (int g = 0; g < assembly.grains(); ++g) {
		const Body& body = *(*scene.bodies)[assembly.idOf(g)];
		const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
		if (g == 0 && grain.contact == "nodes")
			throw std::runtime_error(
				"O.periodic = True with contact = 'nodes': the common grid of it "
				"does not repeat with the cell; use 'surface' or 'points'");
		if (g == 0 && grain.dim == 2) checkPlane(scene);
		checkSpan(scene, body, grain.dim);
	}
}

} // namespace yade
