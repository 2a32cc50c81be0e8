#include "Extent.hpp"
#include "material/Lanes.hpp"
#include "reference/NodeBlocks.hpp"

namespace softgrain {

namespace {

/// Of these vectors and of none before them.
template <int dim> Extent<dim> extentOneByOne(const std::vector<Vec<dim>>& vectors)
{
	Extent<dim> all { vectors[0], vectors[0] };
	for (const Vec<dim>& v : vectors) {
		all.low = all.low.cwiseMin(v);
		all.high = all.high.cwiseMax(v);
	}
	return all;
}

template <int dim>
double farthestOneByOne(const Vec<dim>& centre, const std::vector<Vec<dim>>& vectors)
{
	double squared = 0;
	for (const Vec<dim>& v : vectors)
		squared = std::max(squared, (v - centre).squaredNorm());
	return std::sqrt(squared);
}

/// Calls with the vectors of four at a time; the last four may overlap those before them.
template <class Visit> void forFourVectors(const std::vector<Vec<2>>& vectors, Visit&& visit)
{
	const int count = static_cast<int>(vectors.size());
	for (int k = 0; k < count; k += nodesPerBlock)
		visit(vectorsOf(vectors.data(), std::min(k, count - nodesPerBlock), count));
}

FourNumbers smaller(const FourNumbers& a, const FourNumbers& b) { return b < a ? b : a; }
FourNumbers larger(const FourNumbers& a, const FourNumbers& b) { return a < b ? b : a; }
double smallestOf(const FourNumbers& a) { return std::min({ a[0], a[1], a[2], a[3] }); }
double largestOf(const FourNumbers& a) { return std::max({ a[0], a[1], a[2], a[3] }); }

SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void takeIn(const std::vector<Vec<2>>& vectors, Extent<2>& all)
{
	BlockVectors low = vectorsOf(vectors.data(), 0, nodesPerBlock), high = low;
	forFourVectors(vectors, [&](const BlockVectors& v) {
		low = { smaller(low.x, v.x), smaller(low.y, v.y) };
		high = { larger(high.x, v.x), larger(high.y, v.y) };
	});
	all = { { smallestOf(low.x), smallestOf(low.y) },
		{ largestOf(high.x), largestOf(high.y) } };
}

SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS double farthest(const Vec<2>& centre,
						   const std::vector<Vec<2>>& vectors)
{
	FourNumbers squared = {};
	forFourVectors(vectors, [&](const BlockVectors& v) {
		const BlockVectors way = v.less(centre);
		squared = larger(squared, way.dot(way));
	});
	return std::sqrt(largestOf(squared));
}

template <int dim>
double farthestWayOneByOne(const std::vector<Vec<dim>>& from, const std::vector<Vec<dim>>& to,
			   const Vec<dim>& together)
{
	double squared = 0;
	for (std::size_t k = 0; k < to.size(); ++k)
		squared = std::max(squared, (to[k] - from[k] - together).squaredNorm());
	return std::sqrt(squared);
}

SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS double
longestWay(const std::vector<Vec<2>>& from, const std::vector<Vec<2>>& to, const Vec<2>& together)
{
	const int count = static_cast<int>(to.size());
	FourNumbers squared = {};
	for (int k = 0; k < count; k += nodesPerBlock) {
		const int first = std::min(k, count - nodesPerBlock);
		const BlockVectors a = vectorsOf(from.data(), first, count),
				   b = vectorsOf(to.data(), first, count);
		const BlockVectors way = BlockVectors { b.x - a.x, b.y - a.y }.less(together);
		squared = larger(squared, way.dot(way));
	}
	return std::sqrt(largestOf(squared));
}

FourNumbers lengthsOf(const BlockVectors& v)
{
	const FourNumbers squared = v.dot(v);
	FourNumbers length;
	for (int i = 0; i < nodesPerBlock; ++i)
		length[i] = std::sqrt(squared[i]);
	return length;
}

SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void normalizeBlocks(std::vector<Vec<2>>& vectors)
{
	const int count = static_cast<int>(vectors.size());
	for (int k = 0; k + nodesPerBlock <= count; k += nodesPerBlock) {
		const FourNumbers length = lengthsOf(vectorsOf(vectors.data(), k, count));
		double* first = vectors[k].data();
		forFourNumbers<2>(length > 0 ? length : FourNumbers {} + 1,
				  [&](int i, const FourNumbers& l) { fourAt(first + 4 * i) /= l; });
	}
	for (int k = count - count % nodesPerBlock; k < count; ++k)
		vectors[k].normalize();
}

} // namespace

template <> Extent<2> extentOf(const std::vector<Vec<2>>& vectors)
{
	if (vectors.size() < nodesPerBlock) return extentOneByOne<2>(vectors);
	Extent<2> all;
	takeIn(vectors, all);
	return all;
}
template <> Extent<3> extentOf(const std::vector<Vec<3>>& vectors)
{
	return extentOneByOne<3>(vectors);
}

template <> double farthestFrom<2>(const Vec<2>& centre, const std::vector<Vec<2>>& vectors)
{
	if (vectors.size() < nodesPerBlock) return farthestOneByOne<2>(centre, vectors);
	return farthest(centre, vectors);
}
template <> double farthestFrom<3>(const Vec<3>& centre, const std::vector<Vec<3>>& vectors)
{
	return farthestOneByOne<3>(centre, vectors);
}

template <>
double farthestWay<2>(const std::vector<Vec<2>>& from, const std::vector<Vec<2>>& to,
		      const Vec<2>& together)
{
	if (to.size() < nodesPerBlock) return farthestWayOneByOne<2>(from, to, together);
	return longestWay(from, to, together);
}
template <>
double farthestWay<3>(const std::vector<Vec<3>>& from, const std::vector<Vec<3>>& to,
		      const Vec<3>& together)
{
	return farthestWayOneByOne<3>(from, to, together);
}

template <> void normalizeAll<2>(std::vector<Vec<2>>& vectors) { normalizeBlocks(vectors); }
template <> void normalizeAll<3>(std::vector<Vec<3>>& vectors)
{
	for (Vec<3>& v : vectors)
		v.normalize();
}

} // namespace softgrain
