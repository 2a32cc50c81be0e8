#include "classes/SoftMat.hpp"
#include "Require.hpp"

namespace yade {

YADE_PLUGIN((SoftMat));

bool isFrictionAngle(Real angle) { return angle >= 0 && angle < Mathr::PI / 2; }

void requireFrictionAngle(const string& parameter, Real angle)
{
	softgrain::require(isFrictionAngle(angle), parameter, angle, "[0, pi/2) rad");
}

AssembledMaterial SoftMat::assembled() const
{
	softgrain::require(massScaling >= 1 && math::isfinite(massScaling), "massScaling",
			   massScaling, "[1, inf)");
	return { constants(), damping(), law, condition };
}

void SoftMat::postLoad(SoftMat&)
{
	assembled();
	constants().validate();
	damping().validate();
	constitutiveLaw();
	softgrain::conditionByName(condition);
	requireFrictionAngle("frictionAngle", frictionAngle);
}

softgrain::Condition SoftMat::conditionIn(int dim) const
{
	softgrain::require(dim == 2 || dim == 3, "dim", dim, "2, 3");
	return dim == 3 ? softgrain::Condition::solid : softgrain::conditionByName(condition);
}

} // namespace yade
