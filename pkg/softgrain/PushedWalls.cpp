#include "PushedWalls.hpp"
#include "WallStressController.hpp"

#include <algorithm>
#include <sstream>

namespace yade {

namespace {

const string tagOfWalls = "softgrain.pushedWalls=";

std::vector<string>::iterator tagIn(Scene& scene)
{
	return std::find_if(scene.tags.begin(), scene.tags.end(), [](const string& tag) {
		return tag.compare(0, tagOfWalls.size(), tagOfWalls) == 0;
	});
}

std::vector<Body::id_t> pushedWalls(Scene& scene)
{
	const auto tag = tagIn(scene);
	std::vector<Body::id_t> walls;
	if (tag == scene.tags.end()) return walls;
	std::istringstream ids(tag->substr(tagOfWalls.size()));
	for (string id; std::getline(ids, id, ',');)
		walls.push_back(std::stoi(id));
	return walls;
}

void setPushedWalls(Scene& scene, const std::vector<Body::id_t>& walls)
{
	const auto tag = tagIn(scene);
	if (tag != scene.tags.end()) scene.tags.erase(tag);
	if (walls.empty()) return;
	string ids;
	for (const Body::id_t id : walls)
		ids += (ids.empty() ? "" : ",") + std::to_string(id);
	scene.tags.push_back(tagOfWalls + ids);
}

/// All of a scene but one.
std::vector<Body::id_t> without(Scene& scene, Body::id_t id)
{
	auto walls = pushedWalls(scene);
	walls.erase(std::remove(walls.begin(), walls.end(), id), walls.end());
	return walls;
}

bool isPushed(const Scene& scene, Body::id_t id)
{
	return std::any_of(scene.engines.begin(), scene.engines.end(), [&](const auto& engine) {
		const auto* controller = dynamic_cast<const WallStressController*>(engine.get());
		return controller && !controller->dead && controller->pushes(id);
	});
}

} // namespace

void PushedWalls::free(Scene& scene, Body& wall, int axis)
{
	auto walls = without(scene, wall.getId());
	walls.push_back(wall.getId());
	setPushedWalls(scene, walls);
	wall.state->blockedDOFs = State::DOF_ALL & ~State::axisDOF(axis);
	wall.state->vel = wall.state->angVel = Vector3r::Zero();
}

void PushedWalls::hold(Scene& scene, Body& wall)
{
	setPushedWalls(scene, without(scene, wall.getId()));
	wall.state->blockedDOFs = State::DOF_ALL;
}

/// Whether its velocity is that by which NewtonIntegrator has moved it.
bool PushedWalls::isAsMoved(const State& state, Body::id_t id, Real time) const
{
	const auto before = place_.find(id);
	if (before == place_.end()) return true; // not known in a scene that was loaded
	constexpr Real alike = 1e-6, rounding = 1e-12;
	const Vector3r way = state.vel * (time - time_), moved = state.pos - before->second;
	return (way - moved).norm() <= alike * moved.norm() + rounding * state.pos.norm();
}

std::vector<Body::id_t> PushedWalls::holdTheRest(Scene& scene)
{
	std::vector<Body::id_t> held;
	std::map<Body::id_t, Vector3r> place;
	for (const Body::id_t id : pushedWalls(scene)) {
		if (!scene.bodies->exists(id)) {
			setPushedWalls(scene, without(scene, id));
			continue;
		}
		Body& wall = *(*scene.bodies)[id];
		if (isPushed(scene, id)) {
			place[id] = wall.state->pos;
			continue;
		}
		if (isAsMoved(*wall.state, id, scene.time)) wall.state->vel = Vector3r::Zero();
		hold(scene, wall);
		held.push_back(id);
	}
	place_ = std::move(place);
	time_ = scene.time;
	return held;
}

} // namespace yade
