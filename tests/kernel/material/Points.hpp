// One material point at a time, for tests of laws that work on lanes.
#pragma once

#include "Vector.hpp"
#include "material/NeoHookean.hpp"

namespace softgrain::testing {

/// The three conditions as types, for TEMPLATE_TEST_CASE.
struct PlaneStrain {
	using Part = WholeLanes;
	static constexpr int dim = 2;
	static constexpr Condition condition = Condition::planeStrain;
};
struct PlaneStress {
	using Part = WholeLanes;
	static constexpr int dim = 2;
	static constexpr Condition condition = Condition::planeStress;
};
struct Solid {
	using Part = WholeLanes;
	static constexpr int dim = 3;
	static constexpr Condition condition = Condition::solid;
};
/// Cases that half of the lanes are computed of at once, which a machine with AVX-512 does nowhere
/// else.
template <class Case> struct Halves : Case {
	using Part = HalfLanes;
};

template <int dim> struct PointResult {
	Mat<dim> P;
	double J, energy, stiffening;
};

template <int dim, class Part>
void setLane(PointLanes<dim, Part>& point, int lane, const Mat<dim>& F)
{
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			point.F[a][b][lane] = F(a, b);
}

template <int dim, class Part>
PointResult<dim> getLane(const PointLanes<dim, Part>& point, int lane)
{
	PointResult<dim> r;
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			r.P(a, b) = point.P[a][b][lane];
	r.J = point.J[lane];
	r.energy = point.energy[lane];
	r.stiffening = point.stiffening[lane];
	return r;
}

/// Lanes of which one holds F, the others are undeformed.
template <int dim, class Part = WholeLanes> struct OneAmongLanes {
	PointLanes<dim, Part> point;
	LameNumbers<Part> lame;

	OneAmongLanes(const Mat<dim>& F, const ElasticConstants& c, int lane)
		: lame(LameConstants::ofAll(c).template part<Part>(0))
	{
		for (int l = 0; l < Part::width; ++l)
			setLane<dim>(point, l, l == lane ? F : Mat<dim>(Mat<dim>::Identity()));
	}
};

/// Response of the law to F.
template <class Case>
PointResult<Case::dim> respond(const Mat<Case::dim>& F, const ElasticConstants& c, int lane = 3)
{
	OneAmongLanes<Case::dim, typename Case::Part> one(F, c, lane);
	NeoHookean<Case::dim, Case::condition>::evaluate(one.point, one.lame);
	return getLane<Case::dim>(one.point, lane);
}

/// The same with the stiffening seen by a grid fixed in space.
template <class Case>
PointResult<Case::dim> respondInSpace(const Mat<Case::dim>& F, const ElasticConstants& c)
{
	OneAmongLanes<Case::dim> one(F, c, 3);
	NeoHookean<Case::dim, Case::condition>::evaluate(one.point, one.lame);
	NeoHookean<Case::dim, Case::condition>::stiffenInSpace(one.point, LameConstants::ofAll(c));
	return getLane<Case::dim>(one.point, 3);
}

/// ln F33 in plane stress.
template <class Part = WholeLanes> double thicknessStrain(double J2, const ElasticConstants& c)
{
	const auto one = typename Part::Numbers {} + 1;
	return detail::thicknessStrain<Part>(std::log(J2) * one, c.lambda() * one, c.mu() * one)[2];
}

} // namespace softgrain::testing
