#include "Helpers.hpp"
#include "reference/GrainTemplate.hpp"

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

/// What impulses on all nodes, and on a place over each facet, do one after the other.
template <int dim> void checkPushes(const GrainTemplate<dim>& grain)
{
	Random random(1);
	const Eigen::MatrixXd W = denseDelassus(grain);
	const int nodes = grain.contactNodes();
	const SurfaceMobility<dim>& surface = grain.surfaceMobility;
	std::vector<Vec<dim>> v(nodes + surface.padding(), Vec<dim>::Zero());
	Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(nodes, dim);
	for (int s = 0; s < nodes; ++s) {
		const Vec<dim> J = random.vector<dim>();
		CHECK(surface.ofNode(s) == W(s, s));
		surface.push(v.data(), s, J);
		expected += W.col(s) * J.transpose();
	}
	for (std::size_t f = 0; f < grain.contactMesh.facet.size(); ++f) {
		const auto carrier = grain.contactMesh.carriers(static_cast<int>(f));
		std::array<double, mostPartners<dim>> share;
		Eigen::VectorXd shares = Eigen::VectorXd::Zero(nodes);
		for (std::size_t i = 0; i < share.size(); ++i)
			shares[carrier[i]] += share[i] = random.uniform(-0.2, 1);
		const Vec<dim> J = random.vector<dim>();
		const double own = shares.dot(W * shares);
		CHECK_THAT(surface.ofPlace(static_cast<int>(f), share),
			   WithinAbs(own, 1e-12 * own));
		surface.push(v.data(), static_cast<int>(f), share, J);
		expected += W * shares * J.transpose();
	}
	const double scale = expected.cwiseAbs().maxCoeff();
	for (int s = 0; s < nodes; ++s)
		CHECK((v[s].transpose() - expected.row(s)).norm() < 1e-12 * scale);
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
	SECTION("a ball")
	{
		recipe.zeta = 0.35;
		checkPushes(*makeGrainTemplate<3>(recipe));
	}
}
