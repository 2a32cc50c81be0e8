// Nodal fields of a block of congruent grains, lane by lane: what the loops over material points
// work on.
#pragma once

#include "grain/Batch.hpp"
#include "lanes/Parts.hpp"

#include <algorithm>
#include <numeric>

namespace softgrain {

/// Numbers of a part, the h-th after it, of component `a` at the k-th place of a block's field that
/// begins at `first`.
template <class Part, int dim>
typename Part::Numbers& lanesAt(double* first, int k, int a, int h = 0)
{
	return *reinterpret_cast<typename Part::Numbers*>(first + (k * dim + a) * laneWidth +
							  h * Part::width);
}
template <class Part, int dim>
const typename Part::Numbers& lanesAt(const double* first, int k, int a, int h = 0)
{
	return lanesAt<Part, dim>(const_cast<double*>(first), k, a, h);
}

namespace detail {

/// `scale` times `count` vectors of each grain of a part; vector I goes to `place[I]`. `to` is
/// the part's first number.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void
takeSideBySide(const double* const* grain, const int* place, int count,
	       const typename Part::Numbers& scale, double* to)
{
	for (int k = 0; k < count * dim; k += Part::width) {
		typename Part::Numbers row[Part::width];
		for (int l = 0; l < Part::width; ++l)
			row[l] = numbersFrom<Part>(grain[l], k, count * dim);
		transpose<Part>(row);
		for (int i = 0; i < Part::width && k + i < count * dim; ++i)
			lanesAt<Part, dim>(to, place[(k + i) / dim], (k + i) % dim) =
				scale * row[i];
	}
}
/// The way back, to the first `grains` of them.
template <int dim, class Part>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void putAsunder(const double* from, const int* place, int count,
						   const typename Part::Numbers& scale, int grains,
						   double* const* grain)
{
	for (int k = 0; k < count * dim; k += Part::width) {
		typename Part::Numbers row[Part::width] = {};
		for (int i = 0; i < Part::width && k + i < count * dim; ++i)
			row[i] = scale *
				 lanesAt<Part, dim>(from, place[(k + i) / dim], (k + i) % dim);
		transpose<Part>(row);
		for (int l = 0; l < grains; ++l)
			putNumbers<Part>(row[l], grain[l], k, count * dim);
	}
}

} // namespace detail

template <int dim> class BlockField {
public:
	explicit BlockField(int places)
		: data_(static_cast<std::size_t>(places) * dim)
	{
	}
	/// Component `a` at a place of all grains of the block.
	Lanes& at(int place, int a)
	{
		return data_[static_cast<std::size_t>(place) * dim + a].value;
	}
	const Lanes& at(int place, int a) const
	{
		return const_cast<BlockField*>(this)->at(place, a);
	}
	double* data() { return reinterpret_cast<double*>(data_.data()); }
	const double* data() const { return reinterpret_cast<const double*>(data_.data()); }

	/// Takes `scale` times a block of a field of the batch; vector I goes to `place[I]`. Lanes
	/// without a grain repeat the first.
	void load(const NodalField<dim>& field, const Batch<dim>& batch, int block,
		  const std::vector<int>& place, const Lanes& scale)
	{
		const double* own[laneWidth];
		for (int l = 0; l < laneWidth; ++l)
			own[l] = field.of(batch.grainInLane(block, l))->data();
		forEachPart([&]<class Part>(Part, int begin) {
			detail::takeSideBySide<dim, Part>(
				own + begin, place.data(), static_cast<int>(place.size()),
				partOf<Part>(scale, begin), data() + begin);
		});
	}
	/// All of it, as it is.
	void load(const NodalField<dim>& field, const Batch<dim>& batch, int block)
	{
		load(field, batch, block, inOrder(), Lanes {} + 1);
	}

	/// The way back, of the lanes with a grain.
	void store(NodalField<dim>& field, const Batch<dim>& batch, int block,
		   const std::vector<int>& place, const Lanes& scale) const
	{
		const int grains = batch.grainsInBlock(block);
		double* own[laneWidth] = {};
		for (int l = 0; l < grains; ++l)
			own[l] = field.of(batch.grainInLane(block, l))->data();
		forEachPart([&]<class Part>(Part, int begin) {
			detail::putAsunder<dim, Part>(
				data() + begin, place.data(), static_cast<int>(place.size()),
				partOf<Part>(scale, begin),
				std::clamp(grains - begin, 0, Part::width), own + begin);
		});
	}

	void store(NodalField<dim>& field, const Batch<dim>& batch, int block) const
	{
		store(field, batch, block, inOrder(), Lanes {} + 1);
	}

private:
	std::vector<int> inOrder() const
	{
		std::vector<int> place(data_.size() / dim);
		std::iota(place.begin(), place.end(), 0);
		return place;
	}

	std::vector<LaneSlot> data_; ///< zero at the start
};

} // namespace softgrain
