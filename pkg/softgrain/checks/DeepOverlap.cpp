#include "checks/DeepOverlap.hpp"
#include "classes/SoftContact.hpp"
#include "scene/Bodies.hpp"

#include <cmath>
#include <sstream>

namespace yade {

namespace {

/// The commonest cause of a deep overlap with a Wall; empty for other bodies.
string hintAtSide(const Interaction& I, const Scene& scene)
{
	for (const Body::id_t id : { I.getId1(), I.getId2() }) {
		const auto* wall = dynamic_cast<const Wall*>((*scene.bodies)[id]->shape.get());
		if (wall && wall->sense != 0)
			return "is the grain on the " +
			       string(wall->sense > 0 ? "positive" : "negative") +
			       " side of the wall, as its sense = " + std::to_string(wall->sense) +
			       " says? Else ";
	}
	return "";
}

/// What no loading is slow enough for; empty where friction is too small for it.
string hintOfLocking(const Interaction& I, const Scene& scene)
{
	constexpr Real ofThreeWalls = 0.7; // 1/sqrt(2), rounded down
	const auto* phys = dynamic_cast<const SoftPhys*>(I.phys.get());
	if (!phys || !(phys->tangensOfFrictionAngle >= ofThreeWalls)) return "";
	for (const Body::id_t id : { I.getId1(), I.getId2() })
		if (dynamic_cast<const Wall*>((*scene.bodies)[id]->shape.get()))
			return "do several walls close in on the grain? With such friction it "
			       "locks between them (user guide, 'Friction'). Else ";
	return "";
}

} // namespace

string messageOfOverlap(const Interaction& I, const Scene& scene, Real deepest, Real maxOverlap)
{
	std::ostringstream message;
	message << namesOf(I);
	if (std::isinf(deepest))
		message << ": one lies inside the other, an overlap of more";
	else
		message << " overlap by " << deepest << " point spacings, more";
	message << " than maxOverlap = " << maxOverlap << ". Hint: " << hintAtSide(I, scene)
		<< hintOfLocking(I, scene)
		<< "start from less overlap (sg.soften(overlap='shrink')), load more slowly, "
		   "reduce "
		   "tolerance, or, under pressures near young and above, make grains with "
		   "nodeSpacing = 2";
	return message.str();
}

} // namespace yade
