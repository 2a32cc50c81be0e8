#include "Helpers.hpp"
#include "reference/GrainTemplate.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>

using namespace softgrain;
using namespace softgrain::testing;
using Catch::Matchers::WithinAbs;

namespace {

template <int dim> Eigen::MatrixXd denseDelassus(const GrainTemplate<dim>& grain)
{
	const SparseRows<double>& table = grain.delassus;
	Eigen::MatrixXd W = Eigen::MatrixXd::Zero(table.rows(), table.rows());
	for (int s = 0; s < table.rows(); ++s)
		for (int k = table.begin(s); k < table.end(s); ++k)
			W(s, table.column[k]) = table.value[k];
	return W;
}

/// Pushes of the plane move all nodes, pushes in space those in marked blocks.
template <int dim, class... Place>
void push(const SurfaceMobility<dim>& surface, const std::vector<BlockSet>& marked,
	  std::vector<Vec<dim>>& v, const Place&... place)
{
	if constexpr (dim == 2)
		surface.push(v.data(), place...);
	else
		surface.push(v.data(), marked.data(), place...);
}

/// Marks of every so many-th node, and the nodes of the blocks that have one.
struct Marks {
	std::vector<BlockSet> marked;
	std::vector<char> isMarked;

	Marks(int nodes, int every)
		: marked(segmentsOf(nodes), 0)
		, isMarked(nodes, 0)
	{
		for (int s = 0; s < nodes; s += every) {
			marked[s / nodesPerSegment] |= blockOf(s);
			const int begin = s - s % nodesPerBlock;
			for (int other = begin; other < std::min(begin + nodesPerBlock, nodes);
			     ++other)
				isMarked[other] = 1;
		}
	}
};

/// Whether impulses on some node leave all of some segment at rest.
bool hasEmptySegments(const SparseRows<double>& delassus)
{
	for (int s = 0; s < delassus.rows(); ++s) {
		std::vector<char> met(segmentsOf(delassus.rows()), 0);
		for (int k = delassus.begin(s); k < delassus.end(s); ++k)
			met[delassus.column[k] / nodesPerSegment] = 1;
		if (std::count(met.begin(), met.end(), 0) > 0) return true;
	}
	return false;
}

/// What impulses on all nodes, and on a place over each facet, do one after the other; in space to
/// every so many-th node and those beside it.
template <int dim> void checkPushes(const GrainTemplate<dim>& grain, int every = 1)
{
	Random random(1);
	const Eigen::MatrixXd W = denseDelassus(grain);
	const int nodes = grain.contactNodes();
	const SurfaceMobility<dim>& surface = grain.surfaceMobility;
	const Marks marks(nodes, every);
	std::vector<Vec<dim>> v(nodes + surface.padding(), Vec<dim>::Zero());
	Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(nodes, dim);
	for (int s = 0; s < nodes; ++s) {
		const Vec<dim> J = random.vector<dim>();
		CHECK(surface.ofNode(s) == W(s, s));
		for (int other = 0; other < nodes; ++other)
			CHECK(surface.between(s, other) == W(s, other));
		push<dim>(surface, marks.marked, v, s, J);
		expected += W.col(s) * J.transpose();
	}
	for (std::size_t f = 0; f < grain.contactMesh.facet.size(); ++f) {
		const auto carrier = grain.contactMesh.carriers(static_cast<int>(f));
		std::array<double, mostPartners<dim>> share;
		Eigen::VectorXd shares = Eigen::VectorXd::Zero(nodes);
		for (std::size_t i = 0; i < share.size(); ++i)
			shares[carrier[i]] += share[i] = random.uniform(-0.2, 1);
		const Vec<dim> J = random.vector<dim>();
		for (int other = 0; other < nodes; ++other)
			CHECK_THAT(surface.between(static_cast<int>(f), share, other),
				   WithinAbs(shares.dot(W.col(other)), 1e-14 * W(other, other)));
		const double own = shares.dot(W * shares);
		CHECK_THAT(surface.ofPlace(static_cast<int>(f), share),
			   WithinAbs(own, 1e-12 * own));
		push<dim>(surface, marks.marked, v, static_cast<int>(f), share, J);
		expected += W * shares * J.transpose();
	}
	const double scale = expected.cwiseAbs().maxCoeff();
	for (int s = 0; s < nodes; ++s)
		if (marks.isMarked[s])
			CHECK((v[s].transpose() - expected.row(s)).norm() < 1e-12 * scale);
		else
			CHECK(v[s].isZero(0));
	for (std::size_t s = nodes; s < v.size(); ++s)
		CHECK(v[s].isZero(0));
}

} // namespace

TEST_CASE("Surface mobility: impulses move what the rows of W say", "[reference]")
{
	TemplateRecipe recipe;
	SECTION("disks, rows that go round the seam, few blocks and many")
	{
		for (double zeta : { 0.11, 0.15, 0.2, 0.35, 0.5 }) {
			recipe.zeta = zeta;
			checkPushes(*makeGrainTemplate<2>(recipe));
		}
	}
	SECTION("a block with corners")
	{
		recipe.zeta = 0.2;
		recipe.form.form = Form::block;
		checkPushes(*makeGrainTemplate<2>(recipe));
	}
	SECTION("balls, of a few segments and of many, all of them and some of their nodes")
	{
		for (double zeta : { 0.35, 0.15 }) {
			recipe.zeta = zeta;
			recipe.order = 2;
			const auto grain = makeGrainTemplate<3>(recipe);
			if (zeta < 0.2) CHECK(hasEmptySegments(grain->delassus));
			for (int every : { 1, 3, 17, 150 })
				checkPushes(*grain, every);
		}
	}
}
