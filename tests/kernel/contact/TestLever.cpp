#include "Helpers.hpp"
#include "contact/Lever.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

template <int dim> using Places = std::array<Vec<dim>, mostPartners<dim>>;

/// The nodes of a facet, and in the plane those beside it, that lie about so to a normal.
template <int dim> Places<dim> placesAcross(Random& random, const Vec<dim>& n)
{
	Places<dim> x;
	for (std::size_t i = 0; i < x.size(); ++i) {
		Vec<dim> away = random.vector<dim>();
		away -= away.dot(n) * n;
		x[i] = Vec<dim>::Constant(3) + away + random.uniform(-0.05, 0.05) * n;
	}
	double size; // of the facet
	if constexpr (dim == 2)
		size = (x[2] - x[1]).norm();
	else
		size = (x[1] - x[0]).cross(x[2] - x[0]).norm();
	return size > 0.3 ? x : placesAcross<dim>(random, n);
}

/// A turn, as an antisymmetric matrix.
template <int dim> Mat<dim> anyTurn(Random& random)
{
	const Mat<dim> any = random.matrix<dim>();
	return any - any.transpose();
}

} // namespace

TEMPLATE_TEST_CASE_SIG("levers tell how a normal turns and leave no moment", "[interface]",
		       ((int dim), dim), 2, 3)
{
	Random random(7);
	for (int round = 0; round < 50; ++round) {
		const Vec<dim> n = random.direction<dim>(), p = random.vector<dim>();
		const Places<dim> x = placesAcross<dim>(random, n);
		const double gap = random.uniform(-0.1, 0.4);
		const Levers<dim> a = leversOf(x, n, gap);
		// all turns as one
		const Mat<dim> turn = anyTurn<dim>(random);
		Vec<dim> normalTurns = Vec<dim>::Zero();
		for (std::size_t i = 0; i < x.size(); ++i)
			normalTurns -= a[i] * n.dot(turn * x[i]);
		CHECK((normalTurns - gap * turn * n).norm() < 1e-12);
		// work of p in it: at the node, which is the gap before the surface, and on the
		// surface
		const Vec<dim> foot = x[1];
		double work = p.dot(turn * (foot + gap * n)) - p.dot(turn * foot);
		Vec<dim> sum = Vec<dim>::Zero();
		for (std::size_t i = 0; i < x.size(); ++i) {
			work += p.dot(a[i]) * n.dot(turn * x[i]);
			sum += a[i];
		}
		CHECK(std::abs(work) < 1e-12);
		CHECK(sum.norm() < 1e-13);
	}
}

TEST_CASE("a facet that a contact lies beside has no levers", "[interface]")
{
	const Places<2> x = { Vec<2>(0, 3), Vec<2>(0, 2), Vec<2>(0, 1), Vec<2>(0, 0) };
	for (const Vec<2>& a : leversOf(x, Vec<2>(0.1, 1).normalized(), 0.3))
		CHECK(a.isZero(0));
	const Places<3> y = { Vec<3>(0, 0, 0), Vec<3>(0, 1, 0), Vec<3>(0, 0, 1) };
	for (const Vec<3>& a : leversOf(y, Vec<3>(0.1, 1, 0).normalized(), 0.3))
		CHECK(a.isZero(0));
}
