// The bulk pass with the same material point of laneWidth congruent grains side by side.
#pragma once

#include "grain/BlockField.hpp"
#include "grain/GrainLines.hpp"
#include "grain/HourglassForces.hpp"
#include "grain/Strip.hpp"

namespace softgrain {

namespace detail {

/// F at so many points from the first of a strip on, whose stencils are rows of a table.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherTable(const SparseRows<ShapeFunction<dim>>& shapes,
						    const double* x, int first, int points,
						    double* tensor)
{
	for (int i = 0; i < points; ++i, tensor += tensorStep<dim>) {
		typename Part::Numbers F[dim][dim] = {};
		for (int k = shapes.begin(first + i); k < shapes.end(first + i); ++k)
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					F[a][b] += shapes.value[k].G[b] *
						   lanesAt<Part, dim>(x, shapes.column[k], a);
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				lanesAt<Part, dim>(tensor, a, b) = F[a][b];
	}
}

/// Forces of the stresses at these points.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterTable(const SparseRows<ShapeFunction<dim>>& shapes,
						     const double* tensor, int first, int points,
						     double* force)
{
	for (int i = 0; i < points; ++i, tensor += tensorStep<dim>)
		for (int k = shapes.begin(first + i); k < shapes.end(first + i); ++k)
			for (int a = 0; a < dim; ++a) {
				auto& node = lanesAt<Part, dim>(force, shapes.column[k], a);
				for (int b = 0; b < dim; ++b)
					node -= shapes.value[k].G[b] *
						lanesAt<Part, dim>(tensor, a, b);
			}
}

template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void followTies(const PointLines<dim>& lines, double* x)
{
	softgrain::followTies<typename Part::Numbers>(
		lines, [&](int place, int a) -> auto& { return lanesAt<Part, dim>(x, place, a); });
}
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void handToFollowed(const PointLines<dim>& lines, double* force)
{
	softgrain::handToFollowed<typename Part::Numbers>(lines, [&](int place, int a) -> auto& {
		return lanesAt<Part, dim>(force, place, a);
	});
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
holdHourglasses(const std::vector<HourglassStencil>& stencils, const Lanes& mu,
		const BlockField<dim>& x, BlockField<dim>& forces, Lanes& energy)
{
	addHourglassForces<Lanes, dim>(
		stencils, mu, [&](int place, int a) -> const Lanes& { return x.at(place, a); },
		[&](int place, int a) -> Lanes& { return forces.at(place, a); }, energy);
}

} // namespace detail

/// A nodal field of one block of a batch: every lane is a grain; lanes without one repeat the
/// first.
template <int dim> class GrainsInLanes {
public:
	static constexpr int stripPoints = Strip<dim>::maxGroups;
	/// Numbers side by side in a field of one number for each point; see `place`.
	static constexpr int fieldWidth = laneWidth;
	/// In the box; in units of the stress times radii^(dim - 1).
	using Forces = BlockField<dim>;

	GrainsInLanes(const Batch<dim>& batch, int block, const NodalField<dim>& field)
		: lines_(batch.reference->pointLines)
		, shapes_(batch.reference->pointShapes)
		, hourglass_(batch.reference->hourglass)
		, order_(batch.reference->recipe.order)
		, block_(block)
		, lame_(batch.lame[block])
		, x_(lines_.places)
	{
		for (int l = 0; l < laneWidth; ++l) {
			const int g = batch.grainInLane(block, l);
			inverseRadius_[l] = 1 / batch.grain[g].radius;
			volume_[l] = batch.pointScale[g];
		}
		x_.load(field, batch, block, lines_.nodePlace, inverseRadius_);
		forEachPart([&]<class Part>(Part, int begin) {
			detail::followTies<dim, Part>(lines_, x_.data() + begin);
		});
	}

	const LameConstants& lame() const { return lame_; }
	/// Calls `use(grain, its first lane, the lane after its last)` for all grains.
	template <class Use> void forEachGrain(const Batch<dim>& batch, Use&& use) const
	{
		for (int l = 0; l < laneWidth && batch.hasGrain(block_, l); ++l)
			use(batch.grainInLane(block_, l), l, l + 1);
	}

	/// Gradients, of positions F, at the points of the strip's lines.
	void gather(Strip<dim>& strip) const
	{
		strip.groups = strip.pointsEnd(lines_) - strip.pointsBegin(lines_);
		double* tensor = firstTensor(strip);
		if (lines_.isTable())
			forEachPart([&]<class Part>(Part, int begin) {
				detail::gatherTable<dim, Part>(shapes_, x_.data() + begin,
							       strip.pointsBegin(lines_),
							       strip.groups, tensor + begin);
			});
		else
			forLines([&]<class Part>(auto order, Part, int begin) {
				detail::gatherGrains<dim, order, Part>(
					lines_, strip.lines, x_.data() + begin, tensor + begin);
			});
	}
	/// Vp0 in radii^dim.
	template <class Part>
	typename Part::Numbers volume(const Strip<dim>& strip, int group, int) const
	{
		return typename Part::Numbers {} +
		       lines_.point[strip.pointsBegin(lines_) + group].volume;
	}
	/// Of a lane's number in a field over the points.
	int place(const Strip<dim>& strip, int group, int lane) const
	{
		return lines_.point[strip.pointsBegin(lines_) + group].number * laneWidth + lane;
	}
	Forces noForces() const { return Forces(lines_.places); }
	/// Adds the forces of the stresses of the strip.
	void scatter(const Strip<dim>& strip, Forces& forces) const
	{
		const double* tensor = firstTensor(strip);
		if (lines_.isTable())
			forEachPart([&]<class Part>(Part, int begin) {
				detail::scatterTable<dim, Part>(
					shapes_, tensor + begin, strip.pointsBegin(lines_),
					strip.groups, forces.data() + begin);
			});
		else
			forLines([&]<class Part>(auto order, Part, int begin) {
				detail::scatterGrains<dim, order, Part>(
					lines_, strip.lines, tensor + begin, forces.data() + begin);
			});
	}
	/// Adds the forces that hold patterns of nodes, and their energy over radii^dim.
	void holdHourglasses(Forces& forces, Lanes& energy) const
	{
		detail::holdHourglasses<dim>(hourglass_, lame_.mu, x_, forces, energy);
	}
	/// The sum of all that was added.
	void storeForces(Forces& forces, const Batch<dim>& batch, NodalField<dim>& to) const
	{
		forEachPart([&]<class Part>(Part, int begin) {
			detail::handToFollowed<dim, Part>(lines_, forces.data() + begin);
		});
		forces.store(to, batch, block_, lines_.nodePlace, volume_ * inverseRadius_);
	}

private:
	static double* firstTensor(Strip<dim>& strip) { return &strip.tensor[0][0][0][0]; }
	static const double* firstTensor(const Strip<dim>& strip)
	{
		return &strip.tensor[0][0][0][0];
	}
	/// Calls `use(order, kind of the parts, first lane)` for all parts that are worked on at
	/// once.
	template <class Use> void forLines(Use&& use) const
	{
		withOrder(order_, [&](auto order) {
			withParts([&]<class Part>(Part part) {
				constexpr int step = Part::width * detail::partsAtOnce<Part, dim>;
				for (int begin = 0; begin < laneWidth; begin += step)
					use(order, part, begin);
			});
		});
	}

	const PointLines<dim>& lines_;
	const SparseRows<ShapeFunction<dim>>& shapes_;
	const std::vector<HourglassStencil>& hourglass_;
	int order_, block_;
	const LameConstants& lame_;
	Lanes inverseRadius_, volume_; ///< volume_: R^dim
	BlockField<dim> x_;            ///< in the box; the field over the radius
};

} // namespace softgrain
