#include "checks/Engines.hpp"
#include "Yade.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "classes/WallStressController.hpp"

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
	for (const auto& engine : scene.engines)
		if (const auto integrator = YADE_PTR_DYN_CAST<SoftGrainIntegrator>(engine))
			return integrator.get();
	return nullptr;
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
	if (std::count_if(begin, end, [](const auto& engine) {
		    return dynamic_cast<const SoftGrainIntegrator*>(engine.get());
	    }) > 1)
		refuse("O.engines holds two SoftGrainIntegrators; each moves all soft grains: "
		       "leave one");
	if (countLive<ForceResetter>(begin, self) == 0)
		refuse("there is no ForceResetter before it in O.engines that is not dead: contact "
		       "forces would act again as loads in the next step. See sg.engines()");
	if (countLive<InteractionLoop>(begin, self) == 0)
		refuse("there is no InteractionLoop before it in O.engines that is not dead: it "
		       "finds the contacts. See sg.engines()");
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
	if (countLive<ForceResetter>(self, firstLive<NewtonIntegrator>(self, end)) > 0)
		refuse("a ForceResetter stands between SoftGrainIntegrator and NewtonIntegrator in "
		       "O.engines and would take away the reactions on rigid bodies: leave the one "
		       "before SoftGrainIntegrator");
}

} // namespace yade
