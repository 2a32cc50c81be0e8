#include "checks/Engines.hpp"
#include "Yade.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "classes/SoftenWhenLoaded.hpp"
#include "classes/WallStressController.hpp"
#include "scene/Bodies.hpp"

#include <algorithm>
#include <stdexcept>

namespace yade {

namespace {

[[noreturn]] void refuse(const string& why) { throw std::runtime_error(why); }

/// The engine, if it is of this kind and not dead; else null.
template <class Wanted> const Wanted* liveOne(const Engine& engine)
{
	return engine.dead ? nullptr : dynamic_cast<const Wanted*>(&engine);
}

bool isActiveTimeStepper(const Engine& engine)
{
	const auto* stepper = liveOne<TimeStepper>(engine);
	return stepper && stepper->active;
}

void checkBefore(const Engine& engine)
{
	if (liveOne<NewtonIntegrator>(engine))
		refuse("NewtonIntegrator stands before SoftGrainIntegrator in O.engines; put it "
		       "after");
}

void checkAfter(const Engine& engine)
{
	if (isActiveTimeStepper(engine))
		refuse(engine.getClassName() +
		       " stands after SoftGrainIntegrator in O.engines and would change O.dt "
		       "between contact and motion; put it before");
	if (liveOne<WallStressController>(engine))
		refuse("WallStressController stands after SoftGrainIntegrator in O.engines, which "
		       "takes the forces on the walls before it; see sg.insert_before_solve()");
}

/// What puts forces on bodies for the step at hand.
const PartialEngine* asPush(const Engine& engine)
{
	const bool pushes = liveOne<ForceEngine>(engine) || liveOne<HarmonicForceEngine>(engine) ||
			    liveOne<TorqueEngine>(engine);
	return pushes ? dynamic_cast<const PartialEngine*>(&engine) : nullptr;
}

void checkBeforeReset(const Engine& engine)
{
	if (asPush(engine) || liveOne<WallStressController>(engine))
		refuse(engine.getClassName() +
		       " stands before ForceResetter in O.engines, which takes its forces away: "
		       "put it after; see sg.insert_before_solve()");
}

/// Between the solve and NewtonIntegrator, which moves rigid bodies alone by forces.
void checkBehindSolve(const Scene& scene, const Engine& engine)
{
	if (liveOne<SoftenWhenLoaded>(engine))
		refuse("SoftenWhenLoaded stands after SoftGrainIntegrator in O.engines, so that "
		       "the forces on a sphere that it turns are lost; put it before");
	const PartialEngine* push = asPush(engine);
	if (!push) return;
	for (const Body::id_t id : push->ids)
		if (scene.bodies->exists(id) && isSoftGrain(*(*scene.bodies)[id]))
			refuse(engine.getClassName() + " pushes soft grain #" + std::to_string(id) +
			       ", but stands after SoftGrainIntegrator in O.engines, which takes "
			       "the forces before it: they would be lost; see "
			       "sg.insert_before_solve()");
}

/// The first live one of this kind in a stretch of O.engines.
template <class Wanted, class Iterator> Iterator firstLive(Iterator begin, Iterator end)
{
	return std::find_if(begin, end,
			    [](const auto& engine) { return liveOne<Wanted>(*engine); });
}

/// How many live ones of this kind there are in a stretch of O.engines.
template <class Wanted, class Iterator> long countLive(Iterator begin, Iterator end)
{
	return std::count_if(begin, end,
			     [](const auto& engine) { return liveOne<Wanted>(*engine); });
}

} // namespace

SoftGrainIntegrator* softGrainIntegratorOf(const Scene& scene)
{
	SoftGrainIntegrator* dead = nullptr;
	for (const auto& engine : scene.engines)
		if (const auto integrator = YADE_PTR_DYN_CAST<SoftGrainIntegrator>(engine)) {
			if (!integrator->dead) return integrator.get();
			if (!dead) dead = integrator.get();
		}
	return dead;
}

const NewtonIntegrator* newtonIntegratorOf(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (const auto* newton = liveOne<NewtonIntegrator>(*engine)) return newton;
	return nullptr;
}

bool hasTimeStepper(const Scene& scene)
{
	return std::any_of(scene.engines.begin(), scene.engines.end(),
			   [](const auto& engine) { return isActiveTimeStepper(*engine); });
}

/// (Between two steps the last reset is that of the step before. It is 0 as well in a scene that
/// was loaded.)
bool hasForcesOfLastStep(const Scene& scene)
{
	const auto* integrator = softGrainIntegratorOf(scene);
	if (!integrator || integrator->dead) return true;
	if (integrator->hasPublishedSince(scene.iter)) return true; // or O.resetTime() was called
	const long last = scene.iter - 1;
	return scene.forces.lastReset == std::max(last, 0L) &&
	       (last > 0 || integrator->hasPublishedIn(0));
}

void checkEngineOrder(const Scene& scene, const SoftGrainIntegrator& integrator)
{
	const auto begin = scene.engines.begin(), end = scene.engines.end();
	const auto self = std::find_if(
		begin, end, [&](const auto& engine) { return engine.get() == &integrator; });
	for (auto engine = begin; engine != self; ++engine)
		checkBefore(**engine);
	for (auto engine = self; engine != end; ++engine)
		checkAfter(**engine);
	if (countLive<SoftGrainIntegrator>(begin, end) > 1)
		refuse("O.engines holds two SoftGrainIntegrators; each moves all soft grains: "
		       "leave one");
	if (countLive<ForceResetter>(begin, self) == 0)
		refuse("there is no ForceResetter before it in O.engines that is not dead: contact "
		       "forces would act again as loads in the next step. See sg.engines()");
	if (countLive<Collider>(begin, self) == 0)
		refuse("there is no collider before it in O.engines that is not dead: bodies would "
		       "pass through each other. See sg.engines()");
	if (countLive<InteractionLoop>(begin, self) == 0)
		refuse("there is no InteractionLoop before it in O.engines that is not dead: it "
		       "finds the contacts. See sg.engines()");
	for (auto engine = begin; engine != firstLive<ForceResetter>(begin, self); ++engine)
		checkBeforeReset(**engine);
	if (countLive<ForceResetter>(firstLive<InteractionLoop>(begin, self), self) > 0)
		refuse("a ForceResetter stands between InteractionLoop and SoftGrainIntegrator in "
		       "O.engines and would take away the forces of rigid bodies on each other: "
		       "leave one before InteractionLoop");
	const long newtons = countLive<NewtonIntegrator>(self, end);
	if (newtons == 0)
		refuse("there is no NewtonIntegrator after it in O.engines that is not dead: it "
		       "carries State along. See sg.engines()");
	if (newtons > 1)
		refuse("O.engines holds two NewtonIntegrators, each of which carries State along: "
		       "leave one, or set dead = True");
	const auto newton = firstLive<NewtonIntegrator>(self, end);
	for (auto engine = self; engine != newton; ++engine)
		checkBehindSolve(scene, **engine);
	if (countLive<ForceResetter>(self, newton) > 0)
		refuse("a ForceResetter stands between SoftGrainIntegrator and NewtonIntegrator in "
		       "O.engines and would take away the reactions on rigid bodies: leave the one "
		       "before SoftGrainIntegrator");
}

} // namespace yade
