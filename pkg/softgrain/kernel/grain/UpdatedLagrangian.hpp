// The updated-Lagrangian MPM as a set of grains: a background grid fixed in space, one for each
// grain, so that grains meet by contact only. The state lives at the material points (x_p, v_p,
// F_p) and contact nodes (x_s). In every step, with shape functions of the present positions:
//     m_I = sum_p m_p N_I(x_p),      v_I = (1/m_I) sum_p m_p N_I(x_p) v_p
//     f_I = - sum_p Vp0 tau_p grad N_I(x_p),      tau = P F^T
//     v+_I = v_I + kick (f_I/m_I + load) + contact
//     v_p <- (1 - a) (v_p + sum_I N_I (v+_I - v_I)) + a sum_I N_I v+_I,      a: PIC share
//     x_p += dt sum_I N_I v+_I,   F_p <- (1 + dt sum_I v+_I (x) grad N_I) F_p,   x_s as x_p
// (stress updated last). Choices and their measurements: doc/decisions/0005-formulations.md.
#pragma once

#include "grain/GrainSet.hpp"
#include "grain/UpdatedGrain.hpp"

#include <algorithm>
#include <memory>

namespace softgrain {

template <int dim> class UpdatedLagrangian : public GrainSet<dim> {
public:
	/// Undeformed grains at their origins. Throws std::invalid_argument as Batch does.
	UpdatedLagrangian(std::shared_ptr<const GrainTemplate<dim>> reference, Law law,
			  Condition condition, const std::vector<GrainParameters<dim>>& grains,
			  double picShare);

	int grains() const override { return static_cast<int>(grain_.size()); }
	const GrainTemplate<dim>& reference() const override { return *reference_; }
	Condition condition() const override { return condition_; }
	const GrainParameters<dim>& parameters(int g) const override { return parameters_[g]; }
	double criticalTimeStep(int g) const override { return criticalTimeStep_[g]; }

	int updateForces(const ForceSchedule& schedule) override;
	const BulkReport& report(int g) const override { return grain_[g].report; }
	double stiffening(int g) const override
	{
		return std::max(1., grain_[g].report.stiffening);
	}
	void predictVelocities(int g, double kick, const BodyLoad<dim>& load) override;
	ContactMobility<dim> contactMobility(int g) override;
	void contactVelocities(int g, std::vector<Vec<dim>>& at) const override;
	void contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const override;
	void applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse) override;
	bool hasFiniteVelocities(int g) const override;
	double kineticEnergy(int g) const override;
	void addLoadWork(int g, double kick, const BodyLoad<dim>& load, double& before,
			 double& after) const override;
	void move(int g, double dt) override;
	VectorRange<dim> contactVelocityRange(int g) const override;
	void contactPositions(int g, std::vector<Vec<dim>>& at) const override;

	WholeGrain<dim> whole(int g) const override;
	double presentKineticEnergy(int g) const override;
	std::vector<PointResponse<dim>> points(int g) const override;
	/// Of the material points, which carry the state.
	std::vector<Vec<dim>> nodePositions(int g) const override;
	std::vector<Vec<dim>> nodeVelocities(int g) const override;
	void place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
		   const Mat<dim>& spin) override;
	void moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
			 const Vec<dim>& velocity, const Mat<dim>& spin) override;
	GrainState state(int g) const override;
	void setState(int g, const GrainState& state) override;

private:
	int pointCount() const { return reference_->points(); }
	Vec<dim> pointAt(int g, int p) const;
	Vec<dim> velocityAt(int g, int p) const;
	void setPoint(int g, int p, const Vec<dim>& x, const Vec<dim>& v, const Mat<dim>& F);
	Mat<dim> gradientAt(int g, int p) const;
	Vec<dim> nodeAt(int g, int node) const;
	void fillUp(int g);
	bool mapToGrid(int g);

	std::shared_ptr<const GrainTemplate<dim>> reference_;
	Law law_;
	Condition condition_;
	std::vector<GrainParameters<dim>> parameters_;
	std::vector<double> criticalTimeStep_; ///< of the undeformed grains, s
	std::vector<UpdatedGrain<dim>> grain_;
	double picShare_;
	double width_ = 0; ///< of the undeformed grain, in radii
};

} // namespace softgrain
