#include "classes/SoftSearch.hpp"
#include "assembly/RigidInKernel.hpp"
#include "classes/SoftContact.hpp"
#include "scene/Bodies.hpp"
#include "scene/HostTimeStep.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/SceneAssembly.hpp"
#include "scene/Timing.hpp"

#include <functional>
#include <limits>
#include <typeinfo>

namespace yade {

YADE_PLUGIN((
	Ig2_SoftGrain_SoftGrain_SoftGeom)(Ig2_Wall_SoftGrain_SoftGeom)(Ig2_Sphere_SoftGrain_SoftGeom)(Ig2_Facet_SoftGrain_SoftGeom)(Ig2_Box_SoftGrain_SoftGeom));

using softgrain::Vec3;

namespace {

/// The SoftGeom of the interaction, made if there is none, bound to the assembly and its first
/// grain. An interaction that stays potential keeps it: it knows the nodes that come near, most of
/// which are looked at again in the next step. (No pointer is copied: the counter of its owners
/// lies elsewhere in memory, and every pair would wait for it.)
SoftGeom& geometryOf(Interaction& I, const std::shared_ptr<softgrain::GrainAssembly>& assembly,
		     int first, const Vector3r& between)
{
	const bool isNew = !I.geom;
	if (isNew) I.geom = shared_ptr<SoftGeom>(new SoftGeom);
	auto& geom = static_cast<SoftGeom&>(*I.geom);
	if (isNew) geom.contactPoint = between; // until contact points tell
	geom.bind(assembly, first);
	return geom;
}

/// Memory takes so many searches to come (doc/decisions/0029-memory.md).
constexpr int turnsAhead = 3;

/// A turn of the InteractionLoop, which would wait for memory at every pair: asks for that of a
/// turn to come, and notes what it has read itself, for the next step.
class LoopTurn {
public:
	LoopTurn(softgrain::LoopMemory& memory, const Interaction& I)
		: memory_(memory)
		, I_(I)
	{
		memory_.fetch(I.linIx + turnsAhead);
		read_.add(I);
	}
	~LoopTurn() { memory_.note(I_.linIx, read_); }
	/// After a search.
	void noteSearch(const SoftGeom& geom)
	{
		if (I_.phys) read_.add(static_cast<const SoftPhys&>(*I_.phys));
		read_.add(geom);
		geom.pair->addMemory(read_);
	}

private:
	softgrain::LoopMemory& memory_;
	const Interaction& I_;
	softgrain::MemoryPieces read_;
};

/// Whether the grain is in an assembly, as that of the body `id`: one that a script gave to another
/// body is so from the next assembly on. `force` makes the first one, for interactions that a
/// script creates before the first step.
bool isAssembled(const SoftGrain& grain, int id, Scene& scene, bool force)
{
	if (!grain.assembly && force) assembleScene(scene);
	return grain.assembly && grain.assembly->idOf(grain.index) == id &&
	       isFit(*grain.assembly, scene);
}

/// Whether the grain lies where it was when it fell asleep, as far as the last step knew.
bool liesAsleep(const SoftGrain& grain)
{
	return grain.assembly->isAsleep(grain.index) && !grain.assembly->host.moved[grain.index];
}

/// Whether a body still has the shape for which YADE chose a functor for its interaction: a shape
/// that was exchanged by hand is told by this alone.
bool isSoft(const Shape& shape) { return typeid(shape) == typeid(SoftGrain); }

/// Books its lifetime as a search on a functor, which several threads may call at a time.
class SearchTimer {
public:
	explicit SearchTimer(const IGeomFunctor& functor)
		: functor_(functor)
		, start_(TimingInfo::getNow())
	{
	}
	~SearchTimer()
	{
		if (!TimingInfo::enabled) return;
		const auto now = TimingInfo::getNow();
// threads that wait for a moment are not put to sleep, which would take longer than a search
#pragma omp critical(softgrainSearchTimes)
		addTime(*functor_.timingDeltas, "findContacts", now - start_, 1);
	}

private:
	const IGeomFunctor& functor_;
	TimingInfo::delta start_;
};

/// Length of the coming step for the reach of the search. In the first step O.dt may still be
/// YADE's default, which SoftGrainIntegrator replaces by the critical step at most.
Real searchStep(const Scene& scene, const SoftGrain& grain)
{
	const bool unset = scene.dt == defaultTimeStep();
	return unset ? grain.assembly->criticalTimeStep() : scene.dt;
}

/// Whether the last step found a force; SoftGrainIntegrator has described the pair then.
bool bearsForce(const Interaction& I)
{
	return I.phys && static_cast<const SoftPhys&>(*I.phys).activeContacts > 0;
}

void describeByCentres(SoftGeom& geom, const Vec3& normal, Real radius1, Real radius2)
{
	geom.normal = normal;
	geom.refR1 = radius1;
	geom.refR2 = radius2;
}

/// YADE's rules for Ig2: an interaction stays potential until there is a contact; once real it is
/// Law2 that ends it.
bool isToBeReal(const SoftGeom& geom, bool force, const Interaction& I)
{
	return geom.pair->isInUse() || I.isReal() || force;
}

/// On which side of a wall a grain lies, along its axis.
double sideOf(const Wall& wall, const State& state, const Vec3& grain)
{
	return grain[wall.axis] > state.pos[wall.axis] ? 1 : -1;
}
/// Whether it is not one-sided and the grain on its other side.
bool actsOn(const Wall& wall, const State& state, const Vec3& grain)
{
	return wall.sense == 0 || wall.sense == sideOf(wall, state, grain);
}

/// The part of a wall that a grain may touch: the face of a block, so wide and deep that the
/// grain meets none of its edges.
void describeFaceOfWall(const Wall& wall, const State& state, const SoftGrain& grain,
			softgrain::RigidBodyDescription& d)
{
	const softgrain::Box<3> box = grain.assembly->box(grain.index, softgrain::Mat3::Identity());
	constexpr double farOut = 4; // in sides of the grain
	const double halfSide = farOut * (box.high - box.low).maxCoeff();
	const Vec3 centre = box.centre();
	d.form = softgrain::RigidBodyDescription::Form::block;
	d.size = Vec3::Constant(halfSide);
	d.orientation = softgrain::Rotation::Identity();
	d.position = centre;
	d.position[wall.axis] = state.pos[wall.axis] - sideOf(wall, state, centre) * halfSide;
}

/// About its normal, the only way in which it stays a Wall.
bool turns(const Wall& wall, const State& state) { return state.angVel[wall.axis] != 0; }

} // namespace

std::array<Vector3r, 3> cornersOf(const Facet& facet, const State& state)
{
	std::array<Vector3r, 3> corner;
	for (int k = 0; k < 3; ++k)
		corner[k] = state.pos + state.ori * facet.vertices[k];
	return corner;
}

std::optional<softgrain::RigidBodyDescription> describeRigid(const Shape& shape, const State& state,
							     int id, const SoftGrain& grain)
{
	using Form = softgrain::RigidBodyDescription::Form;
	softgrain::RigidBodyDescription d;
	d.id = id;
	d.position = d.pivot = state.pos;
	d.velocity = state.vel;
	d.angularVelocity = state.angVel;
	d.orientation = state.ori;
	if (const auto* sphere = dynamic_cast<const Sphere*>(&shape)) {
		d.form = Form::ball;
		d.size = Vec3::Constant(sphere->radius);
	} else if (const auto* box = dynamic_cast<const Box*>(&shape)) {
		d.form = Form::block;
		d.size = box->extents;
	} else if (const auto* facet = dynamic_cast<const Facet*>(&shape)) {
		d.form = Form::plate;
		d.corner = cornersOf(*facet, state);
	} else if (const auto* wall = dynamic_cast<const Wall*>(&shape);
		   wall && (state.blockedDOFs != State::DOF_ALL || turns(*wall, state))) {
		describeFaceOfWall(*wall, state, grain, d);
	} else
		return std::nullopt;
	return d;
}

namespace {

/// That which the collider has of a body; in a cell, where they may be of another image, of all
/// space.
softgrain::Box<3> boxOf(const Scene& scene, const Body& body)
{
	constexpr Real infinity = std::numeric_limits<Real>::infinity();
	if (scene.isPeriodic || !body.bound)
		return { Vec3::Constant(-infinity), Vec3::Constant(infinity) };
	return { body.bound->min, body.bound->max };
}

/// Of all bodies about a grain, with which it has interactions.
std::vector<softgrain::NeighbourBoxes::Entry> boxesAbout(const Scene& scene, const Body& grain)
{
	std::vector<softgrain::NeighbourBoxes::Entry> boxes;
	for (const auto& [id, interaction] : grain.intrs)
		if (const auto& body = (*scene.bodies)[id])
			boxes.push_back({ id, boxOf(scene, *body) });
	return boxes;
}

/// What a rigid body of an interaction goes on as: walls, facets and boxes beside it about the
/// grain, each in the image nearest to that. Other threads choose the images of other interactions
/// meanwhile, which are not asked.
std::vector<softgrain::RigidBodyDescription>
othersBeside(const Interaction& I, const SoftGrain& grain, const State& soft, const Scene& scene)
{
	const auto& bodies = *scene.bodies;
	std::vector<softgrain::RigidBodyDescription> others;
	const auto about = boxOf(scene, *bodies[I.getId1()]).grown(grain.zeta * grain.radius);
	const auto& boxes = grain.assembly->host.neighbours.of(
		grain.index, scene.iter, [&] { return boxesAbout(scene, *bodies[I.getId2()]); });
	for (const auto& [id, box] : boxes) {
		if (id == I.getId1() || !about.overlaps(box)) continue;
		const auto& body = bodies[id]; // it may have been erased since
		if (!body || !body->shape) continue;
		auto d = describeRigid(*body->shape, *body->state, id, grain);
		if (const auto* wall = dynamic_cast<const Wall*>(body->shape.get())) {
			if (!actsOn(*wall, *body->state, soft.pos)) continue;
			d.emplace();
			d->id = Body::ID_NONE; // before all others
			describeFaceOfWall(*wall, *body->state, grain, *d);
		}
		if (!d || d->form == softgrain::RigidBodyDescription::Form::ball) continue;
		const Vector3r shift =
			shiftToNearest(scene, { id, body->state->pos }, { I.getId2(), soft.pos });
		others.push_back(displaced(*d, shift));
	}
	return others;
}

} // namespace

bool Ig2_SoftGrain_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
					  const shared_ptr<Shape>& shape2, const State& state1,
					  const State& state2, const Vector3r&, const bool& force,
					  const shared_ptr<Interaction>& I)
{
	if (!isSoft(*shape1) || !isSoft(*shape2)) return false;
	const SoftGrain& grain1 = static_cast<SoftGrain&>(*shape1);
	const SoftGrain& grain2 = static_cast<SoftGrain&>(*shape2);
	if (!isAssembled(grain1, I->getId1(), *scene, force) ||
	    !isAssembled(grain2, I->getId2(), *scene, force) || grain1.assembly != grain2.assembly)
		return I->isReal();
	if (!I->isReal() && !force && liesAsleep(grain1) && liesAsleep(grain2))
		return false; // apart when they fell asleep
	const SearchTimer timer(*this);
	LoopTurn turn(grain1.assembly->host.searches, *I);
	const auto [first, second] = std::minmax(grain1.index, grain2.index);
	if (!I->isReal())
		chooseNearestImage(*scene, grain1.written.position, grain2.written.position, *I);
	const auto image = imageOf(*scene, *I, second == grain2.index);
	const Real dt = searchStep(*scene, grain1);
	if (!I->isReal() && !force && grain1.assembly->areFarApart(first, second, image, dt))
		return false;
	const Vector3r place2 = state2.pos + imageShift(*scene, *I);
	SoftGeom& geom = geometryOf(*I, grain1.assembly, first, 0.5 * (state1.pos + place2));
	grain1.assembly->search(*geom.pair, first, second, image, dt);
	turn.noteSearch(geom);
	if (!bearsForce(*I))
		describeByCentres(geom, (place2 - state1.pos).normalized(), grain1.radius,
				  grain2.radius);
	return isToBeReal(geom, force, *I);
}

bool Ig2_SoftGrain_SoftGrain_SoftGeom::goReverse(const shared_ptr<Shape>& shape1,
						 const shared_ptr<Shape>& shape2,
						 const State& state1, const State& state2,
						 const Vector3r& shift2, const bool& force,
						 const shared_ptr<Interaction>& I)
{
	return go(shape1, shape2, state1, state2, shift2, force, I);
}

bool SearchOnRigid::go(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,
		       const State& state1, const State& state2, const Vector3r&, const bool& force,
		       const shared_ptr<Interaction>& I)
{
	if (!isFor(*shape1) || !isSoft(*shape2)) return false;
	const SoftGrain& grain = static_cast<SoftGrain&>(*shape2);
	if (!isAssembled(grain, I->getId2(), *scene, force)) return I->isReal();
	// where YADE would look for an Ip2 in vain, and end the process
	if (!I->phys && !hasFriction(*(*scene->bodies)[I->getId1()])) return I->isReal();
	const SearchTimer timer(*this);
	LoopTurn turn(grain.assembly->host.searches, *I);
	SoftGeom& geom = geometryOf(*I, grain.assembly, grain.index, state2.pos);
	const Vec3 normal = search(*shape1, state1, grain, state2, *I, *geom.pair);
	turn.noteSearch(geom);
	const auto* ball = dynamic_cast<const Sphere*>(shape1.get());
	if (!bearsForce(*I))
		describeByCentres(geom, normal, ball ? ball->radius : grain.radius, grain.radius);
	return isToBeReal(geom, force, *I);
}

bool SearchOnRigid::goReverse(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,
			      const State& state1, const State& state2, const Vector3r& shift2,
			      const bool& force, const shared_ptr<Interaction>& I)
{
	return go(shape2, shape1, state2, state1, -shift2, force, I);
}

Vector3r SearchOnRigid::search(const Shape& shape, const State& rigid, const SoftGrain& grain,
			       const State& soft, Interaction& I,
			       softgrain::PairContacts& pair) const
{
	chooseNearestImage(*scene, rigid.pos, grain.written.position, I);
	const auto image = imageOf(*scene, I, false);
	const auto others = [&] { return othersBeside(I, grain, soft, *scene); };
	grain.assembly->search(pair, grain.index, *describeRigid(shape, rigid, I.getId1(), grain),
			       std::cref(others), image, searchStep(*scene, grain));
	return (soft.pos - rigid.pos - image.shift).normalized();
}

Vector3r Ig2_Wall_SoftGrain_SoftGeom::search(const Shape& shape, const State& rigid,
					     const SoftGrain& grain, const State& soft,
					     Interaction& I, softgrain::PairContacts& pair) const
{
	const Wall& wall = static_cast<const Wall&>(shape);
	const double side = sideOf(wall, rigid, soft.pos), dt = searchStep(*scene, grain);
	Vec3 normal = Vec3::Zero();
	normal[wall.axis] = side;
	const softgrain::WallDescription plane { I.getId1(), rigid.pos, normal, rigid.vel };
	if (!actsOn(wall, rigid, soft.pos))
		grain.assembly->separate(pair, grain.index, plane);
	else if (const auto body = describeRigid(wall, rigid, I.getId1(), grain))
		grain.assembly->search(pair, grain.index, *body, {}, {}, dt);
	else
		grain.assembly->search(pair, grain.index, plane, dt);
	return normal;
}

} // namespace yade
