#include "checks/HighPressure.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/Bodies.hpp"

#include <limits>
#include <sstream>

namespace yade {

namespace {

/// Mean pressure over young up to which forces were found right within some per cent (3 % of
/// squares that touch; single grains to 1: doc/decisions/0008-node-spacing.md); without a limit
/// where nothing was found.
double knownPressure(const SoftGrain& grain)
{
	if (grain.basis != "splines" || grain.nodeSpacing >= 2)
		return std::numeric_limits<double>::infinity();
	return grain.nodeSpacing < 1.5 ? 0.7 : 2;
}

/// -1: none holds any. Sleepers stay as they are.
int mostEnergetic(const Scene& scene, const softgrain::GrainAssembly& assembly)
{
	int found = -1;
	double highest = 0;
	for (int g = 0; g < assembly.grains(); ++g) {
		if (assembly.isRigid(g) || assembly.isAsleep(g)) continue;
		const double young = materialOf(scene, assembly.idOf(g)).young;
		const double density =
			assembly.energy(g).elastic / (young * assembly.undeformedVolume(g));
		if (density <= highest) continue;
		highest = density;
		found = g;
	}
	return found;
}

/// Pa
double meanPressure(const softgrain::PointFields& points, int dim)
{
	double sum = 0, volume = 0;
	for (std::size_t p = 0; p < points.volume.size(); ++p) {
		sum -= points.volume[p] * points.cauchy[p].diagonal().head(dim).sum() / dim;
		volume += points.volume[p];
	}
	return sum / volume;
}

} // namespace

std::string highPressure(const Scene& scene, const softgrain::GrainAssembly& assembly)
{
	const int g = mostEnergetic(scene, assembly);
	if (g < 0) return "";
	const int id = assembly.idOf(g);
	const SoftGrain& grain = grainOf(scene, id);
	const double pressure =
		meanPressure(assembly.points(g), grain.dim) / materialOf(scene, id).young;
	if (pressure <= knownPressure(grain)) return "";
	std::ostringstream message;
	message << "soft grain #" << id << " bears a mean pressure of " << pressure
		<< " young. With nodeSpacing = " << grain.nodeSpacing << " grains under more than "
		<< knownPressure(grain)
		<< " young may be too soft by some per cent, and fold at twice to several times "
		   "that; grains made with nodeSpacing = 2 were right to 8 young (user guide, "
		   "'High pressure')";
	return message.str();
}

} // namespace yade
