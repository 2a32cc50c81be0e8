// How the motion of a grain is computed: the methods that are compared.
#pragma once

#include "reference/GrainTemplate.hpp"

#include <tuple>

namespace softgrain {

enum class Formulation {
	total,  ///< grid and shape functions stay in the reference configuration for ever
	updated ///< grid fixed in space; shape functions of the present positions in every step
};

/// Where the velocities of a total-Lagrangian grain live from step to step.
enum class VelocityUpdate {
	nodal, ///< at the background nodes
	flip   ///< at the material points, mapped to the nodes and back in every step
};

struct Scheme {
	Formulation formulation = Formulation::total;
	VelocityUpdate velocityUpdate = VelocityUpdate::nodal; ///< of Formulation::total
	/// Share of the nodal velocity itself (PIC), not its change (FLIP), that a point takes over
	/// in a step, in [0, 1]; only where velocities live at the points.
	double picShare = 0;

	bool hasPointVelocities() const
	{
		return formulation == Formulation::updated ||
		       velocityUpdate == VelocityUpdate::flip;
	}
	/// Velocities at the points share their momentum out by the shape functions alone.
	Lumping lumping() const
	{
		return hasPointVelocities() ? Lumping::rowSums : Lumping::balanced;
	}
	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate(const TemplateRecipe& recipe) const;
	bool operator<(const Scheme& o) const
	{
		return std::tie(formulation, velocityUpdate, picShare) <
		       std::tie(o.formulation, o.velocityUpdate, o.picShare);
	}
};

} // namespace softgrain
