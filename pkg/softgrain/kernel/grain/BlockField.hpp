// Nodal fields of a block of congruent grains, lane by lane: what the loops over material points
// work on.
#pragma once

#include "grain/Batch.hpp"

namespace softgrain {

template <int dim> class BlockField {
public:
	explicit BlockField(int nodes)
		: data_(static_cast<std::size_t>(nodes) * dim)
	{
	}
	/// Component `a` at node `I` of all grains of the block.
	Lanes& at(int I, int a) { return data_[static_cast<std::size_t>(I) * dim + a].value; }
	const Lanes& at(int I, int a) const { return const_cast<BlockField*>(this)->at(I, a); }

	/// Takes the block from a field of the batch. Lanes without a grain repeat the first.
	void load(const NodalField<dim>& field, const Batch<dim>& batch, int block)
	{
		for (int l = 0; l < laneWidth; ++l) {
			const Vec<dim>* own = field.of(batch.grainInLane(block, l));
			for (std::size_t k = 0; k < data_.size(); ++k)
				data_[k].value[l] = own[k / dim][k % dim];
		}
	}
	void store(NodalField<dim>& field, const Batch<dim>& batch, int block) const
	{
		for (int l = 0; l < laneWidth && batch.hasGrain(block, l); ++l) {
			Vec<dim>* own = field.of(batch.grainInLane(block, l));
			for (std::size_t k = 0; k < data_.size(); ++k)
				own[k / dim][k % dim] = data_[k].value[l];
		}
	}

private:
	std::vector<LaneSlot> data_; ///< zero at the start
};

} // namespace softgrain
