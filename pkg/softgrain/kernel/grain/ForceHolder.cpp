#include "grain/ForceHolder.hpp"

#include <algorithm>

namespace softgrain {

namespace {

/// Sum of force times displacement rate over the nodes, W.
template <int dim> double power(const Batch<dim>& batch, const NodalField<dim>& velocity, int g)
{
	const Vec<dim>*f = batch.force.of(g), *v = velocity.of(g);
	double sum = 0;
	for (int I = 0; I < batch.reference->nodes(); ++I)
		sum += f[I].dot(v[I]);
	return sum;
}

} // namespace

template <int dim> void ForceHolder<dim>::setRate(int g, int steps)
{
	if (steps == of_[g].rate) return;
	slow_ += (steps > 1) - (of_[g].rate > 1);
	of_[g] = { .rate = steps };
}

/// How far ahead of the present the middle of the kicks lies, s.
template <int dim> double ForceHolder<dim>::lead(int g, const ForceSchedule& schedule) const
{
	return 0.5 * (stepsToNext(g, schedule) - 1) * schedule.dt;
}

template <int dim>
void ForceHolder<dim>::lookAhead(Batch<dim>& batch, int g, const ForceSchedule& schedule) const
{
	const double time = lead(g, schedule);
	const Vec<dim>* v = batch.v.of(g);
	Vec<dim>*x = batch.x.of(g), *present = batch.vNext.of(g);
	for (int I = 0; I < batch.reference->nodes(); ++I) {
		present[I] = x[I];
		addScaled<dim>(x[I], time, v[I]);
	}
}

template <int dim>
void ForceHolder<dim>::hold(Batch<dim>& batch, int g, const ForceSchedule& schedule)
{
	std::copy_n(batch.vNext.of(g), batch.reference->nodes(), batch.x.of(g));
	double& energy = batch.report[g].elasticEnergy;
	energy += lead(g, schedule) * power(batch, batch.v, g);
	// In the first step of all it is not known how long a step is.
	of_[g].holds = of_[g].rate > 1 && schedule.dt > 0;
	of_[g].energy = energy;
	of_[g].until = schedule.step + stepsToNext(g, schedule);
}

template <int dim> void ForceHolder<dim>::followMove(const Batch<dim>& batch, int g, double dt)
{
	if (of_[g].holds) of_[g].energy -= dt * power(batch, batch.vNext, g);
}

template <int dim>
std::vector<double> ForceHolder<dim>::numbers(const Batch<dim>& batch, int g) const
{
	const Held& held = of_[g];
	if (!held.holds && held.shorter == 0) return {};
	std::vector<double> numbers = numbersOf(held.rate, held.shorter, held.met);
	if (held.holds)
		append(numbers, held.until, held.energy, batch.report[g].stiffening,
		       batch.force.allOf(g));
	return numbers;
}

template <int dim> void ForceHolder<dim>::restoreInterval(int g, NumbersInTurn& saved)
{
	setRate(g, saved.next<int>());
	saved.take(of_[g].shorter, of_[g].met);
}

template <int dim>
void ForceHolder<dim>::restoreForces(Batch<dim>& batch, int g, NumbersInTurn& saved)
{
	of_[g].holds = true;
	saved.take(of_[g].until, of_[g].energy, batch.report[g].stiffening, batch.force.allOf(g));
}

template class ForceHolder<2>;
template class ForceHolder<3>;

} // namespace softgrain
