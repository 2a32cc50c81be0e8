#include "SoftContact.hpp"
#include "PeriodicCell.hpp"
#include "PythonArrays.hpp"
#include "SceneAssembly.hpp"
#include "Timing.hpp"

#include <mutex>

namespace yade {

YADE_PLUGIN((
	SoftGeom)(SoftInterface)(SoftPhys)(Ig2_SoftGrain_SoftGrain_SoftGeom)(Ig2_Wall_SoftGrain_SoftGeom)(Ig2_Sphere_SoftGrain_SoftGeom)(Ig2_Facet_SoftGrain_SoftGeom)(Ig2_Box_SoftGrain_SoftGeom)(Ip2_SoftPhys)(Ip2_SoftMat_SoftMat_SoftPhys)(Ip2_FrictMat_SoftMat_SoftPhys)(Law2_SoftGeom_SoftPhys_Nonsmooth));

using softgrain::ContactRecord;
using softgrain::Vec3;

void SoftGeom::bind(const std::shared_ptr<softgrain::GrainAssembly>& present)
{
	if (pair && assembly == present) return;
	std::vector<ContactRecord> records;
	const std::vector<double> history = pair ? pair->interfaceHistory() : savedInterface;
	const std::vector<double> rest = pair ? pair->rest() : savedRest;
	if (pair)
		records = pair->records();
	else
		for (std::size_t k = 0; k < savedImpulses.size(); ++k)
			records.push_back(
				{ { savedKeys[3 * k], savedKeys[3 * k + 1], savedKeys[3 * k + 2] },
				  Vec3::Zero(),
				  Vec3::Zero(),
				  savedImpulses[k],
				  0 }); // history has the rest
	assembly = present;
	pair = present->newPair();
	pair->restore(records);
	pair->restoreInterface(history);
	pair->restoreRest(rest);
}

void SoftGeom::preSave(SoftGeom&)
{
	if (!pair) return;
	savedKeys.clear();
	savedImpulses.clear();
	savedRest = pair->rest();
	savedInterface = pair->interfaceHistory();
	for (const ContactRecord& c : pair->records()) {
		savedKeys.insert(savedKeys.end(), { c.key.side, c.key.node, c.key.other });
		savedImpulses.push_back(c.impulse);
	}
}

py::dict SoftGeom::contactArrays() const
{
	std::vector<Vec3> point, normals, impulse, force, shear;
	std::vector<double> gap;
	std::vector<int> side, node, bond;
	std::vector<double> area, pressure, damage;
	if (pair) {
		for (const ContactRecord& c : pair->records()) {
			point.push_back(c.point);
			normals.push_back(c.normal);
			const Vec3 together = c.impulse + c.pull;
			impulse.push_back(together);
			force.push_back(pair->kick() > 0 ? Vec3(together / pair->kick())
							 : Vec3(Vec3::Zero()));
			bond.push_back(static_cast<int>(c.bond));
			damage.push_back(c.damage);
			gap.push_back(c.gap);
			side.push_back(c.key.side);
			node.push_back(c.key.node);
		}
		for (const softgrain::ContactPressure& p : pair->pressures()) {
			area.push_back(p.area);
			pressure.push_back(p.pressure);
			shear.push_back(p.shear);
		}
	}
	py::dict arrays;
	arrays["point"] = softgrain::numpyArray(point);
	arrays["normal"] = softgrain::numpyArray(normals);
	arrays["impulse"] = softgrain::numpyArray(impulse);
	arrays["force"] = softgrain::numpyArray(force);
	arrays["shear"] = softgrain::numpyArray(shear);
	arrays["gap"] = softgrain::numpyArray(gap, py::make_tuple(-1));
	arrays["area"] = softgrain::numpyArray(area, py::make_tuple(-1));
	arrays["pressure"] = softgrain::numpyArray(pressure, py::make_tuple(-1));
	arrays["side"] = softgrain::numpyArray(side, py::make_tuple(-1));
	arrays["node"] = softgrain::numpyArray(node, py::make_tuple(-1));
	arrays["bond"] = softgrain::numpyArray(bond, py::make_tuple(-1));
	arrays["damage"] = softgrain::numpyArray(damage, py::make_tuple(-1));
	return arrays;
}

int SoftGeom::bondTouching() { return pair ? pair->bondTouching() : 0; }

namespace {

/// The SoftGeom of the interaction bound to the assembly, or null if there is nothing to search in:
/// the grains are not assembled (SoftGrainIntegrator will say why).
shared_ptr<SoftGeom> geometryOf(const Interaction& I,
				const std::shared_ptr<softgrain::GrainAssembly>& assembly)
{
	shared_ptr<SoftGeom> geom =
		I.geom ? YADE_PTR_CAST<SoftGeom>(I.geom) : shared_ptr<SoftGeom>(new SoftGeom);
	geom->bind(assembly);
	return geom;
}

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
		static std::mutex mutex;
		const auto now = TimingInfo::getNow();
		const std::lock_guard<std::mutex> lock(mutex);
		addTime(*functor_.timingDeltas, "findContacts", now - start_, 1);
	}

private:
	const IGeomFunctor& functor_;
	TimingInfo::delta start_;
};

/// Length of the coming step for the reach of the search. In the first step O.dt may still be
/// YADE's default, which SoftGrainIntegrator replaces by half the critical step or more.
Real searchStep(const Scene& scene, const SoftGrain& grain)
{
	const bool unset = scene.dt == defaultTimeStep();
	return unset ? grain.assembly->criticalTimeStep() : scene.dt;
}

/// Until there is a force: SoftGrainIntegrator knows better then.
void describeByCentres(SoftGeom& geom, const Interaction& I, const Vec3& normal, Real radius1,
		       Real radius2)
{
	if (I.phys && static_cast<const SoftPhys&>(*I.phys).activeContacts > 0) return;
	geom.normal = normal;
	geom.refR1 = radius1;
	geom.refR2 = radius2;
}

/// YADE's rules for Ig2: an interaction stays potential until there is a contact; once real it is
/// Law2 that ends it.
bool conclude(const shared_ptr<SoftGeom>& geom, bool force, const shared_ptr<Interaction>& I)
{
	if (!geom->pair->hasContact() && !I->isReal() && !force) return false;
	I->geom = geom;
	return true;
}

} // namespace

bool Ig2_SoftGrain_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
					  const shared_ptr<Shape>& shape2, const State& state1,
					  const State& state2, const Vector3r& shift2,
					  const bool& force, const shared_ptr<Interaction>& I)
{
	const SoftGrain& grain1 = static_cast<SoftGrain&>(*shape1);
	const SoftGrain& grain2 = static_cast<SoftGrain&>(*shape2);
	if (!grain1.assembly || grain1.assembly != grain2.assembly) return I->isReal();
	if (!I->isReal() && grain1.assembly->isAsleep(grain1.index) &&
	    grain1.assembly->isAsleep(grain2.index))
		return false; // apart when they fell asleep
	const SearchTimer timer(*this);
	const auto [first, second] = std::minmax(grain1.index, grain2.index);
	const auto image = imageOf(*scene, *I, second == grain2.index);
	const Real dt = searchStep(*scene, grain1);
	if (!I->isReal() && !force && grain1.assembly->areFarApart(first, second, image, dt))
		return false;
	const auto geom = geometryOf(*I, grain1.assembly);
	grain1.assembly->search(*geom->pair, first, second, image, dt);
	describeByCentres(*geom, *I, (state2.pos + shift2 - state1.pos).normalized(), grain1.radius,
			  grain2.radius);
	return conclude(geom, force, I);
}

bool Ig2_SoftGrain_SoftGrain_SoftGeom::goReverse(const shared_ptr<Shape>& shape1,
						 const shared_ptr<Shape>& shape2,
						 const State& state1, const State& state2,
						 const Vector3r& shift2, const bool& force,
						 const shared_ptr<Interaction>& I)
{
	return go(shape1, shape2, state1, state2, shift2, force, I);
}

namespace {

/// On which side of a wall a grain lies, along its axis.
double sideOf(const Wall& wall, const State& state, const Vec3& grain)
{
	return grain[wall.axis] > state.pos[wall.axis] ? 1 : -1;
}

/// The part of a free wall that a grain may touch: the face of a block, so wide and deep that the
/// grain meets none of its edges.
void describeFreeWall(const Wall& wall, const State& state, const SoftGrain& grain,
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

} // namespace

bool Ig2_Wall_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
				     const shared_ptr<Shape>& shape2, const State& state1,
				     const State& state2, const Vector3r&, const bool& force,
				     const shared_ptr<Interaction>& I)
{
	const Wall& wall = static_cast<Wall&>(*shape1);
	const SoftGrain& grain = static_cast<SoftGrain&>(*shape2);
	if (!grain.assembly) return I->isReal();
	const SearchTimer timer(*this);
	const auto geom = geometryOf(*I, grain.assembly);
	const double side = sideOf(wall, state1, state2.pos), dt = searchStep(*scene, grain);
	Vec3 normal = Vec3::Zero();
	normal[wall.axis] = side;
	if (wall.sense != 0 && wall.sense != side)
		geom->pair->restore({}); // the grain is on the side that does not interact
	else if (const auto body = describeRigid(wall, state1, I->getId1(), grain))
		grain.assembly->search(*geom->pair, grain.index, *body, {}, dt);
	else
		grain.assembly->search(*geom->pair, grain.index,
				       { I->getId1(), state1.pos, normal, state1.vel }, dt);
	describeByCentres(*geom, *I, normal, grain.radius, grain.radius);
	return conclude(geom, force, I);
}

std::optional<softgrain::RigidBodyDescription> describeRigid(const Shape& shape, const State& state,
							     int id, const SoftGrain& grain)
{
	using Form = softgrain::RigidBodyDescription::Form;
	softgrain::RigidBodyDescription d;
	d.id = id;
	d.position = state.pos;
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
		for (int k = 0; k < 3; ++k)
			d.corner[k] = state.pos + state.ori * facet->vertices[k];
	} else if (const auto* wall = dynamic_cast<const Wall*>(&shape);
		   wall && state.blockedDOFs != State::DOF_ALL) {
		describeFreeWall(*wall, state, grain, d);
	} else
		return std::nullopt;
	return d;
}

namespace {

/// Search of a soft grain (#2) on a rigid body; `size` stands for a radius of the body.
bool searchOnRigid(const IGeomFunctor& functor, const Shape& shape, const SoftGrain& grain,
		   const State& rigid, const State& soft, Real size, Real dt, bool force,
		   const shared_ptr<Interaction>& I)
{
	if (!grain.assembly) return I->isReal();
	const SearchTimer timer(functor);
	const auto geom = geometryOf(*I, grain.assembly);
	chooseNearestImage(*functor.scene, soft.pos, *I);
	const auto image = imageOf(*functor.scene, *I, false);
	grain.assembly->search(*geom->pair, grain.index,
			       *describeRigid(shape, rigid, I->getId1(), grain), image, dt);
	describeByCentres(*geom, *I, (soft.pos - rigid.pos - image.shift).normalized(), size,
			  grain.radius);
	return conclude(geom, force, I);
}

} // namespace

bool Ig2_Sphere_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
				       const shared_ptr<Shape>& shape2, const State& state1,
				       const State& state2, const Vector3r&, const bool& force,
				       const shared_ptr<Interaction>& I)
{
	const SoftGrain& grain = static_cast<SoftGrain&>(*shape2);
	return searchOnRigid(*this, *shape1, grain, state1, state2,
			     static_cast<Sphere&>(*shape1).radius, searchStep(*scene, grain), force,
			     I);
}

bool Ig2_Facet_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
				      const shared_ptr<Shape>& shape2, const State& state1,
				      const State& state2, const Vector3r&, const bool& force,
				      const shared_ptr<Interaction>& I)
{
	const SoftGrain& grain = static_cast<SoftGrain&>(*shape2);
	return searchOnRigid(*this, *shape1, grain, state1, state2, grain.radius,
			     searchStep(*scene, grain), force, I);
}

bool Ig2_Box_SoftGrain_SoftGeom::go(const shared_ptr<Shape>& shape1,
				    const shared_ptr<Shape>& shape2, const State& state1,
				    const State& state2, const Vector3r&, const bool& force,
				    const shared_ptr<Interaction>& I)
{
	const SoftGrain& grain = static_cast<SoftGrain&>(*shape2);
	return searchOnRigid(*this, *shape1, grain, state1, state2, grain.radius,
			     searchStep(*scene, grain), force, I);
}

#define SOFTGRAIN_GO_REVERSE(Functor)                                                              \
	bool Functor::goReverse(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,  \
				const State& state1, const State& state2, const Vector3r& shift2,  \
				const bool& force, const shared_ptr<Interaction>& I)               \
	{                                                                                          \
		return go(shape2, shape1, state2, state1, -shift2, force, I);                      \
	}
SOFTGRAIN_GO_REVERSE(Ig2_Wall_SoftGrain_SoftGeom)
SOFTGRAIN_GO_REVERSE(Ig2_Sphere_SoftGrain_SoftGeom)
SOFTGRAIN_GO_REVERSE(Ig2_Facet_SoftGrain_SoftGeom)
SOFTGRAIN_GO_REVERSE(Ig2_Box_SoftGrain_SoftGeom)
#undef SOFTGRAIN_GO_REVERSE

void Ip2_SoftPhys::makePhys(const shared_ptr<Interaction>& I, const Material& m1,
			    const Material& m2, Real frictionAngle1, Real frictionAngle2,
			    Real stiffness) const
{
	auto matched = [&](const shared_ptr<MatchMaker>& match, Real otherwise) {
		return match ? (*match)(m1.id, m2.id, otherwise, otherwise) : otherwise;
	};
	const auto phys = shared_ptr<SoftPhys>(new SoftPhys);
	const Real angle = frictAngle ? (*frictAngle)(m1.id, m2.id, frictionAngle1, frictionAngle2)
				      : std::min(frictionAngle1, frictionAngle2);
	phys->tangensOfFrictionAngle = std::tan(angle);
	phys->kn = phys->ks = stiffness;
	I->phys = phys;

	const auto interface = shared_ptr<SoftInterface>(new SoftInterface);
	const softgrain::InterfaceLaw none = interface->law();
	const Real slidingAngle = matched(dynamicFrictAngle, angle);
	if (slidingAngle != angle)
		interface->tangensOfDynamicFrictionAngle = std::tan(slidingAngle);
	interface->cohesion = matched(cohesion, 0);
	if (interface->cohesion != 0) interface->cohesionRange = matched(cohesionRange, 0);
	interface->bondStrength = matched(bondStrength, 0);
	if (interface->bondStrength != 0) {
		interface->bondEnergy = matched(bondEnergy, 0);
		interface->bondStiffness = matched(bondStiffness, 0);
		interface->bondAtTouch = bondAtTouch;
	}
	interface->restitution = matched(restitution, 0);
	if (!(interface->law() == none)) phys->interface = interface;
}

void Ip2_SoftMat_SoftMat_SoftPhys::go(const shared_ptr<Material>& m1,
				      const shared_ptr<Material>& m2,
				      const shared_ptr<Interaction>& I)
{
	if (I->phys) return;
	const SoftMat &soft1 = static_cast<SoftMat&>(*m1), &soft2 = static_cast<SoftMat&>(*m2);
	makePhys(I, soft1, soft2, soft1.frictionAngle, soft2.frictionAngle,
		 2 * soft1.young * soft2.young / (soft1.young + soft2.young));
}

void Ip2_FrictMat_SoftMat_SoftPhys::go(const shared_ptr<Material>& m1,
				       const shared_ptr<Material>& m2,
				       const shared_ptr<Interaction>& I)
{
	if (I->phys) return;
	makePhys(I, *m1, *m2, static_cast<FrictMat&>(*m1).frictionAngle,
		 static_cast<SoftMat&>(*m2).frictionAngle, 0);
}

bool Law2_SoftGeom_SoftPhys_Nonsmooth::go(shared_ptr<IGeom>& geom, shared_ptr<IPhys>& phys,
					  Interaction*)
{
	SoftGeom& g = static_cast<SoftGeom&>(*geom);
	const SoftPhys& p = static_cast<SoftPhys&>(*phys);
	g.pair->setFriction(p.tangensOfFrictionAngle);
	g.pair->setInterface(p.interface ? std::optional(p.interface->law()) : std::nullopt);
	return g.pair->hasContact();
}

} // namespace yade
