#include "contact/solve/PairProblem.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/Residual.hpp"
#include "lanes/Lanes.hpp"

namespace softgrain {

namespace {

/// Worth measuring the violation: squares of what changed in the sweep before it are at most so
/// many times that.
constexpr double changePerViolation = changePerResidual * changePerResidual;

/// x and what it was before become x + share (x - before) and x.
template <class Numbers> void extrapolateFrom(Numbers& before, Numbers& x, double share)
{
	for (std::size_t k = 0; k < x.size(); ++k) {
		const auto now = x[k];
		x[k] += share * (now - before[k]);
		before[k] = now;
	}
}

} // namespace

template <int dim> void PairProblem<dim>::resize(int contacts)
{
	contacts_ = contacts;
	stride_ = (contacts + laneWidth - 1) / laneWidth * laneWidth;
	W_.assign(contacts * stride_, 0);
	for (auto& component : velocity_)
		component.assign(stride_, 0);
	impulse_.resize(contacts);
	normal_.resize(contacts);
	for (auto* numbers : { &ownW_, &inverseW_, &friction_ })
		numbers->resize(contacts);
}

template <int dim>
void PairProblem<dim>::setContact(int contact, const Vec<dim>& normal, double bias, double friction,
				  const Vec<dim>& impulse, const Vec<dim>& velocity)
{
	normal_[contact] = normal;
	impulse_[contact] = impulse;
	friction_[contact] = friction;
	ownW_[contact] = column(contact)[contact];
	inverseW_[contact] = 1 / ownW_[contact];
	for (int a = 0; a < dim; ++a)
		velocity_[a][contact] = velocity[a] + bias * normal[a];
}

template <int dim> Vec<dim> PairProblem<dim>::solved(int contact) const
{
	Vec<dim> u;
	for (int a = 0; a < dim; ++a)
		u[a] = velocity_[a][contact];
	return solvedContact<dim>(impulse_[contact], u, normal_[contact], 0, inverseW_[contact],
				  friction_[contact]);
}

template <int dim> void PairProblem<dim>::push(int contact, const Vec<dim>& J)
{
	const double* W = column(contact);
	for (int a = 0; a < dim; ++a)
		for (int l = 0; l < stride_; l += laneWidth) {
			double* u = &velocity_[a][l];
			storeLanes(u, loadLanes(u) + J[a] * loadLanes(W + l));
		}
}

template <int dim> SweepChange PairProblem<dim>::sweep()
{
	SweepChange change;
	for (int k = 0; k < contacts_; ++k) {
		const Vec<dim> r = solved(k), J = r - impulse_[k];
		if (J.isZero(0)) continue;
		change.changed += ownW_[k] * J.squaredNorm();
		change.along += ownW_[k] * J.dot(r - impulseBefore_[k]);
		impulse_[k] = r;
		push(k, J);
	}
	return change;
}

template <int dim> double PairProblem<dim>::remaining() const
{
	double sum = 0;
	for (int k = 0; k < contacts_; ++k)
		sum += ownW_[k] * (solved(k) - impulse_[k]).squaredNorm();
	return sum;
}

template <int dim> void PairProblem<dim>::extrapolate(double share)
{
	extrapolateFrom(impulseBefore_, impulse_, share);
	for (int a = 0; a < dim; ++a)
		extrapolateFrom(velocityBefore_[a], velocity_[a], share);
}

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS int PairProblem<dim>::solve(double violation, int maxSweeps)
{
	impulseBefore_ = impulse_;
	velocityBefore_ = velocity_;
	start_ = impulse_;
	const double first = remaining();
	Extrapolation extrapolation;
	for (int sweeps = 1;; ++sweeps) {
		const SweepChange change = sweep();
		const bool promising = change.changed <= changePerViolation * violation;
		if (promising && remaining() <= violation) return sweeps;
		if (sweeps >= maxSweeps) {
			if (!(remaining() < first)) impulse_ = start_;
			return sweeps;
		}
		extrapolate(extrapolation.shareAfter(change));
	}
}

template class PairProblem<2>;
template class PairProblem<3>;

} // namespace softgrain
