// State of a batch of congruent grains, which lie in blocks of laneWidth: the loops over material
// points pass over a full block one grain a lane, over others one point a lane (Strip.hpp).
#pragma once

#include "Vector.hpp"
#include "lanes/Lanes.hpp"
#include "material/Damping.hpp"
#include "material/Elasticity.hpp"
#include "reference/GrainTemplate.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace softgrain {

/// Grains in a block from which on they are computed side by side; in a block of fewer, each on its
/// own with its points side by side (doc/decisions/0013-bulk-pass.md).
constexpr int fullBlock = 4;

/// One vector per node and grain, the nodes of a grain side by side. Grains that were exchanged lie
/// in the memory of the other field, which has to live as long; a copy has all of its own.
template <int dim> class NodalField {
public:
	NodalField() = default;
	NodalField(NodalField&&) = default;
	NodalField(const NodalField& other)
	{
		resize(static_cast<int>(other.grain_.size()), other.nodes_);
		for (std::size_t g = 0; g < grain_.size(); ++g)
			std::copy_n(other.grain_[g], nodes_, grain_[g]);
	}

	void resize(int grains, int nodes)
	{
		nodes_ = nodes;
		data_.assign(static_cast<std::size_t>(grains) * nodes, Vec<dim>::Zero());
		grain_.clear();
		for (int g = 0; g < grains; ++g)
			grain_.push_back(data_.data() + static_cast<std::size_t>(g) * nodes);
	}
	/// The vectors of all nodes of a grain.
	Vec<dim>* of(int grain) { return grain_[grain]; }
	const Vec<dim>* of(int grain) const { return grain_[grain]; }

	const Vec<dim>& get(int grain, int I) const { return of(grain)[I]; }
	void set(int grain, int I, const Vec<dim>& value) { of(grain)[I] = value; }
	/// All vectors of a grain, side by side.
	using Columns = Eigen::Matrix<double, dim, Eigen::Dynamic>;
	Eigen::Map<Columns> allOf(int grain) { return { of(grain)->data(), dim, nodes_ }; }
	Eigen::Map<const Columns> allOf(int grain) const
	{
		return { of(grain)->data(), dim, nodes_ };
	}
	/// A grain's vectors for those in another field: less memory to go through than a copy.
	void exchange(int grain, NodalField& other)
	{
		std::swap(grain_[grain], other.grain_[grain]);
	}

private:
	int nodes_ = 0;
	std::vector<Vec<dim>> data_;
	std::vector<Vec<dim>*> grain_; ///< its first node
};

/// What distinguishes one grain of a batch from the next.
template <int dim> struct GrainParameters {
	double radius = 0; ///< m
	ElasticConstants constants;
	Vec<dim> origin =
		Vec<dim>::Zero(); ///< m; nodal positions are kept relative to it, so that a
				  ///< grain far from the origin of space loses no digits
	Damping damping;
};

/// Throws std::invalid_argument naming what is inadmissible about grains or their condition.
template <int dim>
void checkGrains(Condition condition, const std::vector<GrainParameters<dim>>& grains);

/// What the force pass found in one grain.
struct BulkReport {
	double elasticEnergy = 0; ///< J (2D: J/m)
	double stiffening = 1;    ///< largest PointLanes::stiffening of the grain
	int invertedPoint = -1;   ///< first point with J <= 0 or not finite, or -1
};

/// A batch: one template, one law and condition, any number of grains.
template <int dim> struct Batch {
	Batch(std::shared_ptr<const GrainTemplate<dim>> reference, Law law, Condition condition,
	      const std::vector<GrainParameters<dim>>& grains);

	std::shared_ptr<const GrainTemplate<dim>> reference;
	Law law;
	Condition condition;
	std::vector<GrainParameters<dim>> grain;
	std::vector<double> pointScale; ///< R^dim: Vp0 of grain over Vp0 of template
	std::vector<double> massScale;  ///< rho R^dim: nodal mass of grain over that of template
	/// LameConstants::isochoricShare; before `findIsochoricShares` 1 where volumes are
	/// projected, which is safe. For the next `arrange`.
	std::vector<double> isochoricShare;
	std::vector<LameConstants> lame; ///< per block; empty lanes repeat the block's first grain

	NodalField<dim> x;     ///< nodal positions relative to the grain's origin at t_n, m
	NodalField<dim> v;     ///< nodal velocities at t_n - dt/2, m/s
	NodalField<dim> force; ///< internal force at t_n, N (2D: N/m)
	/// Nodal velocities at t_n + dt/2, being computed; of no meaning between steps.
	NodalField<dim> vNext;
	std::vector<BulkReport> report;

	int grains() const { return static_cast<int>(grain.size()); }
	/// Lays the active grains into the lanes of the first blocks, side by side, and the others
	/// into blocks of their own behind them, so that passes over the active blocks do nothing
	/// for the others. Both lists together name every grain once.
	void arrange(const std::vector<int>& active, const std::vector<int>& others);
	int activeBlocks() const { return activeBlocks_; }
	int blocks() const { return static_cast<int>(lame.size()); }
	int blockOf(int g) const { return slot_[g] / laneWidth; }
	bool hasGrain(int block, int lane) const { return inSlot_[block * laneWidth + lane] >= 0; }
	int grainsInBlock(int block) const
	{
		int count = 0;
		while (count < laneWidth && hasGrain(block, count))
			++count;
		return count;
	}
	/// The grain in a lane; in lanes without one, the first of the block.
	int grainInLane(int block, int lane) const
	{
		return inSlot_[block * laneWidth + (hasGrain(block, lane) ? lane : 0)];
	}
	/// Some of its grains alone, in their present shape.
	Batch copyOf(const std::vector<int>& grains) const;

	double nodeMass(int g, int I) const { return massScale[g] * reference->nodeMass[I]; }
	double mass(int g) const { return massScale[g] * reference->volume; }
	Vec<dim> position(int g, int I) const { return grain[g].origin + x.get(g, I); }

	/// Places grain `g` undeformed: rotated by `rotation`, moving as a rigid body about its
	/// origin.
	void place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity, const Mat<dim>& spin);
	/// Adds a rigid motion to grain `g` in its present shape: positions about `centre`
	/// (relative to the origin) are rotated, then shifted; `velocity + spin (x - centre)` is
	/// added to the velocities.
	void moveRigidly(int g, const Vec<dim>& centre, const Mat<dim>& rotation,
			 const Vec<dim>& shift, const Vec<dim>& velocity, const Mat<dim>& spin);

private:
	void fillSlots(const std::vector<int>& grains);

	std::vector<int> slot_;   ///< by grain: block * laneWidth + lane
	std::vector<int> inSlot_; ///< grain in each slot, -1: none
	int activeBlocks_ = 0;
};

} // namespace softgrain
