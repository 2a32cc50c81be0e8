// The classical cycle of the material point method for total-Lagrangian grains: velocities live at
// the material points, and in every step go to the nodes and back.
//     v_I = (1/m_I) sum_p m_p N_I(Xp) v_p
//     v_p <- (1 - a) (v_p + sum_I N_I(Xp) (v+_I - v_I)) + a sum_I N_I(Xp) v+_I,    a: PIC share
// Both conserve linear momentum to rounding; what else holds: doc/decisions/0005-formulations.md.
#pragma once

#include "grain/Batch.hpp"

namespace softgrain {

template <int dim> class PointVelocities {
public:
	/// Points take the nodal velocities of the batch, which are mapped back to its nodes.
	PointVelocities(Batch<dim>& batch, double picShare);

	/// From `batch.v` (v_I) and `batch.vNext` (v+_I) to the points and back into `batch.v`.
	/// Parallel over active blocks.
	void update(Batch<dim>& batch, int threads);
	/// Takes the velocities of grain `g` from the nodes.
	void takeFromNodes(const Batch<dim>& batch, int g);
	/// v_I of the block that holds grain `g`.
	void mapToNodes(Batch<dim>& batch, int g) { mapBlockToNodes(batch, batch.blockOf(g)); }

	Vec<dim> get(int g, int p) const { return v_.get(g, p); }
	void set(int g, int p, const Vec<dim>& v) { v_.set(g, p, v); }
	auto allOf(int g) { return v_.allOf(g); }
	auto allOf(int g) const { return v_.allOf(g); }

private:
	void updateBlock(Batch<dim>& batch, int block);
	void mapBlockToNodes(Batch<dim>& batch, int block);

	double picShare_;
	NodalField<dim> v_; ///< v_p, m/s
};

} // namespace softgrain
