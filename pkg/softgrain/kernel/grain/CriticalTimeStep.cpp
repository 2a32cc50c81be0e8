#include "grain/CriticalTimeStep.hpp"

#include <cmath>
#include <random>

namespace softgrain {

namespace {

/// M^-1 K u of the template with small-strain isotropic elasticity, lambda + 2 mu = 1.
template <int dim>
std::vector<Vec<dim>> accelerations(const GrainTemplate<dim>& reference, double lambda, double mu,
				    const std::vector<Vec<dim>>& u)
{
	const auto& shapes = reference.pointShapes;
	std::vector<Vec<dim>> result(u.size(), Vec<dim>::Zero());
	std::vector<Mat<dim>> gradients(reference.points(), Mat<dim>::Zero());
	std::vector<double> theta(reference.points());
	for (int p = 0; p < reference.points(); ++p) {
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			gradients[p] += u[shapes.column[k]] * shapes.value[k].G.transpose();
		theta[p] = gradients[p].trace();
	}
	if (!reference.pressureSpace.empty())
		project<1>(reference.pressureSpace, reference.pointVolume, theta.data());
	for (int p = 0; p < reference.points(); ++p) {
		const Mat<dim> stress = mu * (gradients[p] + gradients[p].transpose()) +
					lambda * theta[p] * Mat<dim>::Identity();
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			result[shapes.column[k]] +=
				reference.pointVolume[p] * stress * shapes.value[k].G;
	}
	for (std::size_t I = 0; I < u.size(); ++I)
		result[I] /= reference.nodeMass[I];
	return result;
}

/// Euclidean in the mass metric, in which M^-1 K is symmetric.
template <int dim>
double dot(const GrainTemplate<dim>& reference, const std::vector<Vec<dim>>& u,
	   const std::vector<Vec<dim>>& w)
{
	double sum = 0;
	for (std::size_t I = 0; I < u.size(); ++I)
		sum += reference.nodeMass[I] * u[I].dot(w[I]);
	return sum;
}

} // namespace

template <int dim>
double highestFrequency(const GrainTemplate<dim>& reference, Condition condition, double poisson)
{
	const ElasticConstants unit { 1, poisson, 1 };
	const double modulus = unit.effectiveLambda(condition) + 2 * unit.mu();
	const double lambda = unit.effectiveLambda(condition) / modulus, mu = unit.mu() / modulus;

	std::mt19937 generator(1); // fixed: the same recipe gives the same time step
	std::vector<Vec<dim>> u(reference.nodes());
	for (Vec<dim>& value : u)
		for (int a = 0; a < dim; ++a)
			value[a] = 2. * generator() / static_cast<double>(std::mt19937::max()) - 1;
	double square = 0;
	for (int k = 0; k < 500; ++k) {
		const double norm = std::sqrt(dot(reference, u, u));
		for (Vec<dim>& value : u)
			value /= norm;
		const auto next = accelerations(reference, lambda, mu, u);
		const double quotient = dot(reference, u, next);
		const bool settled = std::abs(quotient - square) < 1e-6 * quotient;
		square = quotient;
		u = next;
		if (settled) break;
	}
	return 1.01 * std::sqrt(square);
}

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
	for (const GrainParameters<dim>& grain : grains) {
		const auto [known, isNew] = reference.highestFrequency.try_emplace(
			{ static_cast<int>(condition), grain.constants.poisson }, 0.);
		if (isNew)
			known->second =
				highestFrequency(reference, condition, grain.constants.poisson);
		steps.push_back(2 * grain.radius /
				(known->second * grain.constants.waveSpeed(condition)));
	}
	return steps;
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
	template double highestFrequency<dim>(const GrainTemplate<dim>&, Condition, double);       \
	template double criticalTimeStep<dim>(const GrainTemplate<dim>&, Condition,                \
					      const GrainParameters<dim>&);                        \
	template std::vector<double> criticalTimeSteps<dim>(                                       \
		const GrainTemplate<dim>&, Condition, const std::vector<GrainParameters<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
