// A contact with rigid bodies, whose block W is no multiple of the identity:
//     W = w I + sum over its rigid bodies of (1/m I + [a]^T I^-1 [a]),
// with w of the nodes of a grain, [a] x = x cross a for the arm a of the place about the centre of
// mass. It is solved in two steps, its normal impulse first, then its tangential one at the
// velocity after that,
//     r_n <- max(0, r_n - (u_n + b)/D),     r_t <- cut(r_t - u_t/W_t, mu r_n),
// with W_t the largest eigenvalue of the tangential block, and D = W_nn, but of a contact that
// slides and that friction lifts D = W_nn + n.W r_t/r_n: its friction grows with r_n, which with
// W_nn alone would come and go in turns where mu |W_nt| > W_nn. Fixed points are exactly the
// solutions. For balls (a passes through their centres), and where bodies do not turn, one pass
// solves the contact; otherwise the sweeps do.
#pragma once

#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/Residual.hpp"
#include "contact/solve/Sweep.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

/// Largest eigenvalue of W in the line across n.
inline double largestAcross(const Mat<2>& W, const Vec<2>& n)
{
	const Vec<2> t(-n[1], n[0]);
	return t.dot(W * t);
}

/// The same in the plane across n.
inline double largestAcross(const Mat<3>& W, const Vec<3>& n)
{
	const Vec<3> s = n.unitOrthogonal(), t = n.cross(s);
	const double ss = s.dot(W * s), tt = t.dot(W * t), st = s.dot(W * t);
	const double half = 0.5 * (ss - tt);
	return 0.5 * (ss + tt) + std::sqrt(half * half + st * st);
}

template <int dim> struct TwoStepContact {
	Vec<dim> normal;   ///< unit, towards the body on which `impulse` acts
	Vec<dim> impulse;  ///< N s
	Vec<dim> ofNormal; ///< W n, 1/kg
	double Wn, Wt;     ///< W_nn and W_t, 1/kg
	double bias;       ///< b, m/s

	/// What the sweep before the last left, or, before the first, `impulse`.
	Vec<dim> impulseBefore;

	/// False if no impulse moves the place along the normal. Where none moves it across,
	/// friction is found by another W_t: the sliding velocity is what it is.
	bool setMobility(const Mat<dim>& W)
	{
		ofNormal = W * normal;
		Wn = normal.dot(ofNormal);
		Wt = largestAcross(W, normal);
		if (!(Wt > 1e-12 * Wn)) Wt = Wn;
		return Wn > 0;
	}
	/// The impulse that solves the contact at the velocity u of the present one.
	Vec<dim> solvedAt(Vec<dim> u, double friction) const
	{
		const Vec<dim>& n = normal;
		const double before = impulse.dot(n);
		const Vec<dim> across = impulse - before * n;
		const double wanted =
			before - (u.dot(n) + bias) / responseTo(before, across, friction);
		const double after = std::max(wanted, 0.); // nan stays
		if (after == 0) return Vec<dim>::Zero();
		u += (after - before) * ofNormal;
		const Vec<dim> sliding = u - u.dot(n) * n;
		const Vec<dim> r = across - sliding / Wt + after * n;
		return onCone<dim>(r, n, friction);
	}
	/// Takes the impulse that solves the contact at the velocity u, others held, and hands on
	/// by how much it changed, `push(J)`.
	template <class Push> SweepChange visit(const Vec<dim>& u, double friction, Push&& push)
	{
		const Vec<dim> r = solvedAt(u, friction);
		const Vec<dim> J = r - impulse;
		SweepChange change { 0, energy(r) };
		if (J.isZero(0)) return change;
		change.changed = energy(J);
		change.along = product(J, r - impulseBefore);
		impulse = r;
		push(J);
		return change;
	}
	/// D for a normal and a tangential impulse, 1/kg.
	double responseTo(double normal, const Vec<dim>& across, double friction) const
	{
		constexpr double rounding = 1e-9;
		const double lift = ofNormal.dot(across);
		if (normal <= 0 || !(lift > rounding * Wn * normal)) return Wn; // balls
		const bool slides = across.norm() >= (1 - rounding) * friction * normal;
		return slides ? Wn + lift / normal : Wn;
	}
	/// Sweeps begin with this impulse.
	void begin(const Vec<dim>& r) { impulse = impulseBefore = r; }
	/// Goes on from r + share (r - r_before); returns by how much.
	Vec<dim> extrapolate(double share)
	{
		const Vec<dim> J = share * (impulse - impulseBefore);
		impulseBefore = impulse;
		impulse += J;
		return J;
	}
	/// The product of the norm in which the two steps solve the contact.
	double product(const Vec<dim>& r, const Vec<dim>& s) const
	{
		return Wt * r.dot(s) + (Wn - Wt) * r.dot(normal) * s.dot(normal);
	}
	/// |r|^2 in it.
	double energy(const Vec<dim>& r) const { return product(r, r); }
	/// How far the impulse is from solving the contact at the velocity u.
	void addResidual(ResidualSum& sum, const Vec<dim>& u, double friction) const
	{
		const Vec<dim> solved = solvedAt(u, friction);
		sum.add(energy(solved - impulse), energy(impulse), energy(solved));
	}
};

} // namespace softgrain
