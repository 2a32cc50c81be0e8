// Rows of a table over the background nodes, laid out for nodal fields of one grain: sums over the
// nodes of a row, and what is spread over them.
#pragma once

#include "Vector.hpp"
#include "material/Lanes.hpp"
#include "reference/SparseRows.hpp"

#include <type_traits>

namespace softgrain {

/// 2D: nodes of a row of the grid follow one another, so that the nodes of a stencil are some
/// *blocks* of four nodes side by side, each with both components in one Lanes.
class BlockRows {
public:
	BlockRows() = default;
	/// Of a grain of so many nodes, at least four.
	BlockRows(const SparseRows<double>& rows, int nodes);

	int rows() const { return static_cast<int>(begin_.size()) - 1; }
	/// sum_I w_I f_I
	Vec<2> sum(int row, const Vec<2>* field) const;
	/// f_I += w_I J
	void spread(int row, const Vec<2>& J, Vec<2>* field) const;

private:
	static constexpr int nodesPerBlock = laneWidth / 2;
	/// Two blocks, of which the second may be without weights.
	struct Pair {
		Lanes weight;
		int node[2]; ///< first one of each block
	};

	static Lanes weightsOfFirst(const Lanes& weight)
	{
		return __builtin_shuffle(weight, LaneBits { 0, 0, 1, 1, 2, 2, 3, 3 });
	}
	static Lanes weightsOfSecond(const Lanes& weight)
	{
		return __builtin_shuffle(weight, LaneBits { 4, 4, 5, 5, 6, 6, 7, 7 });
	}

	std::vector<int> begin_ { 0 }; ///< of the pairs of each row
	std::vector<Pair> pair_;
};

/// 3D: node by node.
class PlainRows {
public:
	PlainRows() = default;
	PlainRows(SparseRows<double> rows, int /*nodes*/)
		: rows_(std::move(rows))
	{
	}
	int rows() const { return rows_.rows(); }
	Vec<3> sum(int row, const Vec<3>* field) const
	{
		Vec<3> sum = Vec<3>::Zero();
		for (int k = rows_.begin(row); k < rows_.end(row); ++k)
			addScaled<3>(sum, rows_.value[k], field[rows_.column[k]]);
		return sum;
	}
	void spread(int row, const Vec<3>& J, Vec<3>* field) const
	{
		for (int k = rows_.begin(row); k < rows_.end(row); ++k)
			addScaled<3>(field[rows_.column[k]], rows_.value[k], J);
	}

private:
	SparseRows<double> rows_;
};

template <int dim> using NodeRows = std::conditional_t<dim == 2, BlockRows, PlainRows>;

// --- inline, since it is called for every contact node and step ----------------------------------

inline Vec<2> BlockRows::sum(int row, const Vec<2>* field) const
{
	const double* f = field[0].data();
	Lanes sum = {};
	for (int k = begin_[row]; k < begin_[row + 1]; ++k) {
		const Pair& pair = pair_[k];
		sum += weightsOfFirst(pair.weight) * loadLanes(f + 2 * pair.node[0]);
		sum += weightsOfSecond(pair.weight) * loadLanes(f + 2 * pair.node[1]);
	}
	sum += __builtin_shuffle(sum, LaneBits { 4, 5, 6, 7, 0, 1, 2, 3 });
	return { sum[0] + sum[2], sum[1] + sum[3] };
}

inline void BlockRows::spread(int row, const Vec<2>& J, Vec<2>* field) const
{
	const Lanes both = { J[0], J[1], J[0], J[1], J[0], J[1], J[0], J[1] };
	double* f = field[0].data();
	auto add = [&](int node, const Lanes& weight) {
		double* at = f + 2 * node;
		storeLanes(at, loadLanes(at) + weight * both);
	};
	for (int k = begin_[row]; k < begin_[row + 1]; ++k) {
		const Pair& pair = pair_[k];
		add(pair.node[0], weightsOfFirst(pair.weight));
		add(pair.node[1], weightsOfSecond(pair.weight));
	}
}

} // namespace softgrain
