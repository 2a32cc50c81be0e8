#include "grain/CriticalTimeStep.hpp"

#include "grain/InternalForce.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace softgrain {

namespace {

/// Of Lanczos' iteration: the square of the frequency is then within 0.2 %, 1.6 % and 6.5 % from
/// below (doc/decisions/0003-time-step.md). Times these it
/// has what it may lack, and a little more.
constexpr int exactIterations = 40, quickIterations = 24, earlyIterations = 8;
constexpr double raiseConverged = 1.01, raiseEarly = 1.04;

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
		x_ = numbersOf(grain_.x);
		force_ = numbersOf(grain_.force);
		rootOfMobility_.resize(size());
		for (int i = 0; i < size(); ++i)
			rootOfMobility_[i] = 1 / std::sqrt(grain_.nodeMass(0, i / dim));
	}
	int size() const { return nodes() * dim; }
	Eigen::VectorXd operator()(const Eigen::VectorXd& q)
	{
		const Eigen::ArrayXd u = q.array() * rootOfMobility_;
		const double step = displacement * grain_.grain[0].radius / u.abs().maxCoeff();
		numbersOf(grain_.x) = x_ + step * u;
		computeInternalForce(grain_, 1);
		return (force_ - numbersOf(grain_.force)) / step * rootOfMobility_;
	}

private:
	int nodes() const { return grain_.reference->nodes(); }
	/// Of all nodes, component by component.
	Eigen::Map<Eigen::ArrayXd> numbersOf(NodalField<dim>& field)
	{
		return { field.of(0)->data(), size() };
	}

	Batch<dim> grain_; ///< alone
	Eigen::ArrayXd x_, force_, rootOfMobility_;
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

/// Largest eigenvalue, from below.
template <int dim> class Lanczos {
public:
	Lanczos(const Batch<dim>& batch, int g, int most)
		: dynamics_(batch, g)
		, q_(randomDirection(dynamics_.size()))
		, before_(q_)
		, diagonal_(most)
		, beside_(most)
	{
	}
	/// Goes on until there are so many iterations, at most as many as were announced.
	double iterate(int iterations)
	{
		const int most = std::min(iterations, dynamics_.size());
		while (found_ < most && !isExact()) {
			Eigen::VectorXd next = dynamics_(q_);
			diagonal_[found_] = next.dot(q_);
			next -= diagonal_[found_] * q_;
			if (found_ > 0) next -= beside_[found_ - 1] * before_;
			beside_[found_] = next.norm();
			++found_;
			before_ = q_;
			q_ = next / beside_[found_ - 1];
		}
		Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
		solver.computeFromTridiagonal(diagonal_.head(found_), beside_.head(found_ - 1),
					      Eigen::EigenvaluesOnly);
		return solver.eigenvalues()[found_ - 1];
	}

private:
	bool isExact() const { return found_ > 0 && beside_[found_ - 1] == 0; }

	Dynamics<dim> dynamics_;
	Eigen::VectorXd q_, before_;
	Eigen::VectorXd diagonal_, beside_; ///< of the tridiagonal matrix
	int found_ = 0;
};

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

template <int dim> double highestFrequency(const Batch<dim>& batch, int g)
{
	return raiseConverged *
	       std::sqrt(Lanczos<dim>(batch, g, exactIterations).iterate(exactIterations));
}

template <int dim>
MeasuredFrequency highestFrequency(const Batch<dim>& batch, int g,
				   const std::function<bool(double)>& suffices)
{
	Lanczos<dim> lanczos(batch, g, quickIterations);
	const double early = raiseEarly * std::sqrt(lanczos.iterate(earlyIterations));
	if (suffices(early)) return { early, earlyIterations };
	return { raiseConverged * std::sqrt(lanczos.iterate(quickIterations)), quickIterations };
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
	template double highestFrequency<dim>(const Batch<dim>&, int);                             \
	template MeasuredFrequency highestFrequency<dim>(const Batch<dim>&, int,                   \
							 const std::function<bool(double)>&);      \
	template double criticalTimeStep<dim>(const GrainTemplate<dim>&, Condition,                \
					      const GrainParameters<dim>&);                        \
	template std::vector<double> criticalTimeSteps<dim>(                                       \
		const GrainTemplate<dim>&, Condition, const std::vector<GrainParameters<dim>>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
