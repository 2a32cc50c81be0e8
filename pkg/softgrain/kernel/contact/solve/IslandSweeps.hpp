// The sweeps of one island of pairs (SweepPlan.hpp). Each island is swept until its own residual is
// within the tolerance: what lies elsewhere in a scene neither ends its sweeps nor goes on with
// them.
#pragma once

#include "contact/solve/Residual.hpp"
#include "contact/solve/Sweep.hpp"

#include <algorithm>
#include <limits>

namespace softgrain {

struct IslandSweeps {
	// what is in it
	long contacts = 0;
	bool solvesPairsAlone = false; ///< some are of grains, or of a grain and a plane
	bool movesRigidBodies = false; ///< impulses of some pair do
	bool isDriven = false;         ///< HeldMotion::isFelt
	double exchangedAtFirst = 0;   ///< by the impulses of the last step, with rigid bodies, J
	double firstShare = 1;         ///< of these that sweeps begin with

	// what they came to
	int sweeps = 0;
	long visits = 0;                                           ///< of contacts
	SweepChange change;                                        ///< of the last one
	double residual = std::numeric_limits<double>::infinity(); ///< when last measured
	double strictness = 1;                                     ///< ResidualSum::strictness
	double violation = 0;                                      ///< ResidualSum::violation

	// how they go on
	bool takesPart = false;    ///< in the pass at hand
	double residualBefore = 0; ///< this turn
	int sweepsPerTurn = 1;     ///< over all, until pairs are solved alone again
	int sweepsThisTurn = 0;    ///< since they were
	Extrapolation extrapolation;
	double extrapolationShare = 0; ///< Extrapolation::shareAfter the last sweep

	/// Nothing that was measured before the first sweep counts.
	void beginSweeps()
	{
		residual = std::numeric_limits<double>::infinity();
		strictness = 1;
	}
	/// ResidualSum::countExchanged, and extrapolated sweeps.
	bool countsExchange() const { return movesRigidBodies && !isDriven; }
	void measure(const ResidualSum& sum)
	{
		residual = sum.value();
		strictness = sum.strictness();
		violation = sum.violation();
	}
	void count(int times)
	{
		sweeps += times;
		visits += times * contacts;
	}
	/// Whether sweeps are at an end: converged, capped, or no numbers any more.
	bool isDone(double tolerance, int cap) const
	{
		return !(residual > tolerance) || sweeps == cap;
	}
	/// Whether the residual may be within the tolerance, and is worth measuring.
	bool isPromising(double tolerance, int cap) const
	{
		return sweeps == cap ||
		       change.share() <= changePerResidual * strictness * tolerance;
	}
	/// After pairs were solved alone. Where that leaves more of the residual than half, pairs
	/// feel each other (as coarse grains and those with corners do): all contacts are swept
	/// twice as often before it is tried again.
	void beginTurn()
	{
		constexpr double fallAlone = 0.5;
		sweepsPerTurn = residual < fallAlone * residualBefore ? 1 : 2 * sweepsPerTurn;
	}
	/// After a sweep over all contacts.
	void noteSweep()
	{
		count(1);
		extrapolationShare = extrapolation.shareAfter(change);
		++sweepsThisTurn;
	}
	bool isTurnOver() const { return sweepsThisTurn == sweepsPerTurn; }
};

} // namespace softgrain
