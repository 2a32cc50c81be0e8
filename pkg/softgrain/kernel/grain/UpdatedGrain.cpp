#include "grain/UpdatedGrain.hpp"
#include "grain/GridRows.hpp"
#include "material/Dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace softgrain {

namespace {

/// B-splines for a coordinate in grid steps in every lane.
template <int order>
void splineLanes(const Lanes& x, Lanes& first, Lanes (&value)[rowWidth],
		 Lanes (&gradient)[rowWidth])
{
#pragma omp simd
	for (int l = 0; l < laneWidth; ++l) {
		SplineFactors N, slope;
		first[l] = firstSpline<order>(x[l]);
		splineFactors<order>(x[l] - (first[l] + 1), N, slope);
		for (int c = 0; c < rowWidth; ++c) {
			value[c][l] = N[c];
			gradient[c][l] = slope[c];
		}
	}
}

/// Stencils of `laneWidth` points; x[a] points to their coordinates.
template <int dim, int order>
void findStencils(const SpatialGrid<dim>& grid, double inverseSpacing,
		  const std::array<const double*, dim>& x, int* first, double* factors)
{
	std::array<std::array<int, laneWidth>, dim> index;
	for (int a = 0; a < dim; ++a) {
		Lanes t, begin, value[rowWidth], gradient[rowWidth];
		t = loadLanes(x[a]) * inverseSpacing;
		splineLanes<order>(t, begin, value, gradient);
		for (int l = 0; l < laneWidth; ++l) {
			index[a][l] = static_cast<int>(begin[l]);
			double* own = factors + l * factorCount<dim> + 2 * a * rowWidth;
			for (int c = 0; c < rowWidth; ++c) {
				own[c] = value[c][l];
				own[rowWidth + c] = gradient[c][l] * inverseSpacing;
			}
		}
	}
	for (int l = 0; l < laneWidth; ++l) {
		typename SpatialGrid<dim>::Index node;
		for (int a = 0; a < dim; ++a)
			node[a] = index[a][l];
		first[l] = grid.at(node);
	}
}

/// Adds one point: mass, momentum and -T grad N, where T is Vp0 tau.
template <int dim, int order>
void scatter(SpatialGrid<dim>& grid, const GridRows<dim, order>& rows, double mass,
	     const Vec<dim>& momentum, const double (&T)[dim][dim])
{
	for (int i = 0; i < rows.count; ++i) {
		double N[rowWidth], G[dim][rowWidth];
		for (int c = 0; c < rowWidth; ++c) {
			N[c] = rows.N[i] * rows.along[c];
			for (int b = 0; b < dim - 1; ++b)
				G[b][c] = rows.G[b][i] * rows.along[c];
			G[dim - 1][c] = rows.N[i] * rows.gradientAlong[c];
		}
		double* m = grid.mass.data() + rows.node[i];
#pragma omp simd
		for (int c = 0; c < rowWidth; ++c)
			m[c] += mass * N[c];
		for (int a = 0; a < dim; ++a) {
			double* p = grid.velocity[a].data() + rows.node[i];
			double* f = grid.force[a].data() + rows.node[i];
#pragma omp simd
			for (int c = 0; c < rowWidth; ++c) {
				double sum = 0;
				for (int b = 0; b < dim; ++b)
					sum += T[a][b] * G[b][c];
				p[c] += momentum[a] * N[c];
				f[c] -= sum;
			}
		}
	}
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void stencilsOfPoints(UpdatedGrain<dim>& grain)
{
	const int padded = static_cast<int>(grain.mass.size());
	grain.points.first.resize(padded);
	grain.points.factors.resize(static_cast<std::size_t>(padded) * factorCount<dim>);
	for (int p = 0; p < padded; p += laneWidth) {
		std::array<const double*, dim> x;
		for (int a = 0; a < dim; ++a)
			x[a] = grain.x[a].data() + p;
		findStencils<dim, order>(grain.grid, 1 / grain.spacing, x,
					 grain.points.first.data() + p,
					 grain.points.factors.data() +
						 static_cast<std::size_t>(p) * factorCount<dim>);
	}
}

template <int dim, int order> void stencilsOfContactNodes(UpdatedGrain<dim>& grain)
{
	const int count = static_cast<int>(grain.contactX.size());
	const int padded = (count + laneWidth - 1) / laneWidth * laneWidth;
	grain.contacts.first.resize(padded);
	grain.contacts.factors.resize(static_cast<std::size_t>(padded) * factorCount<dim>);
	for (int s = 0; s < padded; s += laneWidth) {
		Lanes coordinates[dim];
		std::array<const double*, dim> x;
		for (int a = 0; a < dim; ++a) {
			for (int l = 0; l < laneWidth; ++l)
				coordinates[a][l] = grain.contactX[std::min(s + l, count - 1)][a];
			x[a] = &coordinates[a][0];
		}
		findStencils<dim, order>(grain.grid, 1 / grain.spacing, x,
					 grain.contacts.first.data() + s,
					 grain.contacts.factors.data() +
						 static_cast<std::size_t>(s) * factorCount<dim>);
	}
	for (int s = 0; s < count; ++s) {
		const auto rows = grain.contacts.template rows<dim, order>(grain.grid, s);
		for (int i = 0; i < rows.count; ++i)
			for (int c = 0; c <= order; ++c)
				grain.grid.wanted[rows.node[i] + c] = 1;
	}
}

template <int dim, int order, class LawEvaluator>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void spread(UpdatedGrain<dim>& grain, LawEvaluator)
{
	BulkReport report;
	Lanes energy {}, stiffening {};
	PointLanes<dim> point;
	for (int begin = 0; begin < static_cast<int>(grain.mass.size()); begin += laneWidth) {
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				point.F[a][b] = loadLanes(&grain.F[a * dim + b][begin]);
		LawEvaluator::evaluate(point, grain.lame);
		LawEvaluator::stiffenInSpace(point, grain.lame);
		Lanes T[dim][dim];
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b) {
				Lanes sum = {};
				for (int c = 0; c < dim; ++c)
					sum += point.P[a][c] * point.F[b][c];
				T[a][b] = loadLanes(&grain.volume[begin]) * sum;
			}
		energy += loadLanes(&grain.volume[begin]) * point.energy;
		stiffening = larger(point.stiffening, stiffening);
		for (int l = 0; l < laneWidth; ++l) {
			const int p = begin + l;
			if (!(point.J[l] > 0) && report.invertedPoint < 0) report.invertedPoint = p;
			const auto rows = grain.points.template rows<dim, order>(grain.grid, p);
			Vec<dim> momentum;
			double own[dim][dim];
			for (int a = 0; a < dim; ++a) {
				momentum[a] = grain.mass[p] * grain.v[a][p];
				for (int b = 0; b < dim; ++b)
					own[a][b] = T[a][b][l];
			}
			scatter<dim, order>(grain.grid, rows, grain.mass[p], momentum, own);
		}
	}
	report.stiffening = 0;
	for (int l = 0; l < laneWidth; ++l) {
		report.elasticEnergy += energy[l];
		report.stiffening = std::max(report.stiffening, stiffening[l]);
	}
	grain.report = report;
}

template <int dim, int order>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void collect(UpdatedGrain<dim>& grain, double dt,
						double picShare)
{
	for (int begin = 0; begin < static_cast<int>(grain.mass.size()); begin += laneWidth) {
		Lanes after[dim], before[dim], gradient[dim][dim];
		for (int l = 0; l < laneWidth; ++l) {
			const int p = begin + l;
			const auto rows = grain.points.template rows<dim, order>(grain.grid, p);
			for (int a = 0; a < dim; ++a) {
				double slope[dim];
				after[a][l] = gather(grain.grid.velocityNext[a], rows, slope);
				before[a][l] = gather(grain.grid.velocity[a], rows);
				for (int b = 0; b < dim; ++b)
					gradient[a][b][l] = slope[b];
			}
		}
		for (int a = 0; a < dim; ++a) {
			const Lanes v = loadLanes(&grain.v[a][begin]);
			storeLanes(&grain.v[a][begin],
				   (1 - picShare) * (v + (after[a] - before[a])) +
					   picShare * after[a]);
			const Lanes x = loadLanes(&grain.x[a][begin]);
			storeLanes(&grain.x[a][begin], x + dt * after[a]);
		}
		for (int b = 0; b < dim; ++b) {
			Lanes column[dim];
			for (int a = 0; a < dim; ++a) {
				column[a] = Lanes {};
				for (int c = 0; c < dim; ++c)
					column[a] += gradient[a][c] *
						     loadLanes(&grain.F[c * dim + b][begin]);
			}
			for (int a = 0; a < dim; ++a) {
				double* F = &grain.F[a * dim + b][begin];
				storeLanes(F, loadLanes(F) + dt * column[a]);
			}
		}
	}
	for (std::size_t s = 0; s < grain.contactX.size(); ++s) {
		const auto rows = grain.contacts.template rows<dim, order>(grain.grid, s);
		for (int a = 0; a < dim; ++a)
			grain.contactV[s][a] = gather(grain.grid.velocityNext[a], rows);
		grain.contactX[s] += dt * grain.contactV[s];
	}
}

/// Index of the value farthest from a place; one that is not finite is farther than all others.
int farthest(const std::vector<double>& values, double place)
{
	auto distance = [place](double value) {
		const double d = std::abs(value - place);
		return d <= std::numeric_limits<double>::max()
			       ? d
			       : std::numeric_limits<double>::infinity();
	};
	const auto found =
		std::max_element(values.begin(), values.end(), [&](double one, double other) {
			return distance(one) < distance(other);
		});
	return static_cast<int>(found - values.begin());
}

} // namespace

template <int dim> bool UpdatedGrain<dim>::layGrid(int order, double widest)
{
	typename SpatialGrid<dim>::Index low, high;
	for (int a = 0; a < dim; ++a) {
		double least = contactX[0][a], most = least, strange = 0;
		for (double value : x[a]) {
			least = value < least ? value : least;
			most = value > most ? value : most;
			strange += 0 * value; // not a number if one is not finite
		}
		for (const Vec<dim>& xs : contactX) {
			least = std::min(least, xs[a]);
			most = std::max(most, xs[a]);
		}
		if (!(most - least < widest) || strange != 0) {
			report.invertedPoint = farthest(x[a], contactX[0][a]);
			return false;
		}
		low[a] = static_cast<int>(std::floor(least / spacing)) - 1;
		high[a] = static_cast<int>(std::floor(most / spacing)) + rowWidth - 1;
	}
	grid.lay(low, high);
	withSmoothOrder(order, [&](auto smooth) {
		stencilsOfPoints<dim, smooth>(*this);
		stencilsOfContactNodes<dim, smooth>(*this);
	});
	return true;
}

template <int dim> void UpdatedGrain<dim>::pointsToGrid(int order, Law law, Condition condition)
{
	withLaw<dim>(law, condition, [&](auto evaluator) {
		withSmoothOrder(order, [&](auto smooth) { spread<dim, smooth>(*this, evaluator); });
	});
}

template <int dim> void UpdatedGrain<dim>::gridToPoints(int order, double dt, double picShare)
{
	withSmoothOrder(order, [&](auto smooth) { collect<dim, smooth>(*this, dt, picShare); });
}

template struct UpdatedGrain<2>;
template struct UpdatedGrain<3>;

} // namespace softgrain
