// Nodal fields of a block of congruent grains, lane by lane: what the loops over material points
// work on.
#pragma once

#include "grain/Batch.hpp"

#include <numeric>

namespace softgrain {

namespace detail {

/// Elements from `k` on of an array of `count`.
inline Lanes loadPart(const double* from, int k, int count)
{
	if (k + laneWidth <= count) return loadLanes(from + k);
	Lanes part = {};
	for (int i = k; i < count; ++i)
		part[i - k] = from[i];
	return part;
}
inline void storePart(const Lanes& part, double* to, int k, int count)
{
	if (k + laneWidth <= count) {
		storeLanes(to + k, part);
		return;
	}
	for (int i = k; i < count; ++i)
		to[i] = part[i - k];
}

/// `scale` times `count` vectors of each grain; vector I goes to `place[I]`.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void takeSideBySide(const double* const (&grain)[laneWidth],
						       const int* place, int count,
						       const Lanes& scale, LaneSlot* to)
{
	for (int k = 0; k < count * dim; k += laneWidth) {
		Lanes row[laneWidth];
		for (int l = 0; l < laneWidth; ++l)
			row[l] = loadPart(grain[l], k, count * dim);
		transpose(row);
		for (int i = 0; i < laneWidth && k + i < count * dim; ++i)
			to[place[(k + i) / dim] * dim + (k + i) % dim].value = scale * row[i];
	}
}
/// The way back, to the first `grains` lanes.
template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void putAsunder(const LaneSlot* from, const int* place,
						   int count, const Lanes& scale, int grains,
						   double* const (&grain)[laneWidth])
{
	for (int k = 0; k < count * dim; k += laneWidth) {
		Lanes row[laneWidth] = {};
		for (int i = 0; i < laneWidth && k + i < count * dim; ++i)
			row[i] = scale * from[place[(k + i) / dim] * dim + (k + i) % dim].value;
		transpose(row);
		for (int l = 0; l < grains; ++l)
			storePart(row[l], grain[l], k, count * dim);
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
	LaneSlot* data() { return data_.data(); }
	const LaneSlot* data() const { return data_.data(); }

	/// Takes `scale` times a block of a field of the batch; vector I goes to `place[I]`. Lanes
	/// without a grain repeat the first.
	void load(const NodalField<dim>& field, const Batch<dim>& batch, int block,
		  const std::vector<int>& place, const Lanes& scale)
	{
		const double* own[laneWidth];
		for (int l = 0; l < laneWidth; ++l)
			own[l] = field.of(batch.grainInLane(block, l))->data();
		detail::takeSideBySide<dim>(own, place.data(), static_cast<int>(place.size()),
					    scale, data());
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
		detail::putAsunder<dim>(data(), place.data(), static_cast<int>(place.size()), scale,
					grains, own);
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
