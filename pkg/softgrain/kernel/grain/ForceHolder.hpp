// Grains whose forces act for several steps. A force that acts from step k to step k + m - 1 is
// that of the positions which the grain reaches in the middle of these kicks, if it flies on as it
// does:
//     f = f(x + a v),      a = (m - 1) dt/2
// Over the m steps together this is a drift by a, a kick by m dt and a drift by the rest: the step
// of a grain that steps by m dt, with the same critical step and the same invariants, but its
// forces come smoothly, as contact needs them (doc/decisions/0018-multirate.md).
#pragma once

#include "Numbers.hpp"
#include "grain/GrainSet.hpp"

namespace softgrain {

template <int dim> class ForceHolder {
public:
	explicit ForceHolder(int grains)
		: of_(grains)
	{
	}

	int rate(int g) const { return of_[g].rate; }
	void setRate(int g, int steps);
	/// Steps from one computation to the next, for now; a new one counts from the next
	/// computation on.
	ForceInterval interval(int g) const
	{
		return { of_[g].shorter ? of_[g].shorter : of_[g].rate, of_[g].met };
	}
	void setInterval(int g, const ForceInterval& interval)
	{
		of_[g].shorter = interval.steps < of_[g].rate ? interval.steps : 0;
		of_[g].met = interval.met;
	}
	/// Whether some grain is not computed in every step.
	bool isNeeded() const { return slow_ > 0; }
	bool holds(int g) const { return of_[g].holds; }
	void forget(int g) { of_[g].holds = false; }

	bool isDue(int g, const ForceSchedule& schedule) const
	{
		return !of_[g].holds || schedule.step >= of_[g].until;
	}
	/// Moves the nodes to where the forces are wanted; those of the present wait in
	/// `batch.vNext`, which nobody needs before the next velocities.
	void lookAhead(Batch<dim>& batch, int g, const ForceSchedule& schedule) const;
	/// Moves them back and keeps the forces found.
	void hold(Batch<dim>& batch, int g, const ForceSchedule& schedule);
	/// Elastic energy of the present positions as far as the force held tells, into the report.
	void report(Batch<dim>& batch, int g) const
	{
		batch.report[g].elasticEnergy = of_[g].energy;
	}
	/// What a move by dt with `batch.vNext` makes of it.
	void followMove(const Batch<dim>& batch, int g, double dt);

	/// What is held, for saving, and back: nothing, how often a grain is computed if that is
	/// not by its rate (`intervalNumbers`), or so many numbers. It is of use with the same rate
	/// only: `setRate` forgets it with another.
	static int numberCount(const Batch<dim>& batch)
	{
		return intervalNumbers + 3 + batch.reference->nodes() * dim;
	}
	static constexpr int intervalNumbers = 3;
	std::vector<double> numbers(const Batch<dim>& batch, int g) const;
	void restoreInterval(int g, NumbersInTurn& saved);
	void restoreForces(Batch<dim>& batch, int g, NumbersInTurn& saved);

private:
	struct Held {
		int rate = 1;    ///< steps between computations
		int shorter = 0; ///< the same if it has met stiffer grains; 0: its rate
		long met = 0;    ///< step in which it did so last
		bool holds = false;
		long until = 0;    ///< step before which the force acts
		double energy = 0; ///< elastic, of the present positions, to first order, J
	};
	/// Steps for which a force found now is to act.
	int stepsToNext(int g, const ForceSchedule& schedule) const
	{
		const int steps = interval(g).steps;
		return steps - static_cast<int>(schedule.step % steps);
	}
	double lead(int g, const ForceSchedule& schedule) const;

	std::vector<Held> of_;
	int slow_ = 0; ///< grains with a rate above 1
};

} // namespace softgrain
