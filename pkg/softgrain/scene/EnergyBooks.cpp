#include "scene/EnergyBooks.hpp"

#include <algorithm>
#include <cctype>

namespace yade {

using softgrain::EnergyBalance;
using softgrain::RigidBalance;

namespace {

template <class Balance> struct NamedEnergy {
	const char* name;
	double Balance::* value;
};

/// In the order of SoftGrainIntegrator.energies; from `firstSum` on those of workSums.
constexpr NamedEnergy<EnergyBalance> softEnergies[] = {
	{ "kinetic", &EnergyBalance::kinetic },   { "elastic", &EnergyBalance::elastic },
	{ "friction", &EnergyBalance::friction }, { "impact", &EnergyBalance::impact },
	{ "walls", &EnergyBalance::walls },       { "loads", &EnergyBalance::loads },
	{ "damping", &EnergyBalance::damping },   { "sleep", &EnergyBalance::sleep },
	{ "cell", &EnergyBalance::cell },         { "cohesion", &EnergyBalance::cohesion },
};
constexpr std::size_t firstSum = 2;

/// In the order of SoftGrainIntegrator.rigidEnergies; of these O.energy has the first two, since
/// YADE counts kinetic energy and gravity itself.
constexpr NamedEnergy<RigidBalance> rigidEnergies[] = {
	{ "rigidFriction", &RigidBalance::friction }, { "rigidImpact", &RigidBalance::impact },
	{ "rigidKinetic", &RigidBalance::kinetic },   { "rigidWalls", &RigidBalance::walls },
	{ "rigidCell", &RigidBalance::cell },         { "rigidLoads", &RigidBalance::loads },
};
constexpr std::size_t rigidEnergiesForYade = 2;

/// In the order of SoftGrainIntegrator.rigidWorkSums.
constexpr double RigidBalance::* rigidSums[] = { &RigidBalance::friction, &RigidBalance::impact,
						 &RigidBalance::walls, &RigidBalance::cell,
						 &RigidBalance::loads };

string yadeName(const char* soft)
{
	string name = string("soft") + soft;
	name[4] = static_cast<char>(std::toupper(name[4]));
	return name;
}

} // namespace

EnergyLists energiesOf(const EnergyBalance& balance, bool withRigidBodies)
{
	EnergyLists lists;
	for (const auto& energy : softEnergies)
		lists.soft.push_back(balance.*energy.value);
	if (!withRigidBodies) return lists;
	for (const auto& energy : rigidEnergies)
		lists.rigid.push_back(balance.rigid.*energy.value);
	return lists;
}

EnergyLists sumsOf(const EnergyBalance& balance)
{
	EnergyLists sums;
	for (std::size_t k = firstSum; k < std::size(softEnergies); ++k)
		sums.soft.push_back(balance.*softEnergies[k].value);
	for (const auto sum : rigidSums)
		sums.rigid.push_back(balance.rigid.*sum);
	return sums;
}

bool restoreSums(const EnergyLists& sums, EnergyBalance& balance)
{
	const bool soft = sums.soft.size() == std::size(softEnergies) - firstSum;
	const bool rigid = sums.rigid.size() == std::size(rigidSums);
	for (std::size_t k = 0; soft && k < sums.soft.size(); ++k)
		balance.*softEnergies[firstSum + k].value = sums.soft[k];
	for (std::size_t k = 0; rigid && k < sums.rigid.size(); ++k)
		balance.rigid.*rigidSums[k] = sums.rigid[k];
	return soft && rigid;
}

py::dict namedEnergies(const EnergyLists& energies)
{
	py::dict d;
	for (std::size_t k = 0; k < std::size(softEnergies); ++k)
		d[softEnergies[k].name] = k < energies.soft.size() ? energies.soft[k] : 0.;
	const std::size_t known = std::min(std::size(rigidEnergies), energies.rigid.size());
	for (std::size_t k = 0; k < known; ++k)
		d[rigidEnergies[k].name] = energies.rigid[k];
	return d;
}

void EnergyBooks::publish(const EnergyLists& energies, EnergyTracker& tracker)
{
	if (tracker.names.empty()) ids_.clear(); // as O.energy.clear() leaves it
	ids_.resize(std::size(softEnergies) + rigidEnergiesForYade, -1);
	for (std::size_t k = 0; k < energies.soft.size(); ++k)
		tracker.set(energies.soft[k], yadeName(softEnergies[k].name), ids_[k]);
	const std::size_t count = std::min(rigidEnergiesForYade, energies.rigid.size());
	for (std::size_t k = 0; k < count; ++k)
		tracker.set(energies.rigid[k], rigidEnergies[k].name,
			    ids_[energies.soft.size() + k]);
}

} // namespace yade
