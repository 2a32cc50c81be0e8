// The bulk pass with the same material point of laneWidth congruent grains side by side.
#pragma once

#include "grain/BlockField.hpp"
#include "grain/HourglassForces.hpp"
#include "grain/Strip.hpp"

namespace softgrain {

namespace detail {

/// All lanes, or half of them: what the compiler keeps in one register with AVX-512, or with AVX2,
/// where arrays of wider vectors would stay in memory.
struct WholeBlock {
	using Numbers = Lanes;
	static constexpr int width = laneWidth;
};
struct HalfBlock {
	using Numbers [[gnu::vector_size(laneWidth / 2 * sizeof(double)),
			gnu::aligned(laneWidth / 2 * sizeof(double)), gnu::may_alias]] = double;
	static constexpr int width = laneWidth / 2;
};

/// Some lanes of component `a` at the k-th place after `first`.
template <class Part, int dim> typename Part::Numbers& lanesAt(double* first, int k, int a)
{
	return *reinterpret_cast<typename Part::Numbers*>(first + (k * dim + a) * laneWidth);
}
template <class Part, int dim>
const typename Part::Numbers& lanesAt(const double* first, int k, int a)
{
	return *reinterpret_cast<const typename Part::Numbers*>(first + (k * dim + a) * laneWidth);
}

/// Sums over the nodes across a line in one row: component `a` with the products `q` of
/// PointLines::across.
template <int dim, class Part> struct RowSums {
	typename Part::Numbers at[dim][dim];
};

template <int dim, int order, class Part>
void sumRow(const LinesInLoop<dim, order>& in, const double* across, const double* x,
	    RowSums<dim, Part>& sums)
{
	constexpr int nodes = nodesAcross<dim, order>;
	typename Part::Numbers sum[dim][dim] = {};
	for (int k = 0; k < nodes; ++k)
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				sum[q][a] += across[q * nodes + k] *
					     lanesAt<Part, dim>(x, in.step[k], a);
	for (int q = 0; q < dim; ++q)
		for (int a = 0; a < dim; ++a)
			sums.at[q][a] = sum[q][a];
}

/// The transpose of `sumRow`, subtracted.
template <int dim, int order, class Part>
void spreadRow(const LinesInLoop<dim, order>& in, const double* across,
	       const RowSums<dim, Part>& sums, double* force)
{
	constexpr int nodes = nodesAcross<dim, order>;
	for (int k = 0; k < nodes; ++k)
		for (int a = 0; a < dim; ++a) {
			auto& node = lanesAt<Part, dim>(force, in.step[k], a);
			typename Part::Numbers sum = node;
			for (int q = 0; q < dim; ++q)
				sum -= across[q * nodes + k] * sums.at[q][a];
			node = sum;
		}
}

/// The rows of a line that one point meets.
template <int dim, int order, class Part> struct Window {
	RowSums<dim, Part> row[order + 1];

	void shift()
	{
		for (int j = 0; j < order; ++j)
			for (int q = 0; q < dim; ++q)
				for (int a = 0; a < dim; ++a)
					row[j].at[q][a] = row[j + 1].at[q][a];
	}
};

/// F at the points of a strip in the lanes from `begin` on.
template <int dim, int order, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherGrains(const PointLines<dim>& lines, const double* x,
						     int begin, Strip<dim>& strip)
{
	constexpr int width = order + 1;
	const LinesInLoop<dim, order> in(lines);
	double* tensor = &strip.tensor[0][0][0][begin];
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto line = in.line[n];
		const double* across = in.acrossLine(n);
		const double* first =
			x + static_cast<std::ptrdiff_t>(line.place) * dim * laneWidth + begin;
		Window<dim, order, Part> window;
#pragma GCC unroll 4
		for (int j = 0; j < width; ++j)
			sumRow<dim, order, Part>(in, across, first + j * dim * laneWidth,
						 window.row[j]);
		int next = width; // row after the window
		for (int i = line.begin; i < line.end; ++i, tensor += dim * dim * laneWidth) {
			const auto& along = in.along[i];
			for (; next < in.point[i].row + width; ++next) {
				window.shift();
				sumRow<dim, order, Part>(in, across, first + next * dim * laneWidth,
							 window.row[order]);
			}
			typename Part::Numbers F[dim][dim] = {};
			for (int j = 0; j < width; ++j)
				for (int a = 0; a < dim; ++a) {
					for (int q = 1; q < dim; ++q)
						F[a][q - 1] +=
							along.value[j] * window.row[j].at[q][a];
					F[a][dim - 1] += along.slope[j] * window.row[j].at[0][a];
				}
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					lanesAt<Part, dim>(tensor, a, b) = F[a][b];
		}
	}
}

/// Forces of the stresses of a strip in the lanes from `begin` on.
template <int dim, int order, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
scatterGrains(const PointLines<dim>& lines, const Strip<dim>& strip, int begin, double* force)
{
	constexpr int width = order + 1;
	const LinesInLoop<dim, order> in(lines);
	const double* tensor = &strip.tensor[0][0][0][begin];
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto line = in.line[n];
		const double* across = in.acrossLine(n);
		double* first =
			force + static_cast<std::ptrdiff_t>(line.place) * dim * laneWidth + begin;
		Window<dim, order, Part> window = {};
		int row = 0; // first of the window
		for (int i = line.begin; i < line.end; ++i, tensor += dim * dim * laneWidth) {
			const auto& along = in.along[i];
			for (; row < in.point[i].row; ++row) {
				spreadRow<dim, order, Part>(in, across, window.row[0],
							    first + row * dim * laneWidth);
				window.shift();
				window.row[order] = {};
			}
			for (int j = 0; j < width; ++j)
				for (int a = 0; a < dim; ++a) {
					for (int q = 1; q < dim; ++q)
						window.row[j].at[q][a] +=
							along.value[j] *
							lanesAt<Part, dim>(tensor, a, q - 1);
					window.row[j].at[0][a] +=
						along.slope[j] *
						lanesAt<Part, dim>(tensor, a, dim - 1);
				}
		}
#pragma GCC unroll 4
		for (int j = 0; j < width; ++j)
			spreadRow<dim, order, Part>(in, across, window.row[j],
						    first + (row + j) * dim * laneWidth);
	}
}

/// F at so many points from the first of a strip on, whose stencils are rows of a table.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherTable(const SparseRows<ShapeFunction<dim>>& shapes,
						    const double* x, int begin, int first,
						    int points, Strip<dim>& strip)
{
	for (int i = 0; i < points; ++i) {
		typename Part::Numbers F[dim][dim] = {};
		for (int k = shapes.begin(first + i); k < shapes.end(first + i); ++k)
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					F[a][b] +=
						shapes.value[k].G[b] *
						lanesAt<Part, dim>(x + begin, shapes.column[k], a);
		double* tensor = &strip.tensor[i][0][0][begin];
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				lanesAt<Part, dim>(tensor, a, b) = F[a][b];
	}
}

/// Forces of the stresses at these points.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterTable(const SparseRows<ShapeFunction<dim>>& shapes,
						     const Strip<dim>& strip, int begin, int first,
						     int points, double* force)
{
	for (int i = 0; i < points; ++i) {
		const double* tensor = &strip.tensor[i][0][0][begin];
		for (int k = shapes.begin(first + i); k < shapes.end(first + i); ++k)
			for (int a = 0; a < dim; ++a) {
				auto& node = lanesAt<Part, dim>(force + begin, shapes.column[k], a);
				for (int b = 0; b < dim; ++b)
					node -= shapes.value[k].G[b] *
						lanesAt<Part, dim>(tensor, a, b);
			}
	}
}

/// Calls `use(type of the part, its first lane)` for all parts of a block.
template <class Use> void forEachPart(Use&& use)
{
	if (__builtin_cpu_supports("x86-64-v4"))
		use(WholeBlock {}, 0);
	else
		for (int begin = 0; begin < laneWidth; begin += HalfBlock::width)
			use(HalfBlock {}, begin);
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void followTies(const PointLines<dim>& lines, BlockField<dim>& x)
{
	softgrain::followTies<Lanes>(lines,
				     [&](int place, int a) -> Lanes& { return x.at(place, a); });
}
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void handToFollowed(const PointLines<dim>& lines,
						       BlockField<dim>& force)
{
	softgrain::handToFollowed<Lanes>(
		lines, [&](int place, int a) -> Lanes& { return force.at(place, a); });
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
		detail::followTies(lines_, x_);
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
		const double* x = &x_.at(0, 0)[0];
		detail::forEachPart([&]<class Part>(Part, int begin) {
			if (lines_.isTable())
				detail::gatherTable<dim, Part>(shapes_, x, begin,
							       strip.pointsBegin(lines_),
							       strip.groups, strip);
			else
				withOrder(order_, [&](auto order) {
					detail::gatherGrains<dim, order, Part>(lines_, x, begin,
									       strip);
				});
		});
	}
	/// Vp0 in radii^dim.
	Lanes volume(const Strip<dim>& strip, int group) const
	{
		return Lanes {} + lines_.point[strip.pointsBegin(lines_) + group].volume;
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
		double* force = &forces.at(0, 0)[0];
		detail::forEachPart([&]<class Part>(Part, int begin) {
			if (lines_.isTable())
				detail::scatterTable<dim, Part>(shapes_, strip, begin,
								strip.pointsBegin(lines_),
								strip.groups, force);
			else
				withOrder(order_, [&](auto order) {
					detail::scatterGrains<dim, order, Part>(lines_, strip,
										begin, force);
				});
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
		detail::handToFollowed(lines_, forces);
		forces.store(to, batch, block_, lines_.nodePlace, volume_ * inverseRadius_);
	}

private:
	const PointLines<dim>& lines_;
	const SparseRows<ShapeFunction<dim>>& shapes_;
	const std::vector<HourglassStencil>& hourglass_;
	int order_, block_;
	const LameConstants& lame_;
	Lanes inverseRadius_, volume_; ///< volume_: R^dim
	BlockField<dim> x_;            ///< in the box; the field over the radius
};

} // namespace softgrain
