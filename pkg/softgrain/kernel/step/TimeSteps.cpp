// Critical steps of the grains of a system, which of them are measured, and steps of their own.
#include "grain/CriticalTimeStep.hpp"
#include "step/System.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace softgrain {

/// Critical step of a grain with its damping over its rate, s.
template <int dim>
double System<dim>::timeStepOf(int g, double stiffening, double rateStiffening) const
{
	const GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	return dampedTimeStep(set.criticalTimeStep(k), set.parameters(k).damping, stiffening,
			      rateStiffening) /
	       rate_[g];
}

template <int dim> double System<dim>::presentTimeStepOf(int g) const
{
	const GrainSet<dim>& set = setOf(g);
	const int k = indexInSet(g);
	return timeStepOf(g, set.stiffening(k), set.rateStiffening(k));
}

/// (All grains that have to be measured are so at once: who they are does not depend on threads.)
template <int dim> double System<dim>::deformedTimeStep(double enough, int threads)
{
	const double ofOthers = std::min(undeformedTimeStep_, sleepersTimeStep_);
	double shortest = ofOthers, known = std::min(enough, ofOthers);
	std::vector<std::pair<int, double>> due; // grains, and their steps before
	for (int g : active_) {
		const double own = presentTimeStepOf(g);
		shortest = std::min(shortest, own);
		if (own >= known) continue;
		if (setOf(g).mayMeasureStiffening(indexInSet(g)))
			due.push_back({ g, own });
		else
			known = own;
	}
	std::erase_if(due, [known](const auto& grain) { return grain.second >= known; });
	if (due.empty()) return shortest;
	const int count = static_cast<int>(due.size());
	long points = 0;
#pragma omp parallel for schedule(dynamic) num_threads(threads) reduction(+ : points) if (count > 1)
	for (int i = 0; i < count; ++i) {
		const int g = due[i].first;
		const int forces = setOf(g).measureStiffening(indexInSet(g), rate_[g] * enough);
		points += static_cast<long>(forces) * setOf(g).reference().points();
	}
	measuredPoints_ += points;
	shortest = ofOthers;
	for (int g : active_)
		shortest = std::min(shortest, presentTimeStepOf(g));
	return shortest;
}

template <int dim> double System<dim>::presentCriticalTimeStep(double enough, int threads)
{
	if (continuation_.bondRate == 0) return deformedTimeStep(enough, threads);
	// with the bonds T becomes T / sqrt(1 + T^2 w^2 / 4)
	auto quarter = [this](double T) { return 0.25 * T * T * continuation_.bondRate; };
	const double left = 1 - quarter(enough);
	const double infinity = std::numeric_limits<double>::infinity();
	const double ofGrains =
		deformedTimeStep(left > 0 ? enough / std::sqrt(left) : infinity, threads);
	return ofGrains / std::sqrt(1 + quarter(ofGrains));
}

template <int dim> void System<dim>::setMultirate(bool on)
{
	if (ratesChosen_ && on == multirate_) return;
	multirate_ = on;
	ratesChosen_ = true;
	rate_.assign(grains(), 1);
	if (on) {
		std::vector<double> timeSteps;
		for (int g = 0; g < grains(); ++g)
			timeSteps.push_back(timeStepOf(g, 1, 1));
		rate_ = ratesOf(timeSteps);
	}
	for (int g = 0; g < grains(); ++g)
		setOf(g).setRate(indexInSet(g), rate_[g]);
	for (const auto& set : sets_)
		set->arrangeGrains();
	undeformedTimeStep_ = std::numeric_limits<double>::infinity();
	for (int g = 0; g < grains(); ++g)
		undeformedTimeStep_ = std::min(undeformedTimeStep_, timeStepOf(g, 1, 1));
	forcesFresh_ = false;
}

/// Rates of grains with these critical steps: each divides the next, so that slow grains are
/// computed together.
template <int dim> std::vector<int> System<dim>::ratesOf(const std::vector<double>& timeSteps) const
{
	constexpr double rounding = 1e-9; // ten times as long is ten times, not nine
	std::vector<int> ascending(grains());
	std::iota(ascending.begin(), ascending.end(), 0);
	std::stable_sort(ascending.begin(), ascending.end(),
			 [&](int a, int b) { return timeSteps[a] < timeSteps[b]; });
	std::vector<int> rates(grains(), 1);
	int rate = 1;
	for (int g : ascending) {
		if (!setOf(g).mayHoldForces()) continue;
		const double shortest = timeSteps[ascending.front()];
		rate *= std::max(1,
				 static_cast<int>((1 + rounding) * timeSteps[g] / shortest / rate));
		rates[g] = rate;
	}
	return rates;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template double System<dim>::timeStepOf(int, double, double) const;                        \
	template double System<dim>::presentTimeStepOf(int) const;                                 \
	template double System<dim>::presentCriticalTimeStep(double, int);                         \
	template void System<dim>::setMultirate(bool);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
