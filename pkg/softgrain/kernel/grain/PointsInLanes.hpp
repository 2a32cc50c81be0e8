// The bulk pass with laneWidth material points of one grain side by side, for grains with few or no
// congruent ones. The law sees points in its lanes; sums over nodes take rowWidth nodes of a row at
// once, which lie side by side in the box.
#pragma once

#include "grain/Batch.hpp"
#include "grain/Strip.hpp"

namespace softgrain {

namespace detail {

/// One number at rowWidth neighbours in a row of nodes.
using Row [[gnu::vector_size(rowWidth * sizeof(double)), gnu::aligned(alignof(double)),
	    gnu::may_alias]] = double;

inline const Row& rowAt(const double* first) { return *reinterpret_cast<const Row*>(first); }
inline Row& rowAt(double* first) { return *reinterpret_cast<Row*>(first); }

/// Sums over the nodes across a line, at its rows side by side; with the products `q` of
/// PointLines::across, of component `a`. Blocks of rowWidth rows are taken whole, and so is the
/// stencil of a point of lower order.
template <int dim> struct LineSums {
	double at[dim][dim][PointLines<dim>::maxRows + rowWidth];
};

template <int dim, int order>
void sumLine(const PointLines<dim>& lines, const typename PointLines<dim>::Line& line,
	     const double* across, const std::array<const double*, dim>& x, LineSums<dim>& sums)
{
	constexpr int nodes = nodesAcross<dim, order>;
	for (int row = 0; row < line.rows; row += rowWidth) {
		Row sum[dim][dim] = {};
		for (int k = 0; k < nodes; ++k) {
			const int node = line.place + stepAcross<dim, order>(lines, k) + row;
			for (int a = 0; a < dim; ++a) {
				const Row value = rowAt(x[a] + node);
				for (int q = 0; q < dim; ++q)
					sum[q][a] += across[q * nodes + k] * value;
			}
		}
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				rowAt(&sums.at[q][a][row]) = sum[q][a];
	}
}

/// The transpose of `sumLine`, subtracted.
template <int dim, int order>
void spreadLine(const PointLines<dim>& lines, const typename PointLines<dim>::Line& line,
		const double* across, const LineSums<dim>& sums,
		const std::array<double*, dim>& force)
{
	constexpr int nodes = nodesAcross<dim, order>;
	for (int row = 0; row < line.rows; row += rowWidth) {
		Row sum[dim][dim];
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				sum[q][a] = rowAt(&sums.at[q][a][row]);
		for (int k = 0; k < nodes; ++k) {
			const int node = line.place + stepAcross<dim, order>(lines, k) + row;
			for (int a = 0; a < dim; ++a) {
				Row value = rowAt(force[a] + node);
				for (int q = 0; q < dim; ++q)
					value -= across[q * nodes + k] * sum[q][a];
				rowAt(force[a] + node) = value;
			}
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherPoints(const PointLines<dim>& lines,
						     const std::array<const double*, dim>& x,
						     Strip<dim>& strip)
{
	LineSums<dim> sums;
	const int begin = strip.pointsBegin(lines);
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto& line = lines.line[n];
		sumLine<dim, order>(lines, line, lines.acrossOf(n), x, sums);
		for (int i = line.begin; i < line.end; ++i) {
			const auto& point = lines.point[i];
			const Row value = rowAt(point.value), slope = rowAt(point.slope);
			Lanes(&F)[dim][dim] = strip.tensor[(i - begin) / laneWidth];
			const int lane = (i - begin) % laneWidth;
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b) {
					const int q = (b + 1) % dim;
					const Row part = (q == 0 ? slope : value) *
							 rowAt(&sums.at[q][a][point.row]);
					F[a][b][lane] = (part[0] + part[2]) + (part[1] + part[3]);
				}
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterPoints(const PointLines<dim>& lines,
						      const Strip<dim>& strip,
						      const std::array<double*, dim>& force)
{
	LineSums<dim> sums;
	const int begin = strip.pointsBegin(lines);
	for (int n = strip.lines.begin; n < strip.lines.end; ++n) {
		const auto& line = lines.line[n];
		for (int q = 0; q < dim; ++q)
			for (int a = 0; a < dim; ++a)
				for (int row = 0; row < line.rows + rowWidth; row += rowWidth)
					rowAt(&sums.at[q][a][row]) = Row {};
		for (int i = line.begin; i < line.end; ++i) {
			const auto& point = lines.point[i];
			const Row value = rowAt(point.value), slope = rowAt(point.slope);
			const Lanes(&P)[dim][dim] = strip.tensor[(i - begin) / laneWidth];
			const int lane = (i - begin) % laneWidth;
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b) {
					const int q = (b + 1) % dim;
					rowAt(&sums.at[q][a][point.row]) +=
						P[a][b][lane] * (q == 0 ? slope : value);
				}
		}
		spreadLine<dim, order>(lines, line, lines.acrossOf(n), sums, force);
	}
}

} // namespace detail

/// One grain of a batch; lanes of the last group of a strip that have no point repeat the last one,
/// without volume.
template <int dim> class PointsInLanes {
public:
	static constexpr int stripPoints = 64;
	static constexpr int fieldWidth = 1;

	PointsInLanes(const Batch<dim>& batch, int g)
		: lines_(batch.reference->pointLines)
		, order_(batch.reference->recipe.order)
		, grain_(g)
	{
		const ElasticConstants& c = batch.grain[g].constants;
		lame_ = { Lanes {} + c.lambda(), Lanes {} + c.mu() };
		x_.resize(padded() * dim);
		force_.resize(padded() * dim);
		const double inverseRadius = 1 / batch.grain[g].radius;
		const Vec<dim>* own = batch.x.of(g);
		const auto x = components<double>(x_);
		for (int I = 0; I < lines_.nodes(); ++I)
			for (int a = 0; a < dim; ++a)
				x[a][lines_.nodePlace[I]] = inverseRadius * own[I][a];
		lines_.forEachTie([&](int tied, int followed, double weight) {
			for (int a = 0; a < dim; ++a)
				x[a][tied] += weight * x[a][followed];
		});
	}

	const LameConstants& lame() const { return lame_; }

	void gather(Strip<dim>& strip) const
	{
		const int points = strip.pointsEnd(lines_) - strip.pointsBegin(lines_);
		strip.groups = (points + laneWidth - 1) / laneWidth;
		withOrder(order_, [&](auto order) {
			detail::gatherPoints<dim, order>(lines_, components<const double>(x_),
							 strip);
		});
		Lanes(&last)[dim][dim] = strip.tensor[strip.groups - 1];
		for (int lane = (points - 1) % laneWidth + 1; lane < laneWidth; ++lane)
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					last[a][b][lane] = last[a][b][lane - 1];
	}
	Lanes volume(const Strip<dim>& strip, int group) const
	{
		const int begin = strip.pointsBegin(lines_) + group * laneWidth;
		Lanes volume = {};
		for (int l = 0; l < std::min(laneWidth, strip.pointsEnd(lines_) - begin); ++l)
			volume[l] = lines_.point[begin + l].volume;
		return volume;
	}
	int place(const Strip<dim>& strip, int group, int lane) const
	{
		const int point = strip.pointsBegin(lines_) + group * laneWidth + lane;
		return lines_.point[std::min(point, strip.pointsEnd(lines_) - 1)].number;
	}
	void scatter(const Strip<dim>& strip)
	{
		withOrder(order_, [&](auto order) {
			detail::scatterPoints<dim, order>(lines_, strip,
							  components<double>(force_));
		});
	}
	void finish(const BulkSums& sums, Batch<dim>& batch)
	{
		const auto force = components<double>(force_);
		lines_.forEachTie([&](int tied, int followed, double weight) {
			for (int a = 0; a < dim; ++a)
				force[a][followed] += weight * force[a][tied];
		});
		const double scale = batch.pointScale[grain_] / batch.grain[grain_].radius;
		Vec<dim>* own = batch.force.of(grain_);
		for (int I = 0; I < lines_.nodes(); ++I)
			for (int a = 0; a < dim; ++a)
				own[I][a] = scale * force[a][lines_.nodePlace[I]];
		batch.report[grain_] = sums.report(0, laneWidth, batch.pointScale[grain_]);
	}

private:
	/// Whole rows are read and written past the end of the box.
	std::size_t padded() const { return static_cast<std::size_t>(lines_.places) + rowWidth; }
	template <class Number, class Field> std::array<Number*, dim> components(Field& field) const
	{
		std::array<Number*, dim> component;
		for (int a = 0; a < dim; ++a)
			component[a] = field.data() + a * padded();
		return component;
	}

	const PointLines<dim>& lines_;
	int order_, grain_;
	LameConstants lame_;
	std::vector<double> x_, force_; ///< in the box, component after component; x in radii
};

} // namespace softgrain
