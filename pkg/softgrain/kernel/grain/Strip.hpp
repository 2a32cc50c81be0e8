// Some lines of material points on their way through the bulk pass: the deformation gradients of
// all of them are gathered, then the law is evaluated for all, then their stresses are scattered,
// so that no point waits for the logarithm of its own J.
#pragma once

#include "grain/Batch.hpp"

#include <algorithm>
#include <type_traits>

namespace softgrain {

/// What a lane of a group is, is up to GrainsInLanes and PointsInLanes.
template <int dim> struct Strip {
	static constexpr int maxGroups = 2 * PointLines<dim>::maxPoints;

	LineRange lines;
	int groups;
	Lanes tensor[maxGroups][dim][dim]; ///< F, then Vp0 P

	int pointsBegin(const PointLines<dim>& all) const { return all.line[lines.begin].begin; }
	int pointsEnd(const PointLines<dim>& all) const { return all.line[lines.end - 1].end; }
};

/// What the pass finds in the points of each lane.
struct BulkSums {
	Lanes energy = {};     ///< sum of Vp0 W, Vp0 in radii^dim, and of patterns (Hourglass.hpp)
	Lanes stiffening = {}; ///< greatest

	/// Of the lanes from `begin` to `end`, which are points of one grain. Inverted points are
	/// not looked for.
	BulkReport report(int begin, int end, double pointScale) const
	{
		BulkReport all { 0, 0, -1 };
		for (int l = begin; l < end; ++l) {
			all.elasticEnergy += pointScale * energy[l];
			all.stiffening = std::max(all.stiffening, stiffening[l]);
		}
		return all;
	}
};

/// Steps in the box from the first node of a row to the others across a line.
template <int dim, int order> constexpr int nodesAcross = (order + 1) * nodesAcross<dim - 1, order>;
template <int order> constexpr int nodesAcross<1, order> = 1;

template <int dim, int order> int stepAcross(const PointLines<dim>& lines, int k)
{
	if constexpr (dim == 2)
		return k * lines.stride[0];
	else
		return k / (order + 1) * lines.stride[0] + k % (order + 1) * lines.stride[1];
}

/// What loops over points need of PointLines, in variables of their own: no store to an array can
/// change these, so they stay in registers.
template <int dim, int order> struct LinesInLoop {
	const typename PointLines<dim>::Line* line;
	const typename PointLines<dim>::Run* run;
	const typename PointLines<dim>::Point* point;
	const typename PointLines<dim>::Factors* along;
	const double* across;
	int step[nodesAcross<dim, order>]; ///< in the box to the k-th node across

	explicit LinesInLoop(const PointLines<dim>& lines)
		: line(lines.line.data())
		, run(lines.run.data())
		, point(lines.point.data())
		, along(lines.along.data())
		, across(lines.across.data())
	{
		for (int k = 0; k < nodesAcross<dim, order>; ++k)
			step[k] = stepAcross<dim, order>(lines, k);
	}
	/// The products across line n.
	const double* acrossLine(int n) const
	{
		return across + static_cast<std::ptrdiff_t>(n) * dim * nodesAcross<dim, order>;
	}
};

/// Tied nodes take what they carry (`at(place, component)`) from those that they follow. Sums are
/// in variables of their own, not in the field.
template <class Number, int dim, class At> void followTies(const PointLines<dim>& lines, At&& at)
{
	lines.forEachTied([&](int tied, auto&& forEachFollowed) {
		Number sum[dim] = {};
		forEachFollowed([&](int followed, double weight) {
			for (int a = 0; a < dim; ++a)
				sum[a] += weight * at(followed, a);
		});
		for (int a = 0; a < dim; ++a)
			at(tied, a) = sum[a];
	});
}
/// The transpose: they hand what they bear to those that they follow.
template <class Number, int dim, class At>
void handToFollowed(const PointLines<dim>& lines, At&& at)
{
	lines.forEachTied([&](int tied, auto&& forEachFollowed) {
		Number own[dim];
		for (int a = 0; a < dim; ++a)
			own[a] = at(tied, a);
		forEachFollowed([&](int followed, double weight) {
			for (int a = 0; a < dim; ++a)
				at(followed, a) += weight * own[a];
		});
	});
}

} // namespace softgrain
