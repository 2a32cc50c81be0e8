#include "SoftMat.hpp"
#include "Require.hpp"

namespace yade {

YADE_PLUGIN((SoftMat));

void SoftMat::postLoad(SoftMat&)
{
	softgrain::require(massScaling >= 1 && math::isfinite(massScaling), "massScaling",
			   massScaling, "[1, inf)");
	constants().validate();
	damping().validate();
	constitutiveLaw();
	softgrain::conditionByName(condition);
	softgrain::require(frictionAngle >= 0 && frictionAngle < Mathr::PI / 2, "frictionAngle",
			   frictionAngle, "[0, pi/2) rad");
}

softgrain::Condition SoftMat::conditionIn(int dim) const
{
	softgrain::require(dim == 2 || dim == 3, "dim", dim, "2, 3");
	return dim == 3 ? softgrain::Condition::solid : softgrain::conditionByName(condition);
}

} // namespace yade
