#include "scene/PushedWalls.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

namespace yade {

namespace {

const string tagOfWalls = "softgrain.pushedWalls=";

/// When a wall was pushed last, where it was then, and the mass that it had been given for it.
struct Push {
	Body::id_t id = -1;
	int axis = 0;
	long step = 0;
	Real time = 0, place = 0; ///< s, m along the axis
	Real mass = 0;            ///< kg; 0: another one
};

std::vector<string>::iterator tagIn(Scene& scene)
{
	return std::find_if(scene.tags.begin(), scene.tags.end(), [](const string& tag) {
		return tag.compare(0, tagOfWalls.size(), tagOfWalls) == 0;
	});
}

/// Numbers of a push are joined by colons, pushes by commas: YADE takes spaces out of tags.
std::vector<Push> pushesIn(Scene& scene)
{
	std::vector<Push> pushes;
	const auto tag = tagIn(scene);
	if (tag == scene.tags.end()) return pushes;
	std::istringstream text(tag->substr(tagOfWalls.size()));
	char colon = 0;
	for (Push p; text >> p.id >> colon >> p.axis >> colon >> p.step >> colon >> p.time >>
		     colon >> p.place >> colon >> p.mass;) {
		pushes.push_back(p);
		text >> colon;
	}
	return pushes;
}

void setPushes(Scene& scene, const std::vector<Push>& pushes)
{
	const auto tag = tagIn(scene);
	if (tag != scene.tags.end()) scene.tags.erase(tag);
	if (pushes.empty()) return;
	std::ostringstream text;
	text.precision(std::numeric_limits<Real>::max_digits10);
	for (const Push& p : pushes)
		text << (&p == &pushes.front() ? "" : ",") << p.id << ':' << p.axis << ':' << p.step
		     << ':' << p.time << ':' << p.place << ':' << p.mass;
	scene.tags.push_back(tagOfWalls + text.str());
}

std::vector<Push> pushesBut(Scene& scene, Body::id_t id)
{
	auto pushes = pushesIn(scene);
	pushes.erase(std::remove_if(pushes.begin(), pushes.end(),
				    [id](const Push& p) { return p.id == id; }),
		     pushes.end());
	return pushes;
}

/// Whether it is still the wall that was freed.
bool isFree(const Scene& scene, const Push& push)
{
	if (!scene.bodies->exists(push.id)) return false;
	const Body& body = *(*scene.bodies)[push.id];
	const bool isWall = dynamic_cast<const Wall*>(body.shape.get()) ||
			    dynamic_cast<const Box*>(body.shape.get());
	return isWall && body.state->blockedDOFs == freeAlong(push.axis);
}

/// Since the push, s. Where the clock has been put back (`O.resetTime()`) this is the step after
/// it.
Real timeSince(const Push& push, const Scene& scene)
{
	return scene.time > push.time ? scene.time - push.time : scene.dt;
}

/// Whether the velocity is that by which NewtonIntegrator has moved it.
bool isAsMoved(const State& state, const Push& push, Real elapsed)
{
	// of a difference of places, many times over; one that is given by hand is another one by
	// far, or as good as the one it has
	constexpr Real alike = 1e-6, rounding = 1e-12;
	const Real way = state.vel[push.axis] * elapsed;
	const Real moved = state.pos[push.axis] - push.place;
	return std::abs(way - moved) <= alike * std::abs(moved) + rounding * std::abs(push.place);
}

} // namespace

int freeAlong(int axis) { return State::DOF_ALL & ~State::axisDOF(axis); }

void freeWall(Body& wall, int axis)
{
	wall.state->blockedDOFs = freeAlong(axis);
	wall.state->vel = wall.state->angVel = Vector3r::Zero();
}

void holdWall(Scene& scene, Body& wall)
{
	setPushes(scene, pushesBut(scene, wall.getId()));
	wall.state->blockedDOFs = State::DOF_ALL;
}

void notePush(Scene& scene, const Body& wall, int axis, Real mass)
{
	auto pushes = pushesBut(scene, wall.getId());
	const Real place = wall.state->pos[axis];
	pushes.push_back({ wall.getId(), axis, scene.iter, scene.time, place, mass });
	setPushes(scene, pushes);
}

bool hasMassOfPush(Scene& scene, const Body& wall)
{
	const auto pushes = pushesIn(scene);
	return std::any_of(pushes.begin(), pushes.end(), [&](const Push& push) {
		return push.id == wall.getId() && push.mass == wall.state->mass;
	});
}

std::vector<Body::id_t> holdUnpushedWalls(Scene& scene)
{
	std::vector<Body::id_t> held;
	for (const Push& push : pushesIn(scene)) {
		if (push.step == scene.iter) continue;
		if (!isFree(scene, push)) { // another body by now, or freed or held by hand
			setPushes(scene, pushesBut(scene, push.id));
			continue;
		}
		Body& wall = *(*scene.bodies)[push.id];
		if (isAsMoved(*wall.state, push, timeSince(push, scene)))
			wall.state->vel = Vector3r::Zero();
		holdWall(scene, wall);
		held.push_back(push.id);
	}
	return held;
}

} // namespace yade
