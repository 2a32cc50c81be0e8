// Time of the bulk pass (grain/InternalForce.hpp), one thread, without contacts. *points*: material
// points and steps a second; *point*: seconds for one; *flops*: the floating-point operations a
// second that a plain stencil needs (the pass itself makes fewer of them, and the law's are not
// counted), to be held against the peak that softgrain_benchmark_roofline finds.
#include "grain/InternalForce.hpp"

#include <benchmark/benchmark.h>

#include <random>

namespace {

using namespace softgrain;

struct Case {
	const char* name;
	int dim, order;
	double zeta, nodeSpacing;
	int grains; ///< in one batch
	VolumetricStrain volumetric = VolumetricStrain::pointwise;
	int batches = 1; ///< each with a template of its own: with many they are not in the caches
};

const Case cases[] = {
	{ "2D cubic, h = 2 dr", 2, 3, 0.11, 2, 400 },
	{ "2D cubic, h = 1.25 dr", 2, 3, 0.11, 1.25, 400 },
	{ "2D quadratic, h = 2 dr", 2, 2, 0.11, 2, 400 },
	{ "2D cubic, h = 2 dr, projected", 2, 3, 0.11, 2, 400, VolumetricStrain::projected },
	{ "2D cubic, h = 2 dr, one grain", 2, 3, 0.11, 2, 1 },
	{ "2D cubic, h = 1.25 dr, one grain", 2, 3, 0.11, 1.25, 1 },
	{ "2D cubic, h = 2 dr, 100 of one grain", 2, 3, 0.11, 2, 1, VolumetricStrain::pointwise,
	  100 },
	{ "2D cubic, h = 1.25 dr, 100 of one grain", 2, 3, 0.11, 1.25, 1,
	  VolumetricStrain::pointwise, 100 },
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

template <int dim> void measure(benchmark::State& state, const Case& c)
{
	std::vector<Batch<dim>> batches;
	for (int b = 0; b < c.batches; ++b)
		batches.push_back(batchOf<dim>(c));
	for (auto _ : state)
		for (Batch<dim>& batch : batches)
			computeInternalForce(batch, 1);
	double operations = 4 * dim * dim; // F and the forces, a multiply-add counted as two
	for (int a = 0; a < dim; ++a)
		operations *= c.order + 1;
	const double points =
		static_cast<double>(c.batches) * c.grains * batches[0].reference->points();
	using benchmark::Counter;
	state.counters["points"] = Counter(points, Counter::kIsIterationInvariantRate);
	state.counters["point"] =
		Counter(points, Counter::kIsIterationInvariantRate | Counter::kInvert);
	state.counters["flops"] = Counter(operations * points, Counter::kIsIterationInvariantRate);
}

} // namespace

int main(int argc, char** argv)
{
	for (const Case& c : cases)
		benchmark::RegisterBenchmark(c.name, c.dim == 2 ? measure<2> : measure<3>, c);
	benchmark::Initialize(&argc, argv);
	if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
	benchmark::RunSpecifiedBenchmarks();
	benchmark::Shutdown();
}
