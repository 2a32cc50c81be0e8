#include "contact/ContactBody.hpp"

#include <algorithm>

namespace softgrain {

template <int dim> void ContactBody<dim>::prepareSolve()
{
	impulse.assign(velocity.size(), Vec<dim>::Zero());
	if (!surfaceMobility) return;
	velocity.resize(velocity.size() + surfaceMobility->padding(), Vec<dim>::Zero());
	if (dim == 3) markedBlocks.assign(segmentsOf(velocity.size()), 0);
}

template <int dim> bool ContactBody<dim>::hasFiniteVelocities() const
{
	return std::all_of(velocity.begin(), velocity.begin() + impulse.size(),
			   [](const Vec<dim>& v) { return v.allFinite(); });
}

template <int dim> double ContactBody<dim>::mobility(int node, int other) const
{
	for (int k = delassus->begin(node); k < delassus->end(node); ++k)
		if (delassus->column[k] == other) return delassusScale * delassus->value[k];
	return 0;
}

template struct ContactBody<2>;
template struct ContactBody<3>;

} // namespace softgrain
