// Time of the bulk pass (grain/InternalForce.hpp) for material point and step, one thread, without
// contacts. Prints a CSV line for each case: the name, nanoseconds of processor time (median of
// some runs), the floating-point operations that a plain stencil needs in 1e9/s, and their share of
// what fused multiply-adds from registers reach on this machine. The pass itself makes fewer of
// them, and the law's are not counted.
//
//     softgrain_benchmark_bulk [CASE...]
#include "grain/InternalForce.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace softgrain;

constexpr int repetitions = 9;

double processorTime() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Median over some runs of the seconds that `work` takes.
double medianTime(const std::function<void()>& work)
{
	std::vector<double> seconds;
	for (int k = 0; k < repetitions; ++k) {
		const double start = processorTime();
		work();
		seconds.push_back(processorTime() - start);
	}
	std::nth_element(seconds.begin(), seconds.begin() + repetitions / 2, seconds.end());
	return seconds[repetitions / 2];
}

/// Independent chains of multiply-adds, enough to hide their latency.
__attribute__((noinline, optimize("fp-contract=fast"),
	       target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"))) double
multiplyAdds(long rounds)
{
	constexpr int chains = 12;
	Lanes x[chains];
	for (int c = 0; c < chains; ++c)
		x[c] = Lanes {} + (1. + c);
	for (long k = 0; k < rounds; ++k)
#pragma GCC unroll 12
		for (int c = 0; c < chains; ++c)
			x[c] = x[c] * 0.999999 + 1e-6;
	double sum = 0;
	for (int c = 0; c < chains; ++c)
		sum += x[c][0];
	return sum;
}

/// In 1e9 floating-point operations per second.
double peak()
{
	constexpr long rounds = 4000000;
	double sum = 0;
	const double seconds = medianTime([&] { sum += multiplyAdds(rounds); });
	if (!(sum > 0)) std::fprintf(stderr, "the multiply-adds went astray\n");
	return 2e-9 * 12 * laneWidth * rounds / seconds;
}

struct Case {
	const char* name;
	int dim, order;
	double zeta, nodeSpacing;
	int grains; ///< in one batch
	VolumetricStrain volumetric = VolumetricStrain::pointwise;
};

const Case cases[] = {
	{ "2D cubic, h = 2 dr", 2, 3, 0.11, 2, 400 },
	{ "2D cubic, h = 1.25 dr", 2, 3, 0.11, 1.25, 400 },
	{ "2D quadratic, h = 2 dr", 2, 2, 0.11, 2, 400 },
	{ "2D cubic, h = 2 dr, projected", 2, 3, 0.11, 2, 400, VolumetricStrain::projected },
	{ "2D cubic, h = 2 dr, one grain", 2, 3, 0.11, 2, 1 },
	{ "2D cubic, h = 1.25 dr, one grain", 2, 3, 0.11, 1.25, 1 },
	{ "2D cubic, h = 2 dr, 3 grains", 2, 3, 0.11, 2, 3 },
	{ "2D cubic, h = 2 dr, 4 grains", 2, 3, 0.11, 2, 4 },
	{ "3D cubic, h = 2 dr", 3, 3, 0.2, 2, 40 },
	{ "3D quadratic, h = 2 dr", 3, 2, 0.2, 2, 40 },
	{ "3D cubic, h = 2 dr, one grain", 3, 3, 0.2, 2, 1 },
	{ "3D quadratic, h = 2 dr, one grain", 3, 2, 0.2, 2, 1 },
};

/// Grains with radii of their own, sheared.
template <int dim> Batch<dim> batchOf(const Case& c)
{
	TemplateRecipe recipe;
	recipe.zeta = c.zeta;
	recipe.order = c.order;
	recipe.nodeSpacing = c.nodeSpacing;
	recipe.volumetric = c.volumetric;
	std::mt19937 generator(1);
	std::vector<GrainParameters<dim>> grains(c.grains);
	for (GrainParameters<dim>& grain : grains)
		grain.radius = 0.008 + 0.004 * generator() / std::mt19937::max();
	Batch<dim> batch(makeGrainTemplate<dim>(recipe), Law::neoHookean,
			 dim == 2 ? Condition::planeStrain : Condition::solid, grains);
	Mat<dim> F = Mat<dim>::Identity();
	F(0, 0) = 1.03;
	F(1, 0) = 0.1;
	for (int g = 0; g < c.grains; ++g)
		for (int I = 0; I < batch.reference->nodes(); ++I)
			batch.x.set(g, I, F * batch.x.get(g, I));
	return batch;
}

template <int dim> void measure(const Case& c, double peak)
{
	Batch<dim> batch = batchOf<dim>(c);
	const double points = static_cast<double>(c.grains) * batch.reference->points();
	const int steps = std::max(1, static_cast<int>(4e6 / points));
	const double seconds = medianTime([&] {
		for (int k = 0; k < steps; ++k)
			computeInternalForce(batch, 1);
	});
	const double nanoseconds = 1e9 * seconds / steps / points;
	double operations = 4 * dim * dim; // F and the forces, a multiply-add counted as two
	for (int a = 0; a < dim; ++a)
		operations *= c.order + 1;
	std::printf("\"%s\",%.2f,%.1f,%.2f\n", c.name, nanoseconds, operations / nanoseconds,
		    operations / nanoseconds / peak);
}

} // namespace

int main(int argc, char** argv)
{
	const std::vector<std::string> wanted(argv + 1, argv + argc);
	const double limit = peak();
	std::printf("case,ns per point and step,GFlop/s,share of peak\n");
	std::printf("\"multiply-adds from registers\",,%.1f,1\n", limit);
	for (const Case& c : cases)
		if (wanted.empty() ||
		    std::find(wanted.begin(), wanted.end(), c.name) != wanted.end())
			c.dim == 2 ? measure<2>(c, limit) : measure<3>(c, limit);
}
