// The bulk pass with laneWidth material points of one grain side by side, for grains with few or no
// congruent ones. The law sees points in its lanes; sums over nodes take rowWidth nodes of a row at
// once, which lie side by side in the box.
#pragma once

#include "grain/Batch.hpp"
#include "grain/HourglassForces.hpp"
#include "grain/Strip.hpp"
#include "lanes/FourNumbers.hpp"

namespace softgrain {

namespace detail {

/// One number at rowWidth neighbours in a row of nodes.
using Row = FourNumbers;
static_assert(rowWidth * sizeof(double) == sizeof(Row));

/// The sum of the elements of each of four.
inline Row sums(const Row& x, const Row& y, const Row& z, const Row& w)
{
	auto halves = [](const Row& u, const Row& v) -> Row {
		return __builtin_shuffle(u, v, FourPlaces { 0, 4, 2, 6 }) +
		       __builtin_shuffle(u, v, FourPlaces { 1, 5, 3, 7 });
	};
	const Row xy = halves(x, y), zw = halves(z, w);
	return __builtin_shuffle(xy, zw, FourPlaces { 0, 1, 4, 5 }) +
	       __builtin_shuffle(xy, zw, FourPlaces { 2, 3, 6, 7 });
}

/// PointLines::along as polynomials.
template <int order> class SplinesAlong {
public:
	explicit SplinesAlong(double spacing)
	{
		for (int k = 0; k <= order; ++k)
			value_[k] = fourAt(splineCoefficients<order>[k].data());
		for (int k = 0; k < order; ++k)
			slope_[k] = (k + 1) / spacing * value_[k + 1];
	}
	Row value(double t) const { return polynomial(value_, t); }
	Row slope(double t) const { return polynomial(slope_, t); }

private:
	template <std::size_t terms>
	static Row polynomial(const Row (&coefficient)[terms], double t)
	{
		Row sum = coefficient[terms - 1];
		for (int k = static_cast<int>(terms) - 2; k >= 0; --k)
			sum = sum * t + coefficient[k];
		return sum;
	}

	Row value_[order + 1], slope_[order];
};

/// Sums over the nodes across a line: component `a` with the products `q` of PointLines::across.
template <int dim> using AcrossSums = Row[dim][dim];

/// Place of the first component of a point's tensor in a strip; the others follow laneWidth numbers
/// apart.
template <int dim> const double* firstNumber(const Strip<dim>& strip, unsigned point)
{
	return &strip.tensor[point / laneWidth][0][0][point % laneWidth];
}
template <int dim> double* firstNumber(Strip<dim>& strip, unsigned point)
{
	return &strip.tensor[point / laneWidth][0][0][point % laneWidth];
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void gatherPoints(const PointLines<dim>& lines,
						     const std::array<const double*, dim> x,
						     Strip<dim>& strip)
{
	constexpr int nodes = nodesAcross<dim, order>;
	const LinesInLoop<dim, order> in(lines);
	const SplinesAlong<order> along(lines.spacing);
	const int stripBegin = strip.pointsBegin(lines), end = runsBegin(lines, strip.lines.end);
	for (int r = runsBegin(lines, strip.lines.begin); r < end; ++r) {
		const auto run = in.run[r];
		const double* across = in.acrossLine(run.line);
		AcrossSums<dim> sum = {};
		for (int k = 0; k < nodes; ++k)
			for (int a = 0; a < dim; ++a) {
				const Row value = fourAt(x[a] + run.place + in.step[k]);
				for (int q = 0; q < dim; ++q)
					sum[q][a] += across[q * nodes + k] * value;
			}
		for (int i = run.begin; i < run.end; ++i) {
			const Row value = along.value(in.point[i].t),
				  slope = along.slope(in.point[i].t);
			Row part[dim * dim + 3] = {}; // of F, component by component
			for (int a = 0; a < dim; ++a) {
				for (int q = 1; q < dim; ++q)
					part[a * dim + q - 1] = value * sum[q][a];
				part[a * dim + dim - 1] = slope * sum[0][a];
			}
			double* F = firstNumber(strip, i - stripBegin);
			for (int k = 0; k < dim * dim; k += rowWidth) {
				const Row whole =
					sums(part[k], part[k + 1], part[k + 2], part[k + 3]);
				for (int c = 0; c < rowWidth && k + c < dim * dim; ++c)
					F[(k + c) * laneWidth] = whole[c];
			}
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void scatterPoints(const PointLines<dim>& lines,
						      const Strip<dim>& strip,
						      const std::array<double*, dim> force)
{
	constexpr int nodes = nodesAcross<dim, order>;
	const LinesInLoop<dim, order> in(lines);
	const SplinesAlong<order> along(lines.spacing);
	const int stripBegin = strip.pointsBegin(lines), end = runsBegin(lines, strip.lines.end);
	for (int r = runsBegin(lines, strip.lines.begin); r < end; ++r) {
		const auto run = in.run[r];
		const double* across = in.acrossLine(run.line);
		AcrossSums<dim> sum = {};
		for (int i = run.begin; i < run.end; ++i) {
			const Row value = along.value(in.point[i].t),
				  slope = along.slope(in.point[i].t);
			const double* P = firstNumber(strip, i - stripBegin);
			for (int a = 0; a < dim; ++a) {
				for (int q = 1; q < dim; ++q)
					sum[q][a] += P[(a * dim + q - 1) * laneWidth] * value;
				sum[0][a] += P[(a * dim + dim - 1) * laneWidth] * slope;
			}
		}
		for (int k = 0; k < nodes; ++k)
			for (int a = 0; a < dim; ++a) {
				double* node = force[a] + run.place + in.step[k];
				Row value = fourAt(node);
				for (int q = 0; q < dim; ++q)
					value -= across[q * nodes + k] * sum[q][a];
				fourAt(node) = value;
			}
	}
}

/// The same for points whose stencils are rows of a table.
template <int dim>
void gatherPoints(const SparseRows<ShapeFunction<dim>>& shapes,
		  const std::array<const double*, dim>& x, int first, int points, Strip<dim>& strip)
{
	for (int i = 0; i < points; ++i) {
		double* F = firstNumber(strip, i);
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b) {
				double sum = 0;
				for (int k = shapes.begin(first + i); k < shapes.end(first + i);
				     ++k)
					sum += shapes.value[k].G[b] * x[a][shapes.column[k]];
				F[(a * dim + b) * laneWidth] = sum;
			}
	}
}

template <int dim>
void scatterPoints(const SparseRows<ShapeFunction<dim>>& shapes, const Strip<dim>& strip, int first,
		   int points, const std::array<double*, dim>& force)
{
	for (int i = 0; i < points; ++i) {
		const double* P = firstNumber(strip, i);
		for (int k = shapes.begin(first + i); k < shapes.end(first + i); ++k)
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					force[a][shapes.column[k]] -=
						P[(a * dim + b) * laneWidth] * shapes.value[k].G[b];
	}
}

} // namespace detail

/// A nodal field of one grain of a batch; lanes of the last group of a strip that have no point
/// repeat the last one, without volume.
template <int dim> class PointsInLanes {
public:
	static constexpr int stripPoints = 64;
	static constexpr int fieldWidth = 1;
	/// In the box, component after component; in units of the stress times radii^(dim - 1).
	using Forces = std::vector<double>;

	PointsInLanes(const Batch<dim>& batch, int g, const NodalField<dim>& field)
		: lines_(batch.reference->pointLines)
		, shapes_(batch.reference->pointShapes)
		, hourglass_(batch.reference->hourglass)
		, order_(batch.reference->recipe.order)
		, grain_(g)
	{
		lame_ = LameConstants::ofAll(batch.grain[g].constants, batch.isochoricShare[g]);
		x_.resize(padded() * dim);
		const double inverseRadius = 1 / batch.grain[g].radius;
		const Vec<dim>* own = field.of(g);
		const auto x = components<double>(x_);
		for (int I = 0; I < lines_.nodes(); ++I)
			for (int a = 0; a < dim; ++a)
				x[a][lines_.nodePlace[I]] = inverseRadius * own[I][a];
		followTies<double>(lines_,
				   [&](int place, int a) -> double& { return x[a][place]; });
	}

	const LameConstants& lame() const { return lame_; }
	template <class Use> void forEachGrain(const Batch<dim>&, Use&& use) const
	{
		use(grain_, 0, laneWidth);
	}

	int points(const Strip<dim>& strip) const
	{
		return strip.pointsEnd(lines_) - strip.pointsBegin(lines_);
	}
	void gather(Strip<dim>& strip) const
	{
		const int count = points(strip);
		strip.groups = (count + laneWidth - 1) / laneWidth;
		const auto x = components<const double>(x_);
		if (lines_.isTable())
			detail::gatherPoints<dim>(shapes_, x, strip.pointsBegin(lines_), count,
						  strip);
		else
			withOrder(order_, [&](auto order) {
				detail::gatherPoints<dim, order>(lines_, x, strip);
			});
		Lanes(&last)[dim][dim] = strip.tensor[strip.groups - 1];
		for (int lane = (count - 1) % laneWidth + 1; lane < laneWidth; ++lane)
			for (int a = 0; a < dim; ++a)
				for (int b = 0; b < dim; ++b)
					last[a][b][lane] = last[a][b][lane - 1];
	}
	/// Of the lanes from `begin` on.
	template <class Part>
	typename Part::Numbers volume(const Strip<dim>& strip, int group, int begin) const
	{
		const int first = strip.pointsBegin(lines_) + group * laneWidth + begin;
		typename Part::Numbers volume = {};
		for (int l = 0; l < std::min(Part::width, strip.pointsEnd(lines_) - first); ++l)
			volume[l] = lines_.point[first + l].volume;
		return volume;
	}
	int place(const Strip<dim>& strip, int group, int lane) const
	{
		const int point = strip.pointsBegin(lines_) + group * laneWidth + lane;
		return lines_.point[std::min(point, strip.pointsEnd(lines_) - 1)].number;
	}
	Forces noForces() const { return Forces(padded() * dim, 0.); }
	void scatter(const Strip<dim>& strip, Forces& forces) const
	{
		const auto force = components<double>(forces);
		if (lines_.isTable())
			detail::scatterPoints<dim>(shapes_, strip, strip.pointsBegin(lines_),
						   points(strip), force);
		else
			withOrder(order_, [&](auto order) {
				detail::scatterPoints<dim, order>(lines_, strip, force);
			});
	}
	/// (The energy is in the first lane.)
	void holdHourglasses(Forces& forces, Lanes& energy) const
	{
		const auto x = components<const double>(x_);
		const auto force = components<double>(forces);
		double sum = 0;
		addHourglassForces<double, dim>(
			hourglass_, lame_.mu[0], [&](int place, int a) { return x[a][place]; },
			[&](int place, int a) -> double& { return force[a][place]; }, sum);
		energy[0] += sum;
	}
	void storeForces(Forces& forces, const Batch<dim>& batch, NodalField<dim>& to) const
	{
		const auto force = components<double>(forces);
		handToFollowed<double>(
			lines_, [&](int place, int a) -> double& { return force[a][place]; });
		const double scale = batch.pointScale[grain_] / batch.grain[grain_].radius;
		Vec<dim>* own = to.of(grain_);
		for (int I = 0; I < lines_.nodes(); ++I)
			for (int a = 0; a < dim; ++a)
				own[I][a] = scale * force[a][lines_.nodePlace[I]];
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
	const SparseRows<ShapeFunction<dim>>& shapes_;
	const std::vector<HourglassStencil>& hourglass_;
	int order_, grain_;
	LameConstants lame_;
	std::vector<double>
		x_; ///< in the box, component after component; the field over the radius
};

} // namespace softgrain
