// Undeformed grains of one batch, to be put into a scene.
#pragma once

#include "step/Scene.hpp"

#include <vector>

namespace softgrain::testing {

/// Grains at the given places, all of one batch: that of the paper, or what `change(grain, its
/// number)` makes of it.
template <int dim, class Change>
Batch<dim> grainsAt(const TemplateRecipe& r, const std::vector<Vec<dim>>& places, Change&& change)
{
	std::vector<GrainParameters<dim>> grains(places.size(), paperGrain<dim>());
	for (std::size_t g = 0; g < places.size(); ++g) {
		grains[g].origin = places[g];
		change(grains[g], g);
	}
	return Batch<dim>(makeGrainTemplate<dim>(r), Law::neoHookean, usualCondition<dim>, grains);
}

/// 10 mm in radius unless told.
template <int dim>
Batch<dim> grainsAt(double zeta, const std::vector<Vec<dim>>& places,
		    const std::vector<double>& radii = {})
{
	return grainsAt<dim>(recipe(zeta), places, [&](GrainParameters<dim>& grain, std::size_t g) {
		if (g < radii.size()) grain.radius = radii[g];
	});
}

template <int dim> void setVelocity(Batch<dim>& batch, int g, const Vec<dim>& v)
{
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.v.set(g, I, v);
}

} // namespace softgrain::testing
