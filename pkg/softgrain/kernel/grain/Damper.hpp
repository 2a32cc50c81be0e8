// Damping of total-Lagrangian grains, as impulses on the background nodes beside those of the
// internal forces. With alpha = Damping::mass, beta = Damping::stiffness and k the kick,
//     j_I = -(1 - exp(-alpha k)) m_I (v_I - V - omega x (x_I - x_c)) - k sum_p Vp0 F_p S_p G_I
//     S   = beta (lambda' tr(E') 1 + 2 mu E'),     E' = sym(F^T F'),  F' = sum_I v_I (x) G_I
// V, omega: rigid motion with the momenta of the grain, so that both terms leave momenta as they
// are. All velocities are those before t_n. Why so: doc/decisions/0016-quasi-static.md.
#pragma once

#include "Numbers.hpp"
#include "grain/Batch.hpp"

namespace softgrain {

template <int dim> class Damper {
public:
	explicit Damper(const Batch<dim>& batch);

	static bool isNeeded(const Batch<dim>& batch);
	bool acts(const Batch<dim>& batch, int g) const { return batch.grain[g].damping.acts(); }

	/// Forces of the second term, from positions and velocities of the batch. Parallel over
	/// blocks.
	void updateForces(const Batch<dim>& batch, int threads);
	/// Largest squared stretch of the grain at the last `updateForces`, with which its damping
	/// rates grow; 1 where no grain of its block has stiffness damping.
	double rateStiffening(int g) const { return rateStiffening_[g]; }

	/// A grain that wakes has no forces of this kind: it did not move. (While it sleeps nobody
	/// asks for those of the step in which it fell asleep, once that was balanced.)
	void stop(int g);
	/// A grain that is undeformed damps as at the start, and has no forces of this kind.
	void forget(int g);
	void setRateStiffening(int g, double value) { rateStiffening_[g] = value; }

	/// What the last `updateForces` found of a grain, for saving, and back; so many numbers.
	int numberCount() const { return 1 + nodes_ * dim; }
	std::vector<double> numbers(int g) const;
	void restore(int g, NumbersInTurn& saved);

	/// Adds j_I/m_I to `batch.vNext`.
	void addImpulses(Batch<dim>& batch, int g, double kick) const;
	/// Adds what these impulses dissipate, the halves with the velocities before and after t_n.
	/// Before the grain moves.
	void addLoss(const Batch<dim>& batch, int g, double kick, double& before,
		     double& after) const;

private:
	int nodes_;
	NodalField<dim> force_; ///< of the second term, N (2D: N/m)
	std::vector<double> rateStiffening_;
};

} // namespace softgrain
