#include "grain/GrainSet.hpp"
#include "Require.hpp"
#include "grain/TotalLagrangian.hpp"
#include "grain/UpdatedLagrangian.hpp"

#include <stdexcept>
#include <string>

namespace softgrain {

void requireSize(const char* what, const std::vector<double>& numbers, int expected)
{
	if (static_cast<int>(numbers.size()) == expected) return;
	throw std::invalid_argument(
		"its saved " + std::string(what) + " are " + std::to_string(numbers.size()) +
		" numbers, its discretisation needs " + std::to_string(expected) +
		"; discretisation parameters cannot be changed after the first "
		"step");
}

namespace {

[[noreturn]] void refuseRigidMotion()
{
	throw std::logic_error("this formulation does not move grains rigidly");
}

[[noreturn]] void refuseSleep()
{
	throw std::logic_error("this formulation does not let grains sleep");
}

} // namespace

template <int dim> void GrainSet<dim>::beginRigidMotion(int) { refuseRigidMotion(); }

template <int dim> void GrainSet<dim>::endRigidMotion(int) { refuseRigidMotion(); }

template <int dim> RigidBounds<dim> GrainSet<dim>::rigidBounds(int) const { refuseRigidMotion(); }

template <int dim> void GrainSet<dim>::setRate(int, int steps)
{
	if (steps != 1)
		throw std::logic_error("this formulation computes its forces in every step");
}

template <int dim> double GrainSet<dim>::presentVolume(int g) const
{
	double sum = 0;
	for (const PointResponse<dim>& point : points(g))
		sum += point.volume;
	return sum;
}

template <int dim> Vec<dim> GrainSet<dim>::fallAsleep(int) { refuseSleep(); }

template <int dim> void GrainSet<dim>::wake(int) { refuseSleep(); }

template <int dim>
WholeImpulses GrainSet<dim>::wholeImpulses(int, double, const BodyLoad<dim>&) const
{
	refuseSleep();
}

template <int dim>
void GrainSet<dim>::massPoints(int, std::vector<Vec<dim>>&, std::vector<double>&) const
{
	throw std::logic_error("this formulation does not give its mass to a common grid");
}

template <int dim> void GrainSet<dim>::useContactNodes(int, const SparseRows<double>&)
{
	throw std::logic_error("this formulation has contact nodes of its own only");
}

template <int dim>
std::unique_ptr<GrainSet<dim>>
makeGrainSet(std::shared_ptr<const GrainTemplate<dim>> reference, Law law, Condition condition,
	     const std::vector<GrainParameters<dim>>& grains, const Scheme& scheme)
{
	scheme.validate(reference->recipe);
	for (const GrainParameters<dim>& grain : grains)
		if (scheme.hasPointVelocities())
			for (const auto& [name, value] :
			     { std::pair("massDamping", grain.damping.mass),
			       std::pair("stiffnessDamping", grain.damping.stiffness) })
				require(value == 0, name, value,
					"{0}: damping is for velocities at the nodes (formulation "
					"= "
					"'total', velocityUpdate = 'nodal')");
	if (scheme.formulation == Formulation::updated)
		return std::make_unique<UpdatedLagrangian<dim>>(std::move(reference), law,
								condition, grains, scheme.picShare);
	return std::make_unique<TotalLagrangian<dim>>(
		Batch<dim>(std::move(reference), law, condition, grains), scheme);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template class GrainSet<dim>;                                                              \
	template std::unique_ptr<GrainSet<dim>> makeGrainSet<dim>(                                 \
		std::shared_ptr<const GrainTemplate<dim>>, Law, Condition,                         \
		const std::vector<GrainParameters<dim>>&, const Scheme&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
