// Hourglass modes, patterns of background nodes that the points hardly see, and their control.
//
// Where nodes move to and fro in turns, their splines cancel: what moves at the points is a small
// part of that, and so is the energy of deformation, while the mass is that of the nodes. In space,
// where patterns alternate along two or three axes, they are slower than anything else a grain
// does, and centrifugal forces and pressures move them without bound; in the plane pressures do
// where volumes are projected. The second differences of positions across two axes,
// q = ([1, -2, 1] x [1, -2, 1]/16) x over nine nodes, are 1 for such a pattern and vanish for all
// that is at most linear along one of the axes, however the grain lies. Each gets the energy kappa
// mu V q^2/(2 h_a h_b), with V the volume of the node in the middle: the hourglass control of
// finite elements (Flanagan and Belytschko, Int. J. Numer. Meth. Eng. 17, 679-706, 1981) for
// splines (doc/decisions/0030-hourglass.md).
#pragma once

#include "reference/BackgroundGrid.hpp"
#include "reference/PointLines.hpp"

#include <array>
#include <vector>

namespace softgrain {

/// Nine nodes in the box of PointLines, held by the stiffness of their second difference.
struct HourglassStencil {
	int place;              ///< of the node in the middle
	std::array<int, 2> way; ///< to the next node along each of the axes
	double stiffness;       ///< over the shear modulus, radii^(dim - 2)
};

/// kappa; 0 in the plane, where patterns are as fast as the rest. Where the volumetric part of the
/// law sees a projection of ln J (`isProjected`), the shear modulus alone resists them, and in the
/// plane, too, pressures above E would fold the grain.
template <int dim> constexpr double hourglassStiffness(bool isProjected)
{
	if (isProjected) return 2;
	return dim == 3 ? 0.1 : 0;
}

/// Held are stencils with a node lighter than this share of the heaviest one: elsewhere patterns
/// are fast enough.
constexpr double hourglassNodeShare = 0.3;

/// Of splines of second and third order, if kappa is not 0; else there are none.
template <int dim>
std::vector<HourglassStencil> hourglassStencils(const BackgroundGrid<dim>& grid,
						const PointLines<dim>& lines,
						const std::vector<double>& nodeMass, double kappa);

} // namespace softgrain
