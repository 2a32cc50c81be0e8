// Fields coarser than the motion, for the pressure of nearly incompressible grains.
//
// As nu approaches 1/2, lambda (ln J)^2 at every material point is more constraints than the
// splines have freedom: pressures oscillate from point to point and small contacts are too stiff.
// Cure: ln J is replaced by theta = Pi ln J, its least-squares projection (weights Vp0) on the
// continuous multilinear functions of a grid of step 2 nodeSpacing dr. The energy lambda/2 sum_p
// Vp0 theta_p^2 has the derivative lambda theta_p at every point, so that forces stay conservative
// (doc/decisions/0009-near-incompressible.md).
#pragma once

#include "Vector.hpp"
#include "reference/Quadrature.hpp"
#include "reference/SparseRows.hpp"

#include <vector>

namespace softgrain {

/// A space of scalar fields on the material points of a grain, and the projection on it.
struct PressureSpace {
	SparseRows<double> shapes; ///< row p: functions with their values at Xp; they sum to 1
	SparseRows<double> factor; ///< Cholesky's L of the Gram matrix sum_p Vp0 N_a N_b by rows,
				   ///< each ending with its diagonal

	int functions() const { return factor.rows(); }
	bool empty() const { return factor.rows() == 0; }
};

/// Functions of less than this share of the greatest weight are left out and the others scaled to
/// sum to 1: at the rim several functions may see the same few points.
constexpr double lightFunctionShare = 0.02;

/// Multilinear functions on a grid of step `spacing` (in radii) with a node at the centre.
template <int dim>
PressureSpace makePressureSpace(const Quadrature<dim>& quadrature, double spacing);

/// values <- Pi values, in the metric of `volume`; `values` holds `width` numbers side by side for
/// each material point (independent fields).
template <int width>
void project(const PressureSpace& space, const std::vector<double>& volume, double* values)
{
	std::vector<double> moments(static_cast<std::size_t>(space.functions()) * width, 0.);
	auto axpy = [](double a, const double* x, double* y) {
#pragma omp simd
		for (int l = 0; l < width; ++l)
			y[l] += a * x[l];
	};
	double* m = moments.data();
	for (int p = 0; p < space.shapes.rows(); ++p)
		for (int k = space.shapes.begin(p); k < space.shapes.end(p); ++k)
			axpy(volume[p] * space.shapes.value[k], values + p * width,
			     m + space.shapes.column[k] * width);
	const SparseRows<double>& L = space.factor;
	for (int a = 0; a < L.rows(); ++a) { // L y = m
		const int diagonal = L.end(a) - 1;
		for (int k = L.begin(a); k < diagonal; ++k)
			axpy(-L.value[k], m + L.column[k] * width, m + a * width);
		for (int l = 0; l < width; ++l)
			m[a * width + l] /= L.value[diagonal];
	}
	for (int a = L.rows() - 1; a >= 0; --a) { // L^T c = y
		const int diagonal = L.end(a) - 1;
		for (int l = 0; l < width; ++l)
			m[a * width + l] /= L.value[diagonal];
		for (int k = L.begin(a); k < diagonal; ++k)
			axpy(-L.value[k], m + a * width, m + L.column[k] * width);
	}
	for (int p = 0; p < space.shapes.rows(); ++p) {
		for (int l = 0; l < width; ++l)
			values[p * width + l] = 0;
		for (int k = space.shapes.begin(p); k < space.shapes.end(p); ++k)
			axpy(space.shapes.value[k], m + space.shapes.column[k] * width,
			     values + p * width);
	}
}

} // namespace softgrain
