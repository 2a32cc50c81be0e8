// Grains by each of the formulations.
#pragma once

#include "step/Scene.hpp"

#include <memory>
#include <vector>

namespace softgrain::testing {

inline const Scheme nodal {}, flip { Formulation::total, VelocityUpdate::flip, 0 },
	updated { Formulation::updated, VelocityUpdate::nodal, 0 };

template <int dim>
std::unique_ptr<GrainSet<dim>>
grainsOf(const Scheme& scheme, TemplateRecipe r,
	 const std::vector<GrainParameters<dim>>& grains = { paperGrain<dim>() })
{
	r.lumping = scheme.lumping();
	return makeGrainSet<dim>(makeGrainTemplate<dim>(r), Law::neoHookean, usualCondition<dim>,
				 grains, scheme);
}

template <int dim> Mat<dim> spinAbout(double rate)
{
	Mat<dim> spin = Mat<dim>::Zero();
	spin(0, 1) = -rate;
	spin(1, 0) = rate;
	return spin;
}

/// Whatever the formulation keeps, as a field of velocities of the present places.
template <int dim, class Field> void setVelocities(GrainSet<dim>& set, const Field& field)
{
	GrainState s = set.state(0);
	std::vector<Vec<dim>> places;
	const bool atNodes =
		s.F.empty() && s.v.size() == s.x.size(); // else at the points, then contact nodes
	if (atNodes)
		places = set.nodePositions(0);
	else
		for (const auto& point : set.points(0))
			places.push_back(point.position);
	for (std::size_t k = places.size(); k < s.v.size() / dim; ++k)
		places.push_back(Eigen::Map<const Vec<dim>>(&s.x[k * dim]));
	for (std::size_t k = 0; k < places.size(); ++k)
		Eigen::Map<Vec<dim>>(&s.v[k * dim]) = field(places[k]);
	set.setState(0, s);
}

} // namespace softgrain::testing
