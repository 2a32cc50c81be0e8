#include "classes/NonsmoothLaw.hpp"
#include "checks/Engines.hpp"
#include "scene/PeriodicCell.hpp"

namespace yade {

YADE_PLUGIN((
	Ig2_Sphere_Sphere_ScGeom_Ahead)(Ig2_Facet_Sphere_ScGeom_Ahead)(Ig2_Box_Sphere_ScGeom_Ahead)(Ig2_Wall_Sphere_ScGeom_Ahead)(Law2_ScGeom_FrictPhys_Nonsmooth));

CREATE_LOGGER(Law2_ScGeom_FrictPhys_Nonsmooth);

namespace {

Real radiusOf(const Shape& shape) { return static_cast<const Sphere&>(shape).radius; }

/// By which periods body #2 is displaced, known that an interaction which is not real yet may name
/// others.
Vector3r shiftOf(const Scene& scene, const State& state1, const State& state2, Interaction& I)
{
	if (!I.isReal()) chooseNearestImage(scene, state1.pos, state2.pos, I);
	return imageShift(scene, I);
}

/// Makes a functor of YADE see a sphere (#2) that is larger by `reach`, and takes that out of the
/// geometry again. `pointMoves`: whether the contact point it gives depends on the radius.
template <class Go>
bool goAhead(Go&& go, const shared_ptr<Shape>& sphere, Real reach, bool pointMoves,
	     const shared_ptr<Interaction>& I)
{
	static thread_local const shared_ptr<Shape> grown { new Sphere };
	const Real radius = radiusOf(*sphere);
	static_cast<Sphere&>(*grown).radius = radius + reach;
	if (!go(grown)) return false;
	ScGeom& geom = static_cast<ScGeom&>(*I->geom);
	geom.penetrationDepth -= reach;
	geom.radius2 = radius;
	if (pointMoves) geom.contactPoint += 0.5 * reach * geom.normal;
	return true;
}

} // namespace

bool Ig2_Sphere_Sphere_ScGeom_Ahead::go(const shared_ptr<Shape>& shape1,
					const shared_ptr<Shape>& shape2, const State& state1,
					const State& state2, const Vector3r&, const bool& force,
					const shared_ptr<Interaction>& I)
{
	const Vector3r shift2 = shiftOf(*scene, state1, state2, *I);
	const Real reach = nonsmoothReach * std::min(radiusOf(*shape1), radiusOf(*shape2));
	return goAhead(
		[&](const shared_ptr<Shape>& grown) {
			return Ig2_Sphere_Sphere_ScGeom::go(shape1, grown, state1, state2, shift2,
							    force, I);
		},
		shape2, reach, true, I);
}

#define SOFTGRAIN_GO_AHEAD(Base, PointMoves, Radius1)                                              \
	bool Base##_Ahead::go(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,    \
			      const State& state1, const State& state2, const Vector3r&,           \
			      const bool& force, const shared_ptr<Interaction>& I)                 \
	{                                                                                          \
		const Vector3r shift2 = shiftOf(*scene, state1, state2, *I);                       \
		const Real radius = radiusOf(*shape2);                                             \
		const bool found = goAhead(                                                        \
			[&](const shared_ptr<Shape>& grown) {                                      \
				return Base::go(shape1, grown, state1, state2, shift2, force, I);  \
			},                                                                         \
			shape2, nonsmoothReach * radius, PointMoves, I);                           \
		if (found) static_cast<ScGeom&>(*I->geom).radius1 = (Radius1) * radius;            \
		return found;                                                                      \
	}
SOFTGRAIN_GO_AHEAD(Ig2_Facet_Sphere_ScGeom, true, 2)
SOFTGRAIN_GO_AHEAD(Ig2_Box_Sphere_ScGeom, true, 1)
SOFTGRAIN_GO_AHEAD(Ig2_Wall_Sphere_ScGeom, false, 1)
#undef SOFTGRAIN_GO_AHEAD

NonsmoothLaw nonsmoothLawOf(const Scene& scene)
{
	for (const auto& engine : scene.engines) {
		const auto* loop = dynamic_cast<const InteractionLoop*>(engine.get());
		if (!loop) continue;
		for (const auto& functor : loop->lawDispatcher->functors)
			if (const auto law =
				    YADE_PTR_DYN_CAST<Law2_ScGeom_FrictPhys_Nonsmooth>(functor))
				return { law, loop->lawDispatcher };
	}
	return {};
}

/// (Each thread that comes first in a step finds the same.)
bool Law2_ScGeom_FrictPhys_Nonsmooth::isInUse()
{
	const long now = 2 * scene->iter;
	long known = inUse_.load(std::memory_order_relaxed);
	if (known != now && known != now + 1) {
		known = now + bool(nonsmoothLawOf(*scene).law);
		inUse_.store(known, std::memory_order_relaxed);
	}
	return known != now;
}

bool Law2_ScGeom_FrictPhys_Nonsmooth::go(shared_ptr<IGeom>& geom, shared_ptr<IPhys>&, Interaction*)
{
	if (!isInUse()) return false; // YADE makes the interaction anew, by what is there now
	if (!checked_.load(std::memory_order_relaxed) && !checked_.exchange(true)) {
		if (!softGrainIntegratorOf(*scene))
			LOG_ERROR("there is no SoftGrainIntegrator in O.engines, which solves the "
				  "contacts of this law: they bear no force. See sg.engines()");
	}
	const ScGeom& g = static_cast<ScGeom&>(*geom);
	// a little further than where the pair was found, or it would come and go
	return g.penetrationDepth > -1.2 * nonsmoothReach * std::min(g.radius1, g.radius2);
}

} // namespace yade
