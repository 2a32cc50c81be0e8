#include "scene/PeriodicCell.hpp"
#include "Require.hpp"
#include "classes/SoftGrain.hpp"

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

Vector3r spanInCell(const Scene& scene, const Bound& bound)
{
	return (bound.max - bound.min).cwiseQuotient(scene.cell->getSize());
}

namespace {

/// Middle of the box that the collider has of a body, by the period in which its place is, in
/// lengths of the base vectors.
Vector3r middleInCell(const Scene& scene, const PlacedBody& body)
{
	const Vector3r& size = scene.cell->getSize();
	const Vector3r inCell = scene.cell->unshearPt(body.place).cwiseQuotient(size);
	const auto& bound = (*scene.bodies)[body.id]->bound;
	if (!bound) return inCell;
	const Vector3r middle = 0.5 * (bound->min + bound->max).cwiseQuotient(size);
	return middle + Vector3r((inCell - middle).array().round());
}

/// By which a body is displaced to be nearest to another.
Vector3i periodsToNearest(const Scene& scene, const PlacedBody& body, const PlacedBody& to)
{
	const Vector3r apart = middleInCell(scene, body) - middleInCell(scene, to);
	return -Vector3r(apart.array().round()).cast<int>();
}

} // namespace

Vector3r shiftToNearest(const Scene& scene, const PlacedBody& body, const PlacedBody& to)
{
	if (!scene.isPeriodic) return Vector3r::Zero();
	return scene.cell->hSize * periodsToNearest(scene, body, to).cast<Real>();
}

void chooseNearestImage(const Scene& scene, const Vector3r& place1, const Vector3r& place2,
			Interaction& I)
{
	if (!scene.isPeriodic) return;
	I.cellDist = periodsToNearest(scene, { I.getId2(), place2 }, { I.getId1(), place1 });
}

namespace {

/// How many periods a shift is; zero if it is none, or not a whole number of them.
Vector3r wholePeriods(const Matrix3r& cell, const Vector3r& shift, Real tolerance)
{
	const Vector3r periods = (cell.inverse() * shift).array().round();
	return (cell * periods - shift).norm() <= tolerance ? periods : Vector3r(Vector3r::Zero());
}

} // namespace

std::optional<Vector3r> followWrap(const Scene& scene, const Body& grain, const Vector3r& shift,
				   Real tolerance)
{
	if (!scene.isPeriodic) return std::nullopt;
	const Cell& cell = *scene.cell;
	Vector3r periods = wholePeriods(cell.hSize, shift, tolerance);
	if (periods.isZero(0)) periods = wholePeriods(cell.prevHSize, shift, tolerance);
	if (periods.isZero(0)) return std::nullopt;
	for (const auto& [other, I] : grain.intrs)
		I->cellDist += (I->getId1() == grain.getId() ? 1 : -1) * periods.cast<int>();
	return cell.hSize * periods;
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

bool isSheared(const Scene& scene)
{
	const Matrix3r& H = scene.cell->hSize;
	const Matrix3r L = comingVelGrad(scene);
	return !H.isDiagonal(0) || !L.isDiagonal(0);
}

namespace {

/// What controllers of the cell leave where there should be nothing, over the cell, and what of it
/// may come in a step: they take its deformation apart and put it together again.
constexpr double planeRounding = 1e-9, planeRoundingOfStep = 1e-13;

bool leavesPlane(const Matrix3r& m, double tolerance)
{
	return std::max({ std::abs(m(0, 2)), std::abs(m(1, 2)), std::abs(m(2, 0)),
			  std::abs(m(2, 1)) }) > tolerance;
}

void checkPlane(const Scene& scene)
{
	const Matrix3r L = scene.dt * comingVelGrad(scene);
	if (leavesPlane(scene.cell->hSize, planeRounding * scene.cell->getSize().minCoeff()))
		throw std::runtime_error(
			"O.cell.hSize couples z with x or y, but the soft grains are 2D; its "
			"third base vector must be along z, the others in the xy-plane");
	if (leavesPlane(L, planeRoundingOfStep) || std::abs(L(2, 2)) > planeRoundingOfStep)
		throw std::runtime_error(
			"O.cell.velGrad has components of z, but the soft grains are 2D; "
			"only its xx, xy, yx and yy may differ from 0");
}

} // namespace

/// Two bodies have one interaction in YADE, and so may touch on one side only.
void checkSpan(const Scene& scene, const Body& body, int axes)
{
	if (!body.bound) return;
	const Vector3r span = spanInCell(scene, *body.bound), size = scene.cell->getSize();
	const bool soft = YADE_PTR_DYN_CAST<SoftGrain>(body.shape) != nullptr;
	for (int axis = 0; axis < axes; ++axis) {
		if (span[axis] <= 0.5) continue;
		std::ostringstream message;
		message << (soft ? "soft grain #" : "rigid body #") << body.getId() << " spans "
			<< span[axis] * size[axis] << " m along base vector " << axis
			<< " of the periodic cell (with the margins of the collider), more than "
			<< "the admissible half of its length " << size[axis]
			<< " m: it might touch the same " << (soft ? "grain" : "body")
			<< " on two sides. Use a larger cell" << (soft ? " with more grains" : "");
		throw std::runtime_error(message.str());
	}
}

namespace {

/// Cosine from which a side of a box counts as along a base vector, up to rounding.
constexpr Real alongSide = 1 - 1e-9;

/// Whether a body and its images along a base vector make one floor that goes on for ever.
bool makesFloor(const Scene& scene, const Body& body, int axis)
{
	if (!YADE_PTR_DYN_CAST<::yade::Box>(body.shape)) return false;
	const Vector3r period = scene.cell->hSize.col(axis);
	const Vector3r inBox = body.state->ori.conjugate() * period.normalized();
	return inBox.cwiseAbs().maxCoeff() > alongSide && (comingVelGrad(scene) * period).isZero(0);
}

/// The first sort of the collider passes over partners of a body that is longer than the cell along
/// its axis.
void checkSortAxis(const Scene& scene, const Body& floor, int axis)
{
	for (const auto& engine : scene.engines) {
		const auto collider = YADE_PTR_DYN_CAST<InsertionSortCollider>(engine);
		if (!collider || collider->sortAxis != axis) continue;
		throw std::runtime_error(
			"InsertionSortCollider.sortAxis = " + std::to_string(axis) +
			", but rigid body #" + std::to_string(floor.getId()) +
			" is longer than the periodic cell along this axis: the first sort would "
			"pass over its partners. Set sortAxis to an axis across the floor before "
			"the first step, as sg.engines() does when the floor is there already");
	}
}

/// Of a step. (YADE has deformed the cell by it already: what follows would be found wrong.)
void checkStrain(const Scene& scene)
{
	constexpr Real largest = 0.1;
	const Matrix3r& velGrad = scene.cell->velGrad;
	const Real rate = velGrad.cwiseAbs().maxCoeff();
	if (!math::isfinite(velGrad.sum()) || scene.dt * rate <= largest) return;
	std::ostringstream range;
	range << "[0, " << largest / rate << "] s, in which the cell of O.cell.velGrad deforms by "
	      << 100 * largest << " %";
	softgrain::refuse("O.dt", scene.dt, range.str());
}

} // namespace

void takeBackPrologue(Scene& scene)
{
	constexpr Real largestStep = 0.5; // of the gradient; where the cell has flipped it is 1
	if (scene.subStepping) return;
	Cell& cell = *scene.cell;
	if (scene.isPeriodic && cell.hSize != cell.prevHSize) {
		const Matrix3r step = cell.hSize * cell.prevHSize.inverse();
		const bool mayHaveFlipped =
			cell.flipFlippable &&
			!((step - Matrix3r::Identity()).cwiseAbs().maxCoeff() < largestStep);
		if (mayHaveFlipped) return;
		const Matrix3r before = step.inverse() * cell.trsf;
		cell.hSize = cell.prevHSize;
		cell.trsf = math::isfinite(before.sum())
				    ? before
				    : Matrix3r(cell.hSize * cell.refHSize.inverse());
		const Matrix3r velGrad = cell.velGrad;
		cell.velGrad = Matrix3r::Zero();
		cell.integrateAndUpdate(0); // what is derived from hSize
		cell.velGrad = velGrad;
	}
	scene.subStep = -1;
}

/// A rigid body touches a grain with one image only, unless it is a floor, of which it does not
/// matter which one: then its ends are beyond the reach of a grain on the nearest.
void checkRigidSpan(const Scene& scene, const Body& body, const Vector3r& grains, int dim,
		    const char* grain)
{
	const Vector3r span = spanInCell(scene, *body.bound), size = scene.cell->getSize();
	for (int axis = 0; axis < dim; ++axis) {
		const Real shorter = 1 - grains[axis], longer = 1 + 2 * grains[axis];
		if (span[axis] <= shorter) continue;
		if (span[axis] >= longer && makesFloor(scene, body, axis)) {
			checkSortAxis(scene, body, axis);
			continue;
		}
		std::ostringstream message;
		message << "rigid body #" << body.getId() << " (" << body.shape->getClassName()
			<< ") spans " << span[axis] * size[axis] << " m along base vector " << axis
			<< " of the periodic cell: it might touch a " << grain
			<< " on two sides, or "
			<< "end under it. Admissible: up to " << shorter * size[axis]
			<< " m, or, for a Box with a side along that base vector, which does not "
			<< "move nor change, from " << longer * size[axis] << " m";
		throw std::runtime_error(message.str());
	}
}

void checkCell(const Scene& scene, const softgrain::GrainAssembly& assembly)
{
	if (!scene.isPeriodic) return;
	checkStrain(scene);
	Vector3r longest = Vector3r::Zero(); // of the grains along each base vector, in its length
	int dim = 0;
	for (int g = 0; g < assembly.grains(); ++g) {
		const Body& body = *(*scene.bodies)[assembly.idOf(g)];
		const SoftGrain& grain = static_cast<const SoftGrain&>(*body.shape);
		if (g == 0 && grain.contact == "nodes")
			throw std::runtime_error(
				"O.periodic = True with contact = 'nodes': the common grid of it "
				"does not repeat with the cell; use 'surface' or 'points'");
		if (g == 0 && grain.dim == 2) checkPlane(scene);
		if (!body.bound) continue;
		checkSpan(scene, body, grain.dim);
		longest = longest.cwiseMax(spanInCell(scene, *body.bound));
		dim = grain.dim;
	}
	for (const auto& body : *scene.bodies)
		if (body->bound && body->shape && !YADE_PTR_DYN_CAST<SoftGrain>(body->shape))
			checkRigidSpan(scene, *body, longest, dim, "soft grain");
}

} // namespace yade
