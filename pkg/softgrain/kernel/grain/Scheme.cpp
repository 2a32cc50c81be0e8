#include "grain/Scheme.hpp"
#include "Require.hpp"

#include <stdexcept>

namespace softgrain {

void Scheme::validate(const TemplateRecipe& recipe) const
{
	require(picShare >= 0 && picShare <= 1, "picShare", picShare, "[0, 1]");
	require(picShare == 0 || hasPointVelocities(), "picShare", picShare,
		"0 where velocities stay at the nodes (velocityUpdate = 'nodal'); a PIC share "
		"needs velocityUpdate = 'flip' or formulation = 'updated'");
	require(formulation == Formulation::total ||
			recipe.volumetric == VolumetricStrain::pointwise,
		"volumetric", "projected",
		"'pointwise' for formulation = 'updated': the space of pressures belongs to the "
		"reference configuration");
	require(formulation == Formulation::total || recipe.order >= 2, "order", recipe.order,
		"2, 3 for formulation = 'updated': the gradients of linear splines jump where a "
		"point crosses a cell");
	if (recipe.basis == Basis::triangles && hasPointVelocities())
		throw std::invalid_argument("basis = 'triangles' needs formulation = 'total' and "
					    "velocityUpdate = 'nodal'");
	if (hasPointVelocities() && recipe.lumping != lumping())
		throw std::invalid_argument("lumping = 'balanced' is inadmissible where velocities "
					    "live at the points; admissible: 'rowSums'");
	if (formulation == Formulation::updated && recipe.contact == ContactGeometry::nodes)
		throw std::invalid_argument(
			"contact = 'nodes' is not implemented for formulation = 'updated'; "
			"admissible: 'surface', 'points'");
}

} // namespace softgrain
