// The bulk pass with the same material point of laneWidth congruent grains side by side.
#pragma once

#include "grain/BlockField.hpp"
#include "grain/Strip.hpp"

namespace softgrain {

namespace detail {

/// Sums over the nodes across a line in one row: component `a` with the products `q` of
/// PointLines::across.
template <int dim> using RowSums = Lanes[dim][dim];

/// The rows of a line that one point meets.
template <int dim, int order> struct Window {
	RowSums<dim> row[order + 1];

	void shift()
	{
		for (int j = 0; j < order; ++j)
			for (int q = 0; q < dim; ++q)
				for (int a = 0; a < dim; ++a)
					row[j][q][a] = row[j + 1][q][a];
	}
};

template <int dim, int order>
void sumRow(const PointLines<dim>& lines, const double* across, const LaneSlot* x,
	    RowSums<dim>& sums)
{
	constexpr int nodes = nodesAcross<dim, order>;
	RowSums<dim> sum = {};
	for (int k = 0; k < nodes; ++k) {
		const LaneSlot* node = x + stepAcross<dim, order>(lines, k) * dim;
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				sum[q][a] += across[q * nodes + k] * node[a].value;
	}
	for (int q = 0; q < dim; ++q)
		for (int a = 0; a < dim; ++a)
			sums[q][a] = sum[q][a];
}

/// The transpose of `sumRow`.
template <int dim, int order>
void spreadRow(const PointLines<dim>& lines, const double* across, const RowSums<dim>& sums,
	       LaneSlot* force)
{
	constexpr int nodes = nodesAcross<dim, order>;
	for (int k = 0; k < nodes; ++k) {
		LaneSlot* node = force + stepAcross<dim, order>(lines, k) * dim;
		for (int a = 0; a < dim; ++a) {
			Lanes sum = node[a].value;
			for (int q = 0; q < dim; ++q)
				sum -= across[q * nodes + k] * sums[q][a];
			node[a].value = sum;
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherGrains(const PointLines<dim>& lines,
						     const LaneSlot* x, Strip<dim>& strip)
{
	constexpr int width = order + 1;
	int group = 0;
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto& line = lines.line[n];
		const double* across = acrossLine<dim, order>(lines, n);
		const LaneSlot* first = x + static_cast<std::ptrdiff_t>(line.place) * dim;
		Window<dim, order> window;
#pragma GCC unroll 4
		for (int j = 0; j < width; ++j)
			sumRow<dim, order>(lines, across, first + j * dim, window.row[j]);
		int next = width; // row after the window
		for (int i = line.begin; i < line.end; ++i, ++group) {
			const auto& point = lines.point[i];
			for (; next < point.row + width; ++next) {
				window.shift();
				sumRow<dim, order>(lines, across, first + next * dim,
						   window.row[order]);
			}
			Lanes F[dim][dim] = {};
			for (int j = 0; j < width; ++j)
				for (int a = 0; a < dim; ++a) {
					for (int q = 1; q < dim; ++q)
						F[a][q - 1] += point.value[j] * window.row[j][q][a];
					F[a][dim - 1] += point.slope[j] * window.row[j][0][a];
				}
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					strip.tensor[group][a][b] = F[a][b];
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterGrains(const PointLines<dim>& lines,
						      const Strip<dim>& strip, LaneSlot* force)
{
	constexpr int width = order + 1;
	int group = 0;
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto& line = lines.line[n];
		const double* across = acrossLine<dim, order>(lines, n);
		LaneSlot* first = force + static_cast<std::ptrdiff_t>(line.place) * dim;
		Window<dim, order> window = {};
		int begin = 0; // first row of the window
		auto leaveRow = [&] {
			spreadRow<dim, order>(lines, across, window.row[0], first + begin * dim);
			window.shift();
			for (int q = 0; q < dim; ++q)
				for (int a = 0; a < dim; ++a)
					window.row[order][q][a] = Lanes {};
			++begin;
		};
		for (int i = line.begin; i < line.end; ++i, ++group) {
			const auto& point = lines.point[i];
			while (begin < point.row)
				leaveRow();
			for (int j = 0; j < width; ++j)
				for (int a = 0; a < dim; ++a) {
					const Lanes(&P)[dim] = strip.tensor[group][a];
					for (int q = 1; q < dim; ++q)
						window.row[j][q][a] += point.value[j] * P[q - 1];
					window.row[j][0][a] += point.slope[j] * P[dim - 1];
				}
		}
#pragma GCC unroll 4
		for (int j = 0; j < width; ++j)
			spreadRow<dim, order>(lines, across, window.row[j],
					      first + (begin + j) * dim);
	}
}

/// Tied nodes take their positions from those that they follow.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void followTies(const PointLines<dim>& lines, BlockField<dim>& x)
{
	lines.forEachTie([&](int tied, int followed, double weight) {
		for (int a = 0; a < dim; ++a)
			x.at(tied, a) += weight * x.at(followed, a);
	});
}
/// Tied nodes hand their forces to those that they follow.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void handTiedForces(const PointLines<dim>& lines,
						       BlockField<dim>& force)
{
	lines.forEachTie([&](int tied, int followed, double weight) {
		for (int a = 0; a < dim; ++a)
			force.at(followed, a) += weight * force.at(tied, a);
	});
}

} // namespace detail

/// One block of a batch: every lane is a grain; lanes without one repeat the first.
template <int dim> class GrainsInLanes {
public:
	static constexpr int stripPoints = Strip<dim>::maxGroups;
	/// Numbers side by side in a field of one number for each point; see `place`.
	static constexpr int fieldWidth = laneWidth;

	GrainsInLanes(const Batch<dim>& batch, int block)
		: lines_(batch.reference->pointLines)
		, order_(batch.reference->recipe.order)
		, block_(block)
		, lame_(batch.lame[block])
		, x_(lines_.places)
		, force_(lines_.places)
	{
		for (int l = 0; l < laneWidth; ++l) {
			const int g = batch.grainInLane(block, l);
			inverseRadius_[l] = 1 / batch.grain[g].radius;
			volume_[l] = batch.pointScale[g];
		}
		x_.load(batch.x, batch, block, lines_.nodePlace, inverseRadius_);
		detail::followTies(lines_, x_);
	}

	const LameConstants& lame() const { return lame_; }

	/// F at the points of the strip's lines.
	void gather(Strip<dim>& strip) const
	{
		strip.groups = strip.pointsEnd(lines_) - strip.pointsBegin(lines_);
		withOrder(order_, [&](auto order) {
			detail::gatherGrains<dim, order>(lines_, x_.data(), strip);
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
	/// Forces of the stresses of the strip.
	void scatter(const Strip<dim>& strip)
	{
		withOrder(order_, [&](auto order) {
			detail::scatterGrains<dim, order>(lines_, strip, force_.data());
		});
	}
	void finish(const BulkSums& sums, Batch<dim>& batch)
	{
		detail::handTiedForces(lines_, force_);
		force_.store(batch.force, batch, block_, lines_.nodePlace,
			     volume_ * inverseRadius_);
		for (int l = 0; l < laneWidth && batch.hasGrain(block_, l); ++l)
			batch.report[batch.grainInLane(block_, l)] =
				sums.report(l, l + 1, volume_[l]);
	}

private:
	const PointLines<dim>& lines_;
	int order_, block_;
	const LameConstants& lame_;
	Lanes inverseRadius_, volume_; ///< volume_: R^dim
	BlockField<dim> x_, force_;    ///< in the box; x in radii
};

} // namespace softgrain
