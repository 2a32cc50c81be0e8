// Passes over the material points of a block of grains: what lies side by side, and strip after
// strip. A side gathers the gradients of a nodal field at the points of a strip, and scatters
// stresses to nodal forces, which the caller keeps.
#pragma once

#include "grain/GrainsInLanes.hpp"
#include "grain/PointsInLanes.hpp"
#include "reference/PressureSpace.hpp"

#include <vector>

namespace softgrain {

/// Calls `use(sideOf)` for all grains of a block or, one after the other, for each of them, where
/// `sideOf(field)` is the side of a nodal field of the batch.
template <int dim, class Use> void forEachSide(const Batch<dim>& batch, int block, Use&& use)
{
	const int grains = batch.grainsInBlock(block);
	if (grains >= fullBlock)
		use([&](const NodalField<dim>& field) {
			return GrainsInLanes<dim>(batch, block, field);
		});
	else
		for (int l = 0; l < grains; ++l)
			use([&](const NodalField<dim>& field) {
				return PointsInLanes<dim>(batch, batch.grainInLane(block, l),
							  field);
			});
}

/// Gathers strip after strip and calls `use` after each.
template <int dim, class Side, class Use>
void forEachStrip(const Side& side, const PointLines<dim>& lines, Strip<dim>& strip, Use&& use)
{
	const int count = static_cast<int>(lines.line.size());
	for (int begin = 0; begin < count; begin = strip.lines.end) {
		strip.lines = nextStrip(lines, begin, Side::stripPoints);
		side.gather(strip);
		use();
	}
}

/// A number at every point of what a side has in its lanes, and its projection
/// (reference/PressureSpace.hpp).
class ProjectedField {
public:
	template <class Side, int dim> void resize(const GrainTemplate<dim>& reference)
	{
		numbers_.resize(static_cast<std::size_t>(reference.points()) * Side::fieldWidth);
	}
	/// Of the points of a group of the strip.
	template <class Side, int dim>
	void set(const Side& side, const Strip<dim>& strip, int group, const Lanes& values)
	{
		for (int l = 0; l < laneWidth; ++l)
			numbers_[side.place(strip, group, l)] = values[l];
	}
	template <class Part, class Side, int dim>
	typename Part::Numbers part(const Side& side, const Strip<dim>& strip, int group,
				    int begin) const
	{
		typename Part::Numbers values;
		for (int l = 0; l < Part::width; ++l)
			values[l] = at(side, strip, group, begin + l);
		return values;
	}
	template <class Side, int dim>
	double at(const Side& side, const Strip<dim>& strip, int group, int lane) const
	{
		return numbers_[side.place(strip, group, lane)];
	}
	/// To be called when all points are set.
	template <class Side, int dim> void project(const GrainTemplate<dim>& reference)
	{
		softgrain::project<Side::fieldWidth>(reference.pressureSpace, reference.pointVolume,
						     numbers_.data());
	}

private:
	std::vector<double> numbers_; ///< see `place` of the side
};

} // namespace softgrain
