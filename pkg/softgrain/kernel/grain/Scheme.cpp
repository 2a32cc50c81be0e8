#include "grain/Scheme.hpp"
#include "Require.hpp"

namespace softgrain {

void Scheme::validate(const TemplateRecipe& recipe) const
{
	require(picShare >= 0 && picShare <= 1, "picShare", picShare, "[0, 1]");
	require(picShare == 0 || hasPointVelocities(), "picShare", picShare,
		"0 where velocities stay at the nodes (velocityUpdate = 'nodal'); a PIC share "
		"needs "
		"velocityUpdate = 'flip' or formulation = 'updated'");
	require(formulation == Formulation::total || recipe.order >= 2, "order", recipe.order,
		"2, 3 for formulation = 'updated': the gradients of linear splines jump where a "
		"point "
		"crosses a cell");
}

} // namespace softgrain
