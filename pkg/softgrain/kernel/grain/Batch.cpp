#include "grain/Batch.hpp"
#include "Require.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace softgrain {

template <int dim>
void checkGrains(Condition condition, const std::vector<GrainParameters<dim>>& grains)
{
	if ((dim == 3) != (condition == Condition::solid))
		throw std::invalid_argument(
			"condition must be 'solid' in 3D, and plane strain or plane stress in 2D");
	for (const GrainParameters<dim>& grain : grains) {
		grain.constants.validate();
		grain.damping.validate();
		require(grain.radius > 0 && std::isfinite(grain.radius), "radius", grain.radius,
			"(0, inf) m");
	}
}

template <int dim>
Batch<dim>::Batch(std::shared_ptr<const GrainTemplate<dim>> ref, Law theLaw, Condition theCondition,
		  const std::vector<GrainParameters<dim>>& grains)
	: reference(std::move(ref))
	, law(theLaw)
	, condition(theCondition)
	, grain(grains)
	, report(grains.size())
{
	checkGrains(condition, grains);
	if (condition == Condition::planeStress && !reference->pressureSpace.empty())
		throw std::invalid_argument(
			"volumetric = 'projected' is for plane strain and 3D: in plane stress the "
			"thickness is free to follow, and nothing locks; use 'pointwise'");
	for (const GrainParameters<dim>& own : grain) {
		pointScale.push_back(std::pow(own.radius, dim));
		massScale.push_back(own.constants.density * pointScale.back());
		isochoricShare.push_back(
			reference->pressureSpace.empty() && own.constants.poisson >= 0 ? 0 : 1);
	}
	std::vector<int> all(grains.size());
	std::iota(all.begin(), all.end(), 0);
	arrange(all, {});
	for (NodalField<dim>* field : { &x, &v, &force, &vNext })
		field->resize(this->grains(), reference->nodes());
	for (int g = 0; g < this->grains(); ++g)
		for (int I = 0; I < reference->nodes(); ++I)
			x.set(g, I, grain[g].radius * reference->nodePosition[I]);
}

template <int dim>
void Batch<dim>::arrange(const std::vector<int>& active, const std::vector<int>& others)
{
	slot_.resize(grain.size());
	inSlot_.clear();
	fillSlots(active);
	activeBlocks_ = static_cast<int>(inSlot_.size()) / laneWidth;
	fillSlots(others);
	lame.assign(inSlot_.size() / laneWidth, LameConstants());
	for (int b = 0; b < blocks(); ++b)
		for (int l = 0; l < laneWidth; ++l) {
			const int g = grainInLane(b, l);
			lame[b].set(l, grain[g].constants, isochoricShare[g]);
		}
}

/// Appends whole blocks that hold the grains.
template <int dim> void Batch<dim>::fillSlots(const std::vector<int>& grains)
{
	for (int g : grains) {
		slot_[g] = static_cast<int>(inSlot_.size());
		inSlot_.push_back(g);
	}
	while (inSlot_.size() % laneWidth != 0)
		inSlot_.push_back(-1);
}

template <int dim> Batch<dim> Batch<dim>::copyOf(const std::vector<int>& grains) const
{
	std::vector<GrainParameters<dim>> parameters;
	for (int g : grains)
		parameters.push_back(grain[g]);
	Batch copy(reference, law, condition, parameters);
	for (std::size_t k = 0; k < grains.size(); ++k)
		std::copy_n(x.of(grains[k]), reference->nodes(), copy.x.of(static_cast<int>(k)));
	return copy;
}

template <int dim>
void Batch<dim>::place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
		       const Mat<dim>& spin)
{
	for (int I = 0; I < reference->nodes(); ++I) {
		const Vec<dim> position = grain[g].radius * (rotation * reference->nodePosition[I]);
		x.set(g, I, position);
		v.set(g, I, velocity + spin * position);
	}
}

template <int dim>
void Batch<dim>::moveRigidly(int g, const Vec<dim>& centre, const Mat<dim>& rotation,
			     const Vec<dim>& shift, const Vec<dim>& velocity, const Mat<dim>& spin)
{
	for (int I = 0; I < reference->nodes(); ++I) {
		const Vec<dim> arm = rotation * (x.get(g, I) - centre);
		x.set(g, I, centre + arm + shift);
		v.set(g, I, rotation * v.get(g, I) + velocity + spin * arm);
	}
}

template void checkGrains<2>(Condition, const std::vector<GrainParameters<2>>&);
template void checkGrains<3>(Condition, const std::vector<GrainParameters<3>>&);
template struct Batch<2>;
template struct Batch<3>;

} // namespace softgrain
