// The state of a total-Lagrangian set by hand: shown, saved, restored, moved.
#include "grain/InternalForce.hpp"
#include "grain/TotalLagrangian.hpp"

#include <algorithm>
#include <array>

namespace softgrain {

namespace {

template <int dim> std::array<double, 7> materialNumbers(const Batch<dim>& batch, int g)
{
	const GrainParameters<dim>& grain = batch.grain[g];
	const ElasticConstants& c = grain.constants;
	return { c.young,
		 c.poisson,
		 c.density,
		 grain.damping.mass,
		 grain.damping.stiffness,
		 static_cast<double>(batch.law),
		 static_cast<double>(batch.condition) };
}

/// What was found with the material of a grain, and is of no use with another one. Nothing stays
/// nothing.
template <int dim>
std::vector<double> withMaterial(const Batch<dim>& batch, int g, std::vector<double> numbers)
{
	if (numbers.empty()) return numbers;
	const auto material = materialNumbers(batch, g);
	numbers.insert(numbers.begin(), material.begin(), material.end());
	return numbers;
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
	std::vector<double> numbers { rest.calmTime() };
	if (!rest.isAsleep()) {
		numbers.push_back(rest.watchedTime());
		numbers.insert(numbers.end(), watchedFrom_[g].begin(), watchedFrom_[g].end());
		return numbers;
	}
	const BulkReport& report = batch_.report[g];
	for (double number : materialNumbers(batch_, g))
		numbers.push_back(number);
	numbers.insert(numbers.end(),
		       { report.elasticEnergy, report.stiffening, rateStiffening(g) });
	for (int I = 0; I < nodes(); ++I)
		for (int a = 0; a < dim; ++a)
			numbers.push_back(batch_.force.get(g, I)[a]);
	return numbers;
}

/// A grain that has another material now is awake.
template <int dim> void TotalLagrangian<dim>::restoreRest(int g, const std::vector<double>& numbers)
{
	rest_[g].wake();
	if (numbers.empty()) return;
	if (numbers.size() == 2 + Momenta::SizeAtCompileTime) {
		watchedFrom_[g] = Eigen::Map<const Momenta>(&numbers[2]);
		return rest_[g].restore(numbers[0], numbers[1], false);
	}
	const auto material = materialNumbers(batch_, g);
	const int figures = 1 + static_cast<int>(material.size()), forces = figures + 3;
	requireSize("figures at rest", numbers, forces + nodes() * dim);
	if (!std::equal(material.begin(), material.end(), numbers.begin() + 1)) return;
	rest_[g].restore(numbers[0], 0, true);
	batch_.report[g].elasticEnergy = numbers[figures];
	batch_.report[g].stiffening = numbers[figures + 1];
	damper_->setRateStiffening(g, numbers[figures + 2]);
	for (int I = 0; I < nodes(); ++I)
		batch_.force.set(g, I, Eigen::Map<const Vec<dim>>(&numbers[forces + I * dim]));
}

template <int dim> std::vector<double> TotalLagrangian<dim>::heldForces(int g) const
{
	std::vector<double> numbers;
	holder_.append(batch_, g, numbers);
	if (holder_.holds(g) && batch_.grain[g].damping.acts()) damper_->append(g, numbers);
	return numbers;
}

template <int dim>
void TotalLagrangian<dim>::setHeldForces(int g, const std::vector<double>& numbers)
{
	holder_.forget(g);
	if (numbers.empty()) return;
	const bool damps = batch_.grain[g].damping.acts();
	const int own = ForceHolder<dim>::numberCount(batch_);
	if (numbers.size() != ForceHolder<dim>::intervalNumbers)
		requireSize("forces", numbers, own + (damps ? damper_->numberCount() : 0));
	holder_.restore(batch_, g, numbers);
	if (holder_.holds(g) && damps) damper_->restore(g, numbers.data() + own);
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
	auto append = [](std::vector<double>& list, const Vec<dim>& value) {
		list.insert(list.end(), value.data(), value.data() + dim);
	};
	for (int I = 0; I < nodes(); ++I)
		append(s.x, batch_.x.get(g, I));
	if (pointVelocities_)
		for (int p = 0; p < batch_.reference->points(); ++p)
			append(s.v, pointVelocities_->get(g, p));
	else
		for (int I = 0; I < nodes(); ++I)
			append(s.v, batch_.v.get(g, I));
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
	for (int I = 0; I < nodes(); ++I)
		batch_.x.set(g, I, Eigen::Map<const Vec<dim>>(&s.x[I * dim]));
	for (int k = 0; k < velocities; ++k) {
		const Vec<dim> v = Eigen::Map<const Vec<dim>>(&s.v[k * dim]);
		if (pointVelocities_)
			pointVelocities_->set(g, k, v);
		else
			batch_.v.set(g, k, v);
	}
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
