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
void ForceHolder<dim>::append(const Batch<dim>& batch, int g, std::vector<double>& numbers) const
{
	const Held& held = of_[g];
	if (!held.holds && held.shorter == 0) return;
	numbers.insert(numbers.end(),
		       { static_cast<double>(held.rate), static_cast<double>(held.shorter),
			 static_cast<double>(held.met) });
	if (!held.holds) return;
	numbers.push_back(static_cast<double>(held.until));
	numbers.push_back(held.energy);
	numbers.push_back(batch.report[g].stiffening);
	appendField(batch.force, g, batch.reference->nodes(), numbers);
}

template <int dim>
void ForceHolder<dim>::restore(Batch<dim>& batch, int g, const std::vector<double>& numbers)
{
	setRate(g, static_cast<int>(numbers[0]));
	Held& held = of_[g];
	held.shorter = static_cast<int>(numbers[1]);
	held.met = static_cast<long>(numbers[2]);
	held.holds = numbers.size() > intervalNumbers;
	if (!held.holds) return;
	held.until = static_cast<long>(numbers[3]);
	held.energy = numbers[4];
	batch.report[g].stiffening = numbers[5];
	setField(batch.force, g, batch.reference->nodes(), &numbers[6]);
}

template class ForceHolder<2>;
template class ForceHolder<3>;

} // namespace softgrain
