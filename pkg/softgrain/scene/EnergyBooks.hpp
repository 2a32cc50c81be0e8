// Energies of a step under the names by which Python and O.energy know them, and as the lists of
// numbers that YADE can save.
#pragma once

#include "Yade.hpp"
#include "step/System.hpp"

#include <vector>

namespace yade {

/// EnergyBalance and its RigidBalance as attributes of SoftGrainIntegrator.
struct EnergyLists {
	vector<Real> soft, rigid; ///< J (2D: J/m)
};

/// All energies of a balance, those of rigid bodies only if asked for.
EnergyLists energiesOf(const softgrain::EnergyBalance& balance, bool withRigidBodies);

/// Those that are summed over a run, which a save needs.
EnergyLists sumsOf(const softgrain::EnergyBalance& balance);

/// The sums back; those of a list of another length are left as they are. Returns whether both
/// lists were whole.
bool restoreSums(const EnergyLists& sums, softgrain::EnergyBalance& balance);

/// Under their names, those of lists that are still empty as 0 (soft) or not at all (rigid).
py::dict namedEnergies(const EnergyLists& energies);

/// What O.energy gets of them, softKinetic ... rigidImpact.
class EnergyBooks {
public:
	void publish(const EnergyLists& energies, EnergyTracker& tracker);

private:
	std::vector<int> ids_; ///< by which the tracker knows them
};

} // namespace yade
