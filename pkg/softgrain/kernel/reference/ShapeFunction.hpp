#pragma once

#include "Vector.hpp"

namespace softgrain {

/// Value and gradient of one shape function at one material point.
template <int dim> struct ShapeFunction {
	double N;   ///< dimensionless
	Vec<dim> G; ///< dN/dX, in 1/radius
};

} // namespace softgrain
