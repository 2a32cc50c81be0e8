// A sweep of nonlinear Gauss-Seidel over the contacts of a pair. (Pairs of grains have one of their
// own, PairSolver::sweep.)
#pragma once

#include <algorithm>
#include <vector>

namespace softgrain {

/// What a sweep did, in the residual's norm, kg m^2/s^2.
struct SweepChange {
	double changed = 0; ///< sum W |dr|^2
	double total = 0;   ///< sum W |r|^2

	SweepChange& operator+=(const SweepChange& other)
	{
		changed += other.changed;
		total += other.total;
		return *this;
	}
};

enum class SweepOrder { forwards, backwards };

/// Solves each of the constraints once, the others held: solved(c) is the impulse that solves c,
/// energy(c, r) the square of r in the residual's norm, apply(c, J) hands a change on.
template <class Constraint, class Solved, class Energy, class Apply>
SweepChange sweepOver(std::vector<Constraint>& constraints, SweepOrder order, Solved&& solved,
		      Energy&& energy, Apply&& apply)
{
	SweepChange sum;
	auto visit = [&](Constraint& c) {
		const auto r = solved(c);
		const auto J = (r - c.impulse).eval();
		sum.total += energy(c, r);
		if (J.isZero(0)) return;
		sum.changed += energy(c, J);
		c.impulse = r;
		apply(c, J);
	};
	if (order == SweepOrder::forwards)
		std::for_each(constraints.begin(), constraints.end(), visit);
	else
		std::for_each(constraints.rbegin(), constraints.rend(), visit);
	return sum;
}

} // namespace softgrain
