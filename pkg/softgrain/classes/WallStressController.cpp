#include "classes/WallStressController.hpp"
#include "Require.hpp"
#include "checks/Engines.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/PushedWalls.hpp"

#include <algorithm>
#include <sstream>

namespace yade {

YADE_PLUGIN((WallStressController));

using softgrain::require;

namespace {

WallStressController::Packing packingOf(const Scene& scene)
{
	WallStressController::Packing packing;
	const Material* last = nullptr; // grains of one material mostly follow one another
	for (const auto& body : *scene.bodies) {
		const auto grain = YADE_PTR_DYN_CAST<SoftGrain>(body->shape);
		const auto material = YADE_PTR_DYN_CAST<SoftMat>(body->material);
		if (!grain || !material) continue;
		packing.radius = std::min(packing.radius, grain->radius);
		if (material.get() == last) continue;
		last = material.get();
		material->constants().validate();
		packing.impedance =
			std::max(packing.impedance, material->waveImpedance(grain->dim));
		packing.density = std::max(packing.density, material->constants().density);
	}
	return packing;
}

Vector3r gravityOf(const Scene& scene)
{
	const NewtonIntegrator* newton = newtonIntegratorOf(scene);
	return newton ? newton->gravity : Vector3r(Vector3r::Zero());
}

/// Half the thickness of a wall along an axis.
Real halfThickness(const Body& body, int axis)
{
	const auto box = YADE_PTR_DYN_CAST<Box>(body.shape);
	return box ? box->extents[axis] : 0;
}

} // namespace

Vector3r contactForceOn(const Body& body)
{
	Vector3r sum = Vector3r::Zero();
	for (const auto& [other, interaction] : body.intrs) {
		if (!interaction->isReal()) continue;
		const auto* phys = dynamic_cast<const NormShearPhys*>(interaction->phys.get());
		if (!phys) continue;
		const Real sign = interaction->getId2() == body.getId() ? 1 : -1;
		sum += sign * (phys->normalForce + phys->shearForce);
	}
	return sum;
}

void WallStressController::postLoad(WallStressController&)
{
	require(walls.empty() || walls.size() == 4 || walls.size() == 6, "number of walls",
		walls.size(), "{4, 6}");
	require(stressMask >= 0 && stressMask <= 7, "stressMask", stressMask, "[0, 7]");
	require(drag > 0 && math::isfinite(drag), "drag", drag, "(0, inf)");
	for (int a = 0; a < 3; ++a)
		require(math::isfinite(goal[a]) && (goal[a] <= 0 || !(stressMask >> a & 1)), "goal",
			goal[a],
			"(-inf, 0] Pa where it is a stress; a goal that fits has to be set before "
			"stressMask");
}

Body& WallStressController::wall(int axis, bool upper) const
{
	return *(*scene->bodies)[walls[2 * axis + upper]];
}

Real WallStressController::length(int axis) const
{
	const Body &low = wall(axis, false), &high = wall(axis, true);
	return high.state->pos[axis] - low.state->pos[axis] - halfThickness(low, axis) -
	       halfThickness(high, axis);
}

Real WallStressController::area(int axis) const
{
	Real product = 1; // m, the thickness in 2D
	for (int other = 0; other < axes(); ++other)
		if (other != axis) product *= length(other);
	return product;
}

void WallStressController::checkWalls() const
{
	require(walls.size() == 4 || walls.size() == 6, "number of walls", walls.size(), "{4, 6}");
	for (std::size_t k = 0; k < walls.size(); ++k) {
		const int axis = static_cast<int>(k) / 2;
		const bool exists = scene->bodies->exists(walls[k]);
		const Body* body = exists ? (*scene->bodies)[walls[k]].get() : nullptr;
		const auto plane = body ? YADE_PTR_DYN_CAST<Wall>(body->shape) : nullptr;
		const bool isBox = body && YADE_PTR_DYN_CAST<Box>(body->shape);
		if (!(isBox || (plane && plane->axis == axis)))
			throw std::invalid_argument(
				"WallStressController.walls: body #" + std::to_string(walls[k]) +
				(exists ? " is no Box, and no Wall with axis = " +
						  std::to_string(axis)
					: std::string(" does not exist")));
		const int blocked = body->state->blockedDOFs;
		if (blocked != State::DOF_ALL && blocked != freeAlong(axis))
			throw std::invalid_argument(
				"WallStressController.walls: body #" + std::to_string(walls[k]) +
				" is free; admissible: all degrees of freedom blocked, as of a "
				"body with fixed = True, or all but the way along its axis");
	}
	for (int a = 0; a < axes(); ++a)
		require(length(a) > 0, "WallStressController: distance of two walls", length(a),
			"(0, inf) m; walls = [lower, upper, ...]");
}

/// Two that push a wall would add up.
void WallStressController::checkAlone() const
{
	int met = 0;
	for (const auto& engine : scene->engines) {
		const auto* other = dynamic_cast<const WallStressController*>(engine.get());
		if (!other || other->dead) continue;
		met += other == this;
		const auto shared = std::find_first_of(walls.begin(), walls.end(),
						       other->walls.begin(), other->walls.end());
		if ((other == this && met < 2) || shared == walls.end()) continue;
		throw std::runtime_error(
			"WallStressController.walls: O.engines push body #" +
			std::to_string(*shared) +
			(other == this ? " twice, by one controller" : " by two controllers") +
			", which would add up; admissible: once");
	}
}

void WallStressController::action()
{
	postLoad(*this); // YADE keeps a value that was refused, and does not look at items of a
			 // vector
	checkWalls();
	checkAlone();
	if (axes() == 2)
		require(goal[2] == 0, "WallStressController.goal[2]", goal[2],
			"0 with four walls, none of which is along z");
	if (ownScene_.isGone()) initialLengths.clear();
	ownScene_.enter();
	if (static_cast<int>(initialLengths.size()) != axes()) {
		initialLengths.clear();
		for (int a = 0; a < axes(); ++a)
			initialLengths.push_back(length(a));
	}
	const Packing packing = packingOf(*scene);
	for (int a = 0; a < axes(); ++a)
		if (!(stressMask >> a & 1))
			moveWall(a);
		else if (packing.impedance > 0)
			pushWall(a, packing);
		else
			throw std::runtime_error(
				"WallStressController: stressMask = " + std::to_string(stressMask) +
				" asks for a stress, but there is no soft grain, whose waves walls "
				"under stress are damped by. Admissible without: stressMask = 0");
}

/// m dv/dt = load + reaction - Z v, Z = drag rho c A. The mass is such that the wall follows within
/// the time of a wave over a grain's radius, many steps. It follows what it is made of: with
/// another drag, density or area the dashpot would be unstable (dt Z/m < 2).
void WallStressController::pushWall(int axis, const Packing& packing)
{
	Body& body = wall(axis, true);
	State& state = *body.state;
	const Real surface = area(axis), dashpot = drag * packing.impedance * surface;
	const bool isHeld = state.blockedDOFs == State::DOF_ALL;
	if (isHeld) freeWall(body, axis);
	// YADE's walls have none
	const bool isGiven = isHeld || !(state.mass > 0) || hasMassOfPush(*scene, body);
	if (isGiven)
		state.mass = drag * packing.density * surface * packing.radius;
	else
		requireStable(body, scene->dt * dashpot);
	notePush(*scene, body, axis, isGiven ? state.mass : 0);
	Vector3r force = Vector3r::Zero();
	force[axis] = goal[axis] * surface - dashpot * state.vel[axis] -
		      state.mass * gravityOf(*scene)[axis];
	scene->forces.addForce(body.getId(), force);
}

/// A mass that the script gave to a wall has to be so large.
void WallStressController::requireStable(const Body& body, Real least) const
{
	if (body.state->mass >= least) return;
	std::ostringstream message;
	message << "WallStressController.walls: body #" << body.getId()
		<< ", state.mass = " << body.state->mass
		<< " kg, is too light for its dashpot; admissible with drag = " << drag
		<< " and O.dt = " << scene->dt << ": [" << least << ", inf) kg";
	throw std::runtime_error(message.str());
}

void WallStressController::moveWall(int axis)
{
	Body& body = wall(axis, true);
	holdWall(*scene, body);
	State& state = *body.state;
	state.vel = Vector3r::Zero();
	state.vel[axis] = goal[axis] * length(axis);
}

/// (In a scene that was loaded, or of which it is no engine any more, nothing has told it yet.)
void WallStressController::lookAtPresentScene() { scene = Omega::instance().getScene().get(); }

Vector3r WallStressController::stress()
{
	lookAtPresentScene();
	checkWalls();
	Vector3r mean = Vector3r::Zero();
	for (int a = 0; a < axes(); ++a)
		mean[a] = (contactForceOn(wall(a, false))[a] - contactForceOn(wall(a, true))[a]) /
			  (2 * area(a));
	return mean;
}

Vector3r WallStressController::strain()
{
	lookAtPresentScene();
	checkWalls();
	Vector3r logarithms = Vector3r::Zero();
	if (static_cast<int>(initialLengths.size()) != axes()) return logarithms; // not run yet
	for (int a = 0; a < axes(); ++a)
		logarithms[a] = std::log(length(a) / initialLengths[a]);
	return logarithms;
}

} // namespace yade
