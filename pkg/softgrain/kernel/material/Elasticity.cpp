#include "material/Elasticity.hpp"
#include "Require.hpp"

#include <cmath>
#include <stdexcept>

namespace softgrain {

Law lawByName(const std::string& name)
{
	if (name == "neoHookean") return Law::neoHookean;
	throw std::invalid_argument("law = '" + name + "' is unknown; known laws: 'neoHookean'");
}

Condition conditionByName(const std::string& name)
{
	if (name == "planeStrain") return Condition::planeStrain;
	if (name == "planeStress") return Condition::planeStress;
	throw std::invalid_argument("condition = '" + name +
				    "' is unknown; known conditions: 'planeStrain', 'planeStress'");
}

void ElasticConstants::validate() const
{
	require(young > 0 && std::isfinite(young), "young", young, "(0, inf) Pa");
	require(poisson > -1 && poisson < 0.5, "poisson", poisson,
		"(-1, 0.5): at 0.5 the material is incompressible, which plane strain, plane "
		"stress and 3D exclude, at -1 it cannot be sheared");
	require(density > 0 && std::isfinite(density), "density", density, "(0, inf) kg/m^3");
}

double ElasticConstants::effectiveLambda(Condition condition) const
{
	const double l = lambda(), m = mu();
	return condition == Condition::planeStress ? 2 * l * m / (l + 2 * m) : l;
}

double ElasticConstants::waveSpeed(Condition condition) const
{
	return std::sqrt((effectiveLambda(condition) + 2 * mu()) / density);
}

} // namespace softgrain
