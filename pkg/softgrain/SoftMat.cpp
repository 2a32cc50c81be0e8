#include "SoftMat.hpp"
#include "Require.hpp"

namespace yade {

YADE_PLUGIN((SoftMat));

void SoftMat::postLoad(SoftMat&)
{
	constants().validate();
	constitutiveLaw();
	softgrain::conditionByName(condition);
	softgrain::require(frictionAngle >= 0 && frictionAngle < Mathr::PI / 2, "frictionAngle",
			   frictionAngle, "[0, pi/2) rad");
}

} // namespace yade
