#include "Vectors.hpp"
#include "lanes/Lanes.hpp"
#include "lanes/NodeBlocks.hpp"

namespace softgrain {

namespace {

FourNumbers smaller(const FourNumbers& a, const FourNumbers& b) { return b < a ? b : a; }
FourNumbers larger(const FourNumbers& a, const FourNumbers& b) { return a < b ? b : a; }
double smallestOf(const FourNumbers& a) { return std::min({ a[0], a[1], a[2], a[3] }); }
double largestOf(const FourNumbers& a) { return std::max({ a[0], a[1], a[2], a[3] }); }

/// Of vectors 0 to `count` - 1: one(k) is the k-th, four(k) are, in the plane, four from there on.
template <int dim, class One, class Four>
double largestNormOf(int count, const One& one, const Four& four)
{
	double squared = 0;
	int k = 0;
	if constexpr (dim == 2) {
		FourNumbers largest = {};
		for (; k + nodesPerBlock <= count; k += nodesPerBlock) {
			const BlockVectors v = four(k);
			largest = larger(largest, v.dot(v));
		}
		squared = largestOf(largest);
	}
	for (; k < count; ++k)
		squared = std::max(squared, one(k).squaredNorm());
	return std::sqrt(squared);
}

/// Of the same; there is at least one.
template <int dim, class One, class Four>
Box<dim> boxOfAll(int count, const One& one, const Four& four)
{
	Box<dim> box { one(0), one(0) };
	int k = 0;
	if constexpr (dim == 2)
		if (count >= nodesPerBlock) {
			BlockVectors low = four(0), high = low;
			for (; k + nodesPerBlock <= count; k += nodesPerBlock) {
				const BlockVectors v = four(k);
				low = { smaller(low.x, v.x), smaller(low.y, v.y) };
				high = { larger(high.x, v.x), larger(high.y, v.y) };
			}
			box = { { smallestOf(low.x), smallestOf(low.y) },
				{ largestOf(high.x), largestOf(high.y) } };
		}
	for (; k < count; ++k) {
		box.low = box.low.cwiseMin(one(k));
		box.high = box.high.cwiseMax(one(k));
	}
	return box;
}

FourNumbers lengthsOf(const BlockVectors& v)
{
	const FourNumbers squared = v.dot(v);
	FourNumbers length;
	for (int i = 0; i < nodesPerBlock; ++i)
		length[i] = std::sqrt(squared[i]);
	return length;
}

} // namespace

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS Box<dim> boxOf(const std::vector<Vec<dim>>& vectors)
{
	const int count = static_cast<int>(vectors.size());
	return boxOfAll<dim>(
		count, [&](int k) { return vectors[k]; },
		[&](auto k) { return vectorsOf(vectors.data(), k, count); });
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS double farthestFrom(const Vec<dim>& centre,
						       const std::vector<Vec<dim>>& vectors)
{
	const int count = static_cast<int>(vectors.size());
	return largestNormOf<dim>(
		count, [&](int k) { return Vec<dim>(vectors[k] - centre); },
		[&](auto k) { return vectorsOf(vectors.data(), k, count).less(centre); });
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS VectorRange<dim> rangeOfWays(const std::vector<Vec<dim>>& from,
								const std::vector<Vec<dim>>& to)
{
	const int count = static_cast<int>(to.size());
	const auto one = [&](int k) { return Vec<dim>(to[k] - from[k]); };
	const auto four = [&](auto k) {
		const auto a = vectorsOf(from.data(), k, count), b = vectorsOf(to.data(), k, count);
		return BlockVectors { b.x - a.x, b.y - a.y };
	};
	const Vec<dim> middle = boxOfAll<dim>(count, one, four).centre();
	return { middle, largestNormOf<dim>(
				 count, [&](int k) { return Vec<dim>(one(k) - middle); },
				 [&](auto k) { return four(k).less(middle); }) };
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void normalizeAll(std::vector<Vec<dim>>& vectors)
{
	const int count = static_cast<int>(vectors.size());
	int k = 0;
	if constexpr (dim == 2)
		for (; k + nodesPerBlock <= count; k += nodesPerBlock) {
			const FourNumbers length = lengthsOf(vectorsOf(vectors.data(), k, count));
			double* first = vectors[k].data();
			forFourNumbers<2>(
				length > 0 ? length : FourNumbers {} + 1,
				[&](int i, const FourNumbers& l) { fourAt(first + 4 * i) /= l; });
		}
	for (; k < count; ++k)
		vectors[k].normalize();
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template Box<dim> boxOf(const std::vector<Vec<dim>>&);                                     \
	template double farthestFrom<dim>(const Vec<dim>&, const std::vector<Vec<dim>>&);          \
	template VectorRange<dim> rangeOfWays<dim>(const std::vector<Vec<dim>>&,                   \
						   const std::vector<Vec<dim>>&);                  \
	template void normalizeAll(std::vector<Vec<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
