#include "grain/CriticalTimeStep.hpp"
#include "grain/HighestFrequency.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Of an undeformed grain, over its wave speed and one over its radius.
template <int dim>
double highestFrequency(const GrainTemplate<dim>& reference, Condition condition, double poisson)
{
	GrainParameters<dim> unit;
	unit.radius = 1;
	unit.constants = { 1, poisson, 1 };
	// the batch does not outlive the template
	const std::shared_ptr<const GrainTemplate<dim>> shared(std::shared_ptr<void>(), &reference);
	const Batch<dim> batch(shared, Law::neoHookean, condition, { unit });
	return highestFrequency(batch, 0) / unit.constants.waveSpeed(condition);
}

/// The same, found once in the life of the template.
template <int dim>
double knownFrequency(const GrainTemplate<dim>& reference, Condition condition, double poisson)
{
	const auto [known, isNew] = reference.highestFrequency.try_emplace(
		{ static_cast<int>(condition), poisson }, 0.);
	if (isNew) known->second = highestFrequency(reference, condition, poisson);
	return known->second;
}

} // namespace

template <int dim>
double criticalTimeStep(const GrainTemplate<dim>& reference, Condition condition,
			const GrainParameters<dim>& grain)
{
	return criticalTimeSteps<dim>(reference, condition, { grain }).front();
}

template <int dim>
std::vector<double> criticalTimeSteps(const GrainTemplate<dim>& reference, Condition condition,
				      const std::vector<GrainParameters<dim>>& grains)
{
	std::vector<double> steps;
	for (const GrainParameters<dim>& grain : grains)
		steps.push_back(2 * grain.radius /
				(knownFrequency(reference, condition, grain.constants.poisson) *
				 grain.constants.waveSpeed(condition)));
	return steps;
}

template <int dim> void findIsochoricShares(Batch<dim>& batch)
{
	const GrainTemplate<dim>& reference = *batch.reference;
	if (reference.pressureSpace.empty()) return;
	for (int g = 0; g < batch.grains(); ++g) {
		const ElasticConstants& own = batch.grain[g].constants;
		const double ratio = knownFrequency(reference, batch.condition, 0.) /
				     knownFrequency(reference, batch.condition, own.poisson);
		const double stiffness = 2 * own.mu() / (own.lambda() + 2 * own.mu());
		batch.isochoricShare[g] = std::min(1., stiffness * ratio * ratio);
	}
}

double dampedTimeStep(double undamped, const Damping& damping, double stiffening,
		      double rateStiffening)
{
	const double plain = undamped / std::sqrt(stiffening);
	if (!damping.acts()) return plain;
	// with the exp of the longer, undamped step: on the safe side
	const double right = 0.5 * (1 + std::exp(-damping.mass * plain)) * undamped * undamped;
	const double rate = damping.stiffness * rateStiffening;
	return right / (rate + std::sqrt(rate * rate + stiffening * right));
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template double criticalTimeStep<dim>(const GrainTemplate<dim>&, Condition,                \
					      const GrainParameters<dim>&);                        \
	template std::vector<double> criticalTimeSteps<dim>(                                       \
		const GrainTemplate<dim>&, Condition, const std::vector<GrainParameters<dim>>&);   \
	template void findIsochoricShares<dim>(Batch<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
