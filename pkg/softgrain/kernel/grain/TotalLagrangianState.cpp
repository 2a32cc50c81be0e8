// The state of a total-Lagrangian set by hand: shown, saved, restored, moved.
#include "Numbers.hpp"
#include "grain/InternalForce.hpp"
#include "grain/TotalLagrangian.hpp"

#include <algorithm>

namespace softgrain {

namespace {

template <int dim> std::vector<double> materialNumbers(const Batch<dim>& batch, int g)
{
	const GrainParameters<dim>& grain = batch.grain[g];
	const ElasticConstants& c = grain.constants;
	return numbersOf(c.young, c.poisson, c.density, grain.damping.mass, grain.damping.stiffness,
			 batch.law, batch.condition);
}

/// What was found with the material of a grain, and is of no use with another one. Nothing stays
/// nothing.
template <int dim>
std::vector<double> withMaterial(const Batch<dim>& batch, int g, const std::vector<double>& numbers)
{
	if (numbers.empty()) return {};
	return numbersOf(materialNumbers(batch, g), numbers);
}

/// The same back; nothing if the material is another one now.
template <int dim>
std::vector<double> ofSameMaterial(const Batch<dim>& batch, int g, std::vector<double> numbers)
{
	const auto material = materialNumbers(batch, g);
	const bool same = numbers.size() > material.size() &&
			  std::equal(material.begin(), material.end(), numbers.begin());
	if (!same) return {};
	numbers.erase(numbers.begin(), numbers.begin() + material.size());
	return numbers;
}

/// In its present shape, J (2D: J/m).
template <int dim> double elasticEnergyOf(const Batch<dim>& batch, int g)
{
	Batch<dim> alone = batch.copyOf({ g });
	computeInternalForce(alone, 1);
	return alone.report[0].elasticEnergy;
}

} // namespace

/// Calm time; of a grain that is awake how long it has been watched, and its momenta then; of a
/// sleeping one the material it rests with, what was known of it, and the forces of its nodes, so
/// that nothing is computed when it is loaded or woken.
template <int dim> std::vector<double> TotalLagrangian<dim>::restNumbers(int g) const
{
	const RestWatch& rest = rest_[g];
	if (rest.calmTime() == 0) return {};
	if (!rest.isAsleep())
		return numbersOf(rest.calmTime(), rest.watchedTime(), watchedFrom_[g]);
	const BulkReport& report = batch_.report[g];
	return numbersOf(rest.calmTime(), materialNumbers(batch_, g), report.elasticEnergy,
			 report.stiffening, rateStiffening(g), batch_.force.allOf(g));
}

/// A grain that has another material now is awake.
template <int dim> void TotalLagrangian<dim>::restoreRest(int g, const std::vector<double>& numbers)
{
	rest_[g].wake();
	if (numbers.empty()) return;
	NumbersInTurn saved(numbers);
	const double calmTime = saved.next<double>();
	if (numbers.size() == 2 + Momenta::SizeAtCompileTime) {
		const double watchedTime = saved.next<double>();
		saved.take(watchedFrom_[g]);
		return rest_[g].restore(calmTime, watchedTime, false);
	}
	const std::vector<double> material = materialNumbers(batch_, g);
	requireSize("figures at rest", numbers,
		    1 + static_cast<int>(material.size()) + 3 + nodes() * dim);
	std::vector<double> savedMaterial(material.size());
	saved.take(savedMaterial);
	if (savedMaterial != material) return;
	rest_[g].restore(calmTime, 0, true);
	BulkReport& report = batch_.report[g];
	saved.take(report.elasticEnergy, report.stiffening);
	damper_->setRateStiffening(g, saved.next<double>());
	saved.take(batch_.force.allOf(g));
}

template <int dim> std::vector<double> TotalLagrangian<dim>::heldForces(int g) const
{
	std::vector<double> numbers = holder_.numbers(batch_, g);
	if (holder_.holds(g) && batch_.grain[g].damping.acts())
		append(numbers, damper_->numbers(g));
	return numbers;
}

template <int dim>
void TotalLagrangian<dim>::setHeldForces(int g, const std::vector<double>& numbers)
{
	holder_.forget(g);
	if (numbers.empty()) return;
	const bool holds = numbers.size() != ForceHolder<dim>::intervalNumbers;
	const bool damps = batch_.grain[g].damping.acts();
	if (holds)
		requireSize("forces", numbers,
			    ForceHolder<dim>::numberCount(batch_) +
				    (damps ? damper_->numberCount() : 0));
	NumbersInTurn saved(numbers);
	holder_.restoreInterval(g, saved);
	if (!holds) return;
	holder_.restoreForces(batch_, g, saved);
	if (damps) damper_->restore(g, saved);
}

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodePositions(int g) const
{
	writeNodes(g);
	std::vector<Vec<dim>> x;
	for (int I = 0; I < nodes(); ++I)
		x.push_back(batch_.position(g, I));
	return x;
}

template <int dim> std::vector<Vec<dim>> TotalLagrangian<dim>::nodeVelocities(int g) const
{
	writeNodes(g);
	std::vector<Vec<dim>> v;
	for (int I = 0; I < nodes(); ++I)
		v.push_back(batch_.v.get(g, I));
	return v;
}

template <int dim>
void TotalLagrangian<dim>::place(int g, const Mat<dim>& rotation, const Vec<dim>& velocity,
				 const Mat<dim>& spin)
{
	isRigid_[g] = 0;
	wake(g);
	nodesWritten_[g] = 1;
	holder_.forget(g);
	stiffening_[g] = {};
	batch_.place(g, rotation, velocity, spin);
	if (!pointVelocities_) return;
	pointVelocities_->takeFromNodes(batch_, g);
	pointVelocities_->mapToNodes(batch_, g);
}

template <int dim>
void TotalLagrangian<dim>::moveRigidly(int g, const Mat<dim>& rotation, const Vec<dim>& shift,
				       const Vec<dim>& velocity, const Mat<dim>& spin)
{
	if (isRigid_[g]) {
		rigid_[g].add(rotation, shift, velocity, spin, shape_[g]);
		nodesWritten_[g] = 0;
		return;
	}
	holder_.forget(g); // forces turn with the grain
	const Vec<dim> centre = whole(g).centre;
	batch_.moveRigidly(g, centre, rotation, shift, velocity, spin);
	if (!pointVelocities_) return;
	for (int p = 0; p < batch_.reference->points(); ++p)
		pointVelocities_->set(g, p,
				      rotation * pointVelocities_->get(g, p) + velocity +
					      spin * (pointAt(g, p) - centre - shift));
	pointVelocities_->mapToNodes(batch_, g);
}

template <int dim> GrainState TotalLagrangian<dim>::state(int g) const
{
	writeNodes(g);
	GrainState s;
	if (isRigid_[g]) s.rigid = rigid_[g].numbers();
	s.held = withMaterial(batch_, g, heldForces(g));
	s.rest = restNumbers(g);
	if (stiffening_[g].isMeasured())
		s.stiffening = withMaterial(batch_, g, stiffening_[g].numbers());
	append(s.x, batch_.x.allOf(g));
	append(s.v, pointVelocities_ ? pointVelocities_->allOf(g) : batch_.v.allOf(g));
	return s;
}

template <int dim> void TotalLagrangian<dim>::setState(int g, const GrainState& s)
{
	const int velocities = pointVelocities_ ? batch_.reference->points() : nodes();
	requireSize("positions", s.x, nodes() * dim);
	requireSize("velocities", s.v, velocities * dim);
	requireSize("deformation gradients", s.F, 0);
	if (!s.rigid.empty()) {
		requireSize("rigid motion", s.rigid, RigidMotion<dim>::numberCount);
		rigid_[g] = RigidMotion<dim>::fromNumbers(s.rigid);
	}
	isRigid_[g] = !s.rigid.empty();
	restoreRest(g, s.rest);
	stiffening_[g] = {};
	const std::vector<double> stiffening = ofSameMaterial(batch_, g, s.stiffening);
	if (!stiffening.empty()) {
		requireSize("stiffening", stiffening, Stiffening::numberCount);
		stiffening_[g] = Stiffening::fromNumbers(stiffening);
	}
	++this->changesOfActivity_;
	nodesWritten_[g] = 1;
	NumbersInTurn(s.x).take(batch_.x.allOf(g));
	NumbersInTurn(s.v).take(pointVelocities_ ? pointVelocities_->allOf(g) : batch_.v.allOf(g));
	if (pointVelocities_) pointVelocities_->mapToNodes(batch_, g);
	setHeldForces(g, ofSameMaterial(batch_, g, s.held));
	if (!isRigid_[g] && !isAsleep(g)) // to be told before the next forces are computed
		batch_.report[g].elasticEnergy = elasticEnergyOf(batch_, g);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::vector<Vec<dim>> TotalLagrangian<dim>::nodePositions(int) const;             \
	template std::vector<Vec<dim>> TotalLagrangian<dim>::nodeVelocities(int) const;            \
	template void TotalLagrangian<dim>::place(int, const Mat<dim>&, const Vec<dim>&,           \
						  const Mat<dim>&);                                \
	template void TotalLagrangian<dim>::moveRigidly(int, const Mat<dim>&, const Vec<dim>&,     \
							const Vec<dim>&, const Mat<dim>&);         \
	template GrainState TotalLagrangian<dim>::state(int) const;                                \
	template void TotalLagrangian<dim>::setState(int, const GrainState&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
