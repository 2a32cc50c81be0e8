// The total-Lagrangian MPM as a set of grains: shape functions and masses never change, so the
// nodal positions and velocities of a batch are the state (method: section 2). With
// VelocityUpdate::flip the velocities live at the material points instead; positions and
// deformation gradients are then computed alike, because points move as the nodes make them.
#pragma once

#include "grain/Damper.hpp"
#include "grain/ForceHolder.hpp"
#include "grain/GrainSet.hpp"
#include "grain/PointVelocities.hpp"
#include "grain/RestWatch.hpp"
#include "grain/RigidMotion.hpp"
#include "grain/Stiffening.hpp"

#include <optional>

namespace softgrain {

template <int dim> class TotalLagrangian : public GrainSet<dim> {
public:
	/// Grains in the state of the batch.
	explicit TotalLagrangian(Batch<dim> batch, const Scheme& scheme = {});

	/// Its nodes are stale where a grain moves rigidly.
	Batch<dim>& batch() { return batch_; }
	const Batch<dim>& batch() const { return batch_; }

	int grains() const override { return batch_.grains(); }
	const GrainTemplate<dim>& reference() const override { return *batch_.reference; }
	Condition condition() const override { return batch_.condition; }
	const GrainParameters<dim>& parameters(int g) const override { return batch_.grain[g]; }
	double criticalTimeStep(int g) const override { return criticalTimeStep_[g]; }

	double stiffening(int g) const override { return stiffening_[g].value(batch_.report[g]); }
	bool mayMeasureStiffening(int g) const override
	{
		return stiffening_[g].isDue(batch_.report[g]);
	}
	int measureStiffening(const std::vector<DueMeasurement>& due) override;

	bool isRigid(int g) const override { return isRigid_[g]; }
	bool mayMoveRigidly(int g) const override;
	void beginRigidMotion(int g) override;
	void endRigidMotion(int g) override;
	bool isMotionless(int g) const override
	{
		return isRigid_[g] && rigid_[g].velocity.isZero(0) && rigid_[g].momentum.isZero(0);
	}
	bool isAsleep(int g) const override { return rest_[g].isAsleep(); }
	double watchRest(int g, double dt) override;
	bool isBalanced(int g, double kick) const override;
	WholeImpulses wholeImpulses(int g, double kick, const BodyLoad<dim>& load) const override;
	bool bears(int g, double force, const BodyLoad<dim>& load) const override;
	bool isDriven(int g, const BodyLoad<dim>& load) override;
	Vec<dim> fallAsleep(int g) override;
	void wake(int g) override;
	void arrangeGrains() override;
	RigidBounds<dim> rigidBounds(int g) const override;

	double rateStiffening(int g) const override
	{
		return damper_ && !isRigid_[g] ? damper_->rateStiffening(g) : 1;
	}
	/// Where velocities live at the points, they are smoothed in every step.
	bool mayHoldForces() const override { return !pointVelocities_; }
	void setRate(int g, int steps) override { holder_.setRate(g, steps); }
	ForceInterval interval(int g) const override { return holder_.interval(g); }
	void setInterval(int g, const ForceInterval& interval) override
	{
		holder_.setInterval(g, interval);
	}
	int updateForces(const ForceSchedule& schedule) override;
	const BulkReport& report(int g) const override { return batch_.report[g]; }
	void predictVelocities(int g, double kick, const BodyLoad<dim>& load) override;
	ContactMobility<dim> contactMobility(int g) override
	{
		const double scale = 1 / batch_.massScale[g];
		if (usesOwnNodes(g)) return { &ownNodes_[g].delassus, nullptr, scale };
		const GrainTemplate<dim>& reference = *batch_.reference;
		const bool hasFacets = !reference.contactMesh.facet.empty();
		return { &reference.delassus, hasFacets ? &reference.surfaceMobility : nullptr,
			 scale };
	}
	void contactVelocities(int g, std::vector<Vec<dim>>& at) const override;
	void contactVelocitiesBefore(int g, std::vector<Vec<dim>>& at) const override;
	void applyContactImpulses(int g, const std::vector<Vec<dim>>& impulse) override;
	bool hasFiniteVelocities(int g) const override;
	double kineticEnergy(int g) const override;
	void addLoadWork(int g, double kick, const BodyLoad<dim>& load, double& before,
			 double& after) const override;
	void addDampingLoss(int g, double kick, double& before, double& after) const override;
	bool preparesMove() const override { return pointVelocities_.has_value(); }
	void prepareMove(int threads) override;
	void move(int g, double dt) override;
	VectorRange<dim> contactVelocityRange(int g) const override;
	void contactPositions(int g, std::vector<Vec<dim>>& at) const override;
	void massPoints(int g, std::vector<Vec<dim>>& position,
			std::vector<double>& mass) const override;
	void useContactNodes(int g, const SparseRows<double>& pointShares) override;

	/// Of the nodes, or of the points where velocities live there.
	WholeGrain<dim> whole(int g) const override;
	double presentKineticEnergy(int g) const override;
	std::vector<PointResponse<dim>> points(int g) const override
	{
		writeNodes(g);
		return pointResponses(batch_, g);
	}
	double presentVolume(int g) const override
	{
		writeNodes(g);
		return softgrain::presentVolume(batch_, g);
	}
	std::vector<Vec<dim>> nodePositions(int g) const override;
	std::vector<Vec<dim>> nodeVelocities(int g) const override;
	void place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
		   const Mat<dim>& spin) override;
	void moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
			 const Vec<dim>& velocity, const Mat<dim>& spin) override;
	GrainState state(int g) const override;
	void setState(int g, const GrainState& state) override;

private:
	/// Contact nodes of one grain and one step, in place of those of the template.
	struct OwnNodes {
		NodeRows<dim> values, kicks; ///< as in GrainTemplate
		SparseRows<double> delassus;
	};

	/// Of a grain as a whole: momentum, and angular momentum over the radius of its rim, N s.
	using Momenta = Eigen::Matrix<double, dim == 2 ? 3 : 6, 1>;

	int nodes() const { return batch_.reference->nodes(); }
	/// Of the farthest contact node of the undeformed grain, m.
	double rimOf(int g) const { return outlineRadius_ * batch_.grain[g].radius; }
	Momenta momentaOf(int g, const WholeGrain<dim>& whole) const;
	static double sizeOf(const Momenta& momenta); ///< sum of both sizes
	void watchFromNow(int g, const WholeGrain<dim>& whole);
	/// Size of what a load does in some time, N s.
	double impulseOf(const BodyLoad<dim>& load, double time, int g,
			 const WholeGrain<dim>& whole) const;
	double stiffeningOf(int g, double frequency) const;
	WholeGrain<dim> wholeOfParticles(int g) const;
	void measureShapes();
	/// Energy of the motion apart from the rigid one, J.
	double vibrationEnergy(int g, const WholeGrain<dim>& whole) const;
	void computeFirst(std::vector<int> grains);
	template <class Visit> void forEachSlow(int threads, Visit&& visit);
	std::vector<double> heldForces(int g) const;
	void setHeldForces(int g, const std::vector<double>& numbers);
	/// If the grain moves rigidly and somebody wants to know its nodes.
	void writeNodes(int g) const;
	std::vector<double> restNumbers(int g) const;
	void restoreRest(int g, const std::vector<double>& numbers);
	void moveNodes(int g, double dt);
	Vec<dim> pointAt(int g, int p) const;
	bool usesOwnNodes(int g) const { return ownNodes_[g].values.rows() > 0; }
	const NodeRows<dim>& contactValues(int g) const
	{
		return usesOwnNodes(g) ? ownNodes_[g].values : batch_.reference->contactValues;
	}

	mutable Batch<dim> batch_;       ///< nodes of rigid grains are written when asked for
	std::vector<OwnNodes> ownNodes_; ///< none unless `useContactNodes` was called
	mutable std::optional<PointVelocities<dim>> pointVelocities_; ///< with VelocityUpdate::flip
	std::optional<Damper<dim>> damper_;                           ///< where a grain is damped
	ForceHolder<dim> holder_;
	std::vector<int> computed_;            ///< grains in the active blocks of the batch
	std::vector<double> criticalTimeStep_; ///< of the undeformed grains, s
	std::vector<Stiffening> stiffening_;

	/// Up to which a grain may move rigidly.
	struct RigidLimits {
		double squaredSpin; ///< 1/s^2
		double energy;      ///< of its deformation, elastic and kinetic each, J
	};
	std::vector<RigidShape<dim>> shape_;
	std::vector<RigidLimits> limits_;
	std::vector<RestWatch> rest_;
	std::vector<Momenta> watchedFrom_; ///< of a calm grain, when RestWatch::watchedTime began
	double outlineRadius_ = 0, outlineBulge_ = 0; ///< as in RigidBounds, in radii
	std::vector<RigidMotion<dim>> rigid_;         ///< where isRigid_
	std::vector<char> isRigid_;
	mutable std::vector<char> nodesWritten_;
};

} // namespace softgrain
