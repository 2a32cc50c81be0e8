// One material point at a time, for tests of laws that work on lanes.
#pragma once

#include "Vector.hpp"
#include "material/NeoHookean.hpp"

namespace softgrain::testing {

/// The three conditions as types, for TEMPLATE_TEST_CASE.
struct PlaneStrain {
	static constexpr int dim = 2;
	static constexpr Condition condition = Condition::planeStrain;
};
struct PlaneStress {
	static constexpr int dim = 2;
	static constexpr Condition condition = Condition::planeStress;
};
struct Solid {
	static constexpr int dim = 3;
	static constexpr Condition condition = Condition::solid;
};

template <int dim> struct PointResult {
	Mat<dim> P;
	double J, energy, stiffening;
};

template <int dim>
void setLane(PointLanes<dim>& point, LameConstants& lame, int lane, const Mat<dim>& F,
	     const ElasticConstants& c)
{
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			point.F[a][b][lane] = F(a, b);
	lame.set(lane, c, 0);
}

template <int dim> PointResult<dim> getLane(const PointLanes<dim>& point, int lane)
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
template <int dim> struct OneAmongLanes {
	PointLanes<dim> point;
	LameConstants lame;

	OneAmongLanes(const Mat<dim>& F, const ElasticConstants& c, int lane)
	{
		for (int l = 0; l < laneWidth; ++l)
			setLane<dim>(point, lame, l, l == lane ? F : Mat<dim>(Mat<dim>::Identity()),
				     c);
	}
};

/// Response of the law to F.
template <class Case>
PointResult<Case::dim> respond(const Mat<Case::dim>& F, const ElasticConstants& c, int lane = 3)
{
	OneAmongLanes<Case::dim> one(F, c, lane);
	NeoHookean<Case::dim, Case::condition>::evaluate(one.point, one.lame);
	return getLane<Case::dim>(one.point, lane);
}

/// The same with the stiffening seen by a grid fixed in space.
template <class Case>
PointResult<Case::dim> respondInSpace(const Mat<Case::dim>& F, const ElasticConstants& c)
{
	OneAmongLanes<Case::dim> one(F, c, 3);
	NeoHookean<Case::dim, Case::condition>::evaluate(one.point, one.lame);
	NeoHookean<Case::dim, Case::condition>::stiffenInSpace(one.point, one.lame);
	return getLane<Case::dim>(one.point, 3);
}

/// ln F33 in plane stress.
inline double thicknessStrain(double J2, const ElasticConstants& c)
{
	const Lanes one = Lanes {} + 1;
	return detail::thicknessStrain<WholeLanes>(std::log(J2) * one, c.lambda() * one,
						   c.mu() * one)[5];
}

} // namespace softgrain::testing
