#include "classes/SoftContact.hpp"
#include "python/PythonArrays.hpp"

#include <algorithm>
#include <functional>
#include <limits>

namespace yade {

YADE_PLUGIN((
	SoftGeom)(SoftInterface)(SoftPhys)(Ip2_SoftPhys)(Ip2_SoftMat_SoftMat_SoftPhys)(Ip2_FrictMat_SoftMat_SoftPhys)(Law2_SoftGeom_SoftPhys_Nonsmooth));

using softgrain::ContactRecord;
using softgrain::Vec3;

void SoftGeom::bind(const std::shared_ptr<softgrain::GrainAssembly>& present, int first)
{
	if (pair && assembly == present) return;
	if (pair && assembly->idOf(pair->firstGrain()) != present->idOf(first)) pair->swapGrains();
	const bool isTurned =
		!pair && savedFirst != Body::ID_NONE && savedFirst != present->idOf(first);
	const auto records = pair ? pair->records() : savedRecords();
	const bool isReadable = pair || isSavedWhole();
	const std::vector<double> history = pair ? pair->interfaceHistory() : savedInterface;
	const softgrain::OverlapAccount account =
		pair ? pair->account() : softgrain::OverlapAccount { savedAccount, savedGrace };
	const std::vector<double> rest = pair ? pair->rest() : savedRest;
	assembly = present;
	pair = present->newPair();
	pair->restore(records);
	pair->restoreAccount(account);
	pair->restoreInterface(history);
	pair->restoreRest(rest);
	if (!isReadable) pair->noteUnreadable("its contacts were saved with", savedKeys.size());
	if (isTurned) pair->swapGrains();
}

bool SoftGeom::isSavedWhole() const
{
	const std::size_t count = savedImpulses.size();
	return savedKeys.size() == 3 * count && savedNormals.size() == count &&
	       savedTwists.size() == count;
}

/// Keys, impulses and how they turn; the others are found anew by the search. None where what was
/// saved does not belong together.
std::vector<ContactRecord> SoftGeom::savedRecords() const
{
	if (!isSavedWhole()) return {};
	std::vector<ContactRecord> records(savedImpulses.size());
	for (std::size_t k = 0; k < records.size(); ++k) {
		records[k].key = { savedKeys[3 * k], savedKeys[3 * k + 1], savedKeys[3 * k + 2] };
		records[k].impulse = savedImpulses[k];
		records[k].normal = savedNormals[k];
		records[k].twist = savedTwists[k];
	}
	return records;
}

void SoftGeom::preSave(SoftGeom&)
{
	if (!pair) return;
	savedFirst = assembly->idOf(pair->firstGrain());
	savedKeys.clear();
	savedImpulses.clear();
	savedNormals.clear();
	savedTwists.clear();
	savedAccount = pair->account().taken;
	savedGrace = pair->account().grace;
	savedRest = pair->rest();
	savedInterface = pair->interfaceHistory();
	for (const ContactRecord& c : pair->records()) {
		savedKeys.insert(savedKeys.end(), { c.key.side, c.key.node, c.key.other });
		savedImpulses.push_back(c.impulse);
		savedNormals.push_back(c.normal);
		savedTwists.push_back(c.twist);
	}
}

namespace {

/// One quantity of all records as an array.
template <class Record, class Get>
py::object column(const std::vector<Record>& records, const Get& get)
{
	using Value = std::decay_t<std::invoke_result_t<Get, const Record&>>;
	std::vector<Value> values;
	for (const Record& record : records)
		values.push_back(std::invoke(get, record));
	if constexpr (std::is_arithmetic_v<Value>)
		return softgrain::numpyArray(values, py::make_tuple(-1));
	else
		return softgrain::numpyArray(values);
}

} // namespace

int SoftGeom::firstBody() const { return pair ? assembly->idOf(pair->firstGrain()) : -1; }

py::dict SoftGeom::contactArrays() const
{
	using softgrain::ContactPressure;
	const auto records = pair ? pair->records() : std::vector<ContactRecord>();
	const auto pressures = pair ? pair->pressures() : std::vector<ContactPressure>();
	const Real kick = pair ? pair->kick() : 0;
	auto impulse = [](const ContactRecord& c) { return Vec3(c.impulse + c.pull); };
	auto force = [&](const ContactRecord& c) {
		return kick > 0 ? Vec3(impulse(c) / kick) : Vec3(Vec3::Zero());
	};
	py::dict arrays;
	arrays["point"] = column(records, &ContactRecord::point);
	arrays["normal"] = column(records, &ContactRecord::normal);
	arrays["impulse"] = column(records, impulse);
	arrays["force"] = column(records, force);
	arrays["shear"] = column(pressures, &ContactPressure::shear);
	arrays["gap"] = column(records, &ContactRecord::gap);
	arrays["area"] = column(pressures, &ContactPressure::area);
	arrays["pressure"] = column(pressures, &ContactPressure::pressure);
	arrays["side"] = column(records, [](const ContactRecord& c) { return c.key.body(); });
	arrays["node"] = column(records, [](const ContactRecord& c) {
		return c.key.isOfEdges() ? -1 : c.key.node;
	});
	arrays["bond"] = column(records, [](const ContactRecord& c) { return int(c.bond); });
	arrays["damage"] = column(records, &ContactRecord::damage);
	return arrays;
}

int SoftGeom::bondTouching()
{
	if (!pair)
		throw std::runtime_error("bond: the contact points are not known yet, as after "
					 "O.load; make a step before");
	return pair->bondTouching();
}

int SoftGeom::wholeBonds() const
{
	if (!pair) return 0;
	const auto records = pair->records();
	return static_cast<int>(
		std::count_if(records.begin(), records.end(), [](const ContactRecord& c) {
			return c.bond == softgrain::Bond::whole;
		}));
}

namespace {

/// Of two materials; no number where one of the angles is none.
Real angleBetween(Real angle1, Real angle2)
{
	const bool valid = isFrictionAngle(angle1) && isFrictionAngle(angle2);
	return valid ? std::min(angle1, angle2) : std::numeric_limits<Real>::quiet_NaN();
}

/// Whether it gives one without the values of the materials.
bool hasValueFor(int id1, int id2, const MatchMaker& match)
{
	const auto isOfPair = [&](const Vector3r& m) {
		return std::minmax({ static_cast<int>(m[0]), static_cast<int>(m[1]) }) ==
		       std::minmax({ id1, id2 });
	};
	return match.algo == "val" ||
	       std::any_of(match.matches.begin(), match.matches.end(), isOfPair);
}

/// The step refuses what is no number.
Real tangentOf(Real angle)
{
	return isFrictionAngle(angle) ? std::tan(angle) : std::numeric_limits<Real>::quiet_NaN();
}

} // namespace

void Ip2_SoftPhys::makePhys(const shared_ptr<Interaction>& I, const Material& m1,
			    const Material& m2, Real frictionAngle1, Real frictionAngle2,
			    Real stiffness) const
{
	auto found = [&](const MatchMaker& match, Real ofFirst, Real ofSecond) {
		try {
			return match(m1.id, m2.id, ofFirst, ofSecond);
		} catch (const std::exception&) { // the step refuses what is no number
			return std::numeric_limits<Real>::quiet_NaN();
		}
	};
	auto matched = [&](const shared_ptr<MatchMaker>& match, Real otherwise) {
		return match && hasValueFor(m1.id, m2.id, *match)
			       ? found(*match, otherwise, otherwise)
			       : otherwise;
	};
	const auto phys = shared_ptr<SoftPhys>(new SoftPhys);
	const Real angle = frictAngle ? found(*frictAngle, frictionAngle1, frictionAngle2)
				      : angleBetween(frictionAngle1, frictionAngle2);
	phys->tangensOfFrictionAngle = tangentOf(angle);
	phys->kn = phys->ks = stiffness;
	I->phys = phys;

	const auto interface = shared_ptr<SoftInterface>(new SoftInterface);
	const softgrain::InterfaceLaw none = interface->law();
	const Real slidingAngle = matched(dynamicFrictAngle, angle);
	if (slidingAngle != angle)
		interface->tangensOfDynamicFrictionAngle = tangentOf(slidingAngle);
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
	if (!g.pair) return true; // loaded, without an assembly: SoftGrainIntegrator reports why
	g.pair->setFriction(p.tangensOfFrictionAngle);
	g.pair->setInterface(p.interface ? std::optional(p.interface->law()) : std::nullopt);
	return g.pair->isInUse();
}

} // namespace yade
