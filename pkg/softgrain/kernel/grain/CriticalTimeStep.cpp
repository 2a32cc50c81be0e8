#include "grain/CriticalTimeStep.hpp"

#include "grain/InternalForce.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace softgrain {

namespace {

/// Of the node that moves most, in differences of forces, over the radius.
constexpr double displacement = 1e-6;

/// M^-1/2 K M^-1/2 of a grain in its present shape: symmetric, its eigenvalues are squares of
/// angular frequencies.
template <int dim> class Dynamics {
public:
	Dynamics(const Batch<dim>& batch, int g)
		: grain_(batch.reference, batch.law, batch.condition, { batch.grain[g] })
	{
		std::copy_n(batch.x.of(g), nodes(), grain_.x.of(0));
		computeInternalForce(grain_, 1);
		x_ = grain_.x;
		force_ = grain_.force;
	}
	int size() const { return nodes() * dim; }
	Eigen::VectorXd operator()(const Eigen::VectorXd& q)
	{
		Eigen::VectorXd u(size());
		for (int i = 0; i < size(); ++i)
			u[i] = q[i] / rootOfMass(i);
		const double step = displacement * grain_.grain[0].radius /
				    u.template lpNorm<Eigen::Infinity>();
		for (int I = 0; I < nodes(); ++I)
			grain_.x.set(0, I, x_.get(0, I) + step * u.template segment<dim>(I * dim));
		computeInternalForce(grain_, 1);
		Eigen::VectorXd result(size());
		for (int i = 0; i < size(); ++i)
			result[i] = component(force_, i) - component(grain_.force, i);
		for (int i = 0; i < size(); ++i)
			result[i] /= step * rootOfMass(i);
		return result;
	}

private:
	int nodes() const { return grain_.reference->nodes(); }
	double rootOfMass(int i) const { return std::sqrt(grain_.nodeMass(0, i / dim)); }
	static double component(const NodalField<dim>& field, int i)
	{
		return field.get(0, i / dim)[i % dim];
	}

	Batch<dim> grain_; ///< alone
	NodalField<dim> x_, force_;
};

/// Fixed: the same grain gives the same time step.
Eigen::VectorXd randomDirection(int size)
{
	std::mt19937 generator(1);
	Eigen::VectorXd q = Eigen::VectorXd::Zero(size);
	for (double& number : q)
		number = 2. * generator() / static_cast<double>(std::mt19937::max()) - 1;
	return q.normalized();
}

template <int dim> double largestEigenvalue(Dynamics<dim> dynamics, int iterations)
{
	const int most = std::min(iterations, dynamics.size());
	Eigen::VectorXd q = randomDirection(dynamics.size()), before = q;
	Eigen::VectorXd diagonal(most), beside(most); // of the tridiagonal matrix
	int found = 0;
	while (found < most) {
		Eigen::VectorXd next = dynamics(q);
		diagonal[found] = next.dot(q);
		next -= diagonal[found] * q;
		if (found > 0) next -= beside[found - 1] * before;
		beside[found] = next.norm();
		++found;
		if (beside[found - 1] == 0) break;
		before = q;
		q = next / beside[found - 1];
	}
	Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
	solver.computeFromTridiagonal(diagonal.head(found), beside.head(found - 1),
				      Eigen::EigenvaluesOnly);
	return solver.eigenvalues()[found - 1];
}

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

} // namespace

template <int dim> double highestFrequency(const Batch<dim>& batch, int g, int iterations)
{
	return 1.01 * std::sqrt(largestEigenvalue(Dynamics<dim>(batch, g), iterations));
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
	template double highestFrequency<dim>(const Batch<dim>&, int, int);                        \
	template double criticalTimeStep<dim>(const GrainTemplate<dim>&, Condition,                \
					      const GrainParameters<dim>&);                        \
	template std::vector<double> criticalTimeSteps<dim>(                                       \
		const GrainTemplate<dim>&, Condition, const std::vector<GrainParameters<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
