// Undeformed grains of one batch, to be put into a scene.
#pragma once

#include "step/Scene.hpp"

#include <vector>

namespace softgrain::testing {

/// Grains at the given places, 10 mm in radius unless told, all of one batch.
template <int dim>
Batch<dim> grainsAt(double zeta, const std::vector<Vec<dim>>& places,
		    const std::vector<double>& radii = {})
{
	std::vector<GrainParameters<dim>> grains;
	for (std::size_t g = 0; g < places.size(); ++g) {
		grains.push_back(paperGrain<dim>());
		grains.back().origin = places[g];
		if (g < radii.size()) grains.back().radius = radii[g];
	}
	return Batch<dim>(makeGrainTemplate<dim>(recipe(zeta)), Law::neoHookean,
			  usualCondition<dim>, grains);
}

template <int dim> void setVelocity(Batch<dim>& batch, int g, const Vec<dim>& v)
{
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.v.set(g, I, v);
}

} // namespace softgrain::testing
