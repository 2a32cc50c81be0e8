#include "SoftMat.hpp"

namespace yade {

YADE_PLUGIN((SoftMat));

void SoftMat::postLoad(SoftMat&)
{
	constants().validate();
	constitutiveLaw();
	softgrain::conditionByName(condition);
	if (!(frictionAngle >= 0 && frictionAngle < Mathr::PI / 2))
		throw std::invalid_argument("frictionAngle = " + std::to_string(frictionAngle) +
					    " is outside the admissible range [0, pi/2) rad");
}

} // namespace yade
