// The limits of this machine in double precision: fused multiply-adds from registers, and streaming
// from memory and from the second cache. Prints one JSON object.
//
//     softgrain_benchmark_roofline THREADS
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <omp.h>
#include <vector>

namespace {

constexpr int repetitions = 7;
constexpr int chains = 12; // of multiply-adds

/// The versions of lanes/Lanes.hpp: what the kernel is compiled for.
#define SOFTGRAIN_VERSIONS                                                                         \
	__attribute__((noinline, target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))

const char* instructionSet()
{
	__builtin_cpu_init();
	if (__builtin_cpu_supports("x86-64-v4")) return "x86-64-v4 (AVX-512)";
	if (__builtin_cpu_supports("x86-64-v3")) return "x86-64-v3 (AVX2)";
	return "x86-64 (SSE2)";
}

/// Processor time of work that keeps all threads busy, over their number: other programs on the
/// machine do not count.
double secondsOf(const std::function<void()>& work, int threads)
{
	const std::clock_t start = std::clock();
	work();
	return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / threads;
}

/// The fastest of some runs: a limit, not a typical figure.
double shortest(const std::function<void()>& work, int threads)
{
	double best = secondsOf(work, threads);
	for (int k = 1; k < repetitions; ++k)
		best = std::min(best, secondsOf(work, threads));
	return best;
}

template <int width> struct VectorOf {
	using Type [[gnu::vector_size(8 * width)]] = double;
};

/// Independent chains of multiply-adds of so many numbers, enough to hide their latency; the
/// compiler fuses them where the instruction set can. Returns a sum that depends on all of them.
template <int width>
[[gnu::always_inline]] inline double multiplyAddChains(long rounds, double start)
{
	using Vector = typename VectorOf<width>::Type;
	Vector x[chains];
	for (int c = 0; c < chains; ++c)
		x[c] = Vector {} + (start + c);
	const Vector a = Vector {} + 0.999999, b = Vector {} + 1e-6;
	for (long k = 0; k < rounds; ++k)
#pragma GCC unroll 12
		for (int c = 0; c < chains; ++c)
			x[c] = x[c] * a + b;
	Vector sum {};
	for (int c = 0; c < chains; ++c)
		sum += x[c];
	double total = 0;
	for (int lane = 0; lane < width; ++lane)
		total += sum[lane];
	return total;
}

/// As wide as a register of each instruction set: of wider ones the chains would not fit into the
/// registers.
SOFTGRAIN_VERSIONS double multiplyAddOf2(long rounds, double start)
{
	return multiplyAddChains<2>(rounds, start);
}
SOFTGRAIN_VERSIONS double multiplyAddOf4(long rounds, double start)
{
	return multiplyAddChains<4>(rounds, start);
}
SOFTGRAIN_VERSIONS double multiplyAddOf8(long rounds, double start)
{
	return multiplyAddChains<8>(rounds, start);
}

double sink = 0; // what keeps the work from being left out

/// Floating-point operations per second, a multiply-add counted as two.
double flopsOf(double (*multiplyAdd)(long, double), int width, int threads)
{
	constexpr long rounds = 4000000;
	const double seconds = shortest(
		[&] {
			double sum = 0;
#pragma omp parallel num_threads(threads) reduction(+ : sum)
			sum += multiplyAdd(rounds, 1.);
			sink = sink + sum;
		},
		threads);
	return 2. * chains * width * rounds * threads / seconds;
}

double peakFlops(int threads)
{
	return std::max({ flopsOf(multiplyAddOf2, 2, threads), flopsOf(multiplyAddOf4, 4, threads),
			  flopsOf(multiplyAddOf8, 8, threads) });
}

SOFTGRAIN_VERSIONS void triad(double* a, const double* b, const double* c, long n)
{
	for (long i = 0; i < n; ++i)
		a[i] = b[i] + 0.5 * c[i];
}

/// Bytes per second of a = b + s c over arrays of n numbers for each thread (24 bytes a number;
/// what the machine reads of `a` before it writes is not counted).
double bandwidth(int threads, long n, int passes)
{
	std::vector<std::vector<double>> a(threads), b(threads), c(threads);
#pragma omp parallel num_threads(threads)
	{
		const int t = omp_get_thread_num();
		a[t].assign(n, 0.);
		b[t].assign(n, 1.);
		c[t].assign(n, 2.);
	}
	const double seconds = shortest(
		[&] {
#pragma omp parallel num_threads(threads)
			{
				const int t = omp_get_thread_num();
				for (int k = 0; k < passes; ++k)
					triad(a[t].data(), b[t].data(), c[t].data(), n);
			}
		},
		threads);
	for (const auto& numbers : a)
		sink = sink + numbers[n / 2];
	return 24. * n * passes * threads / seconds;
}

} // namespace

int main(int argc, char** argv)
{
	const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
	if (threads < 1) {
		std::fprintf(stderr, "THREADS = %s is outside the admissible range 1, 2, ...\n",
			     argv[1]);
		return 1;
	}
	constexpr long inMemory = 8000000, inCache = 20000; // 3 arrays: 192 MB, 480 kB a thread
	const double flops = peakFlops(threads);
	const double memory = bandwidth(threads, inMemory, 2);
	const double cache = bandwidth(threads, inCache, 400);
	std::printf("{\"instruction_set\": \"%s\", \"threads\": %d, \"peak_gflops\": %.4g, "
		    "\"memory_gb_per_s\": %.4g, \"cache_gb_per_s\": %.4g}\n",
		    instructionSet(), threads, flops / 1e9, memory / 1e9, cache / 1e9);
	return sink == 0.5; // never: keeps `sink` alive
}
