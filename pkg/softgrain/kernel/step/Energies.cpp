#include "step/Energies.hpp"

namespace softgrain {

template <int dim> void Energies<dim>::noteKineticEnergy(int g)
{
	works_[g].kinetic = grains_.setOf(g).kineticEnergy(grains_.indexInSet(g));
}

template <int dim> void Energies<dim>::measureWorks(int g, double kick)
{
	const GrainSet<dim>& set = grains_.setOf(g);
	const int k = grains_.indexInSet(g);
	const BodyLoad<dim>& load = grains_.loads()[g];
	ContactWork::Halves loads, damping;
	if (!load.isZero()) set.addLoadWork(k, kick, load, loads.before, loads.after);
	set.addDampingLoss(k, kick, damping.before, damping.after);
	works_[g].loads = loads;
	works_[g].damping = damping;
}

namespace {

/// The first half is done when t_n is reached.
template <class Balance>
void book(Balance& now, Balance& sums, double Balance::* sum, const ContactWork::Halves& halves)
{
	now.*sum += halves.before;
	sums.*sum += halves.before + halves.after;
}

} // namespace

template <int dim> void Energies<dim>::balanceGrains(const ContactWork& contacts, double dropped)
{
	balance_ = sums_;
	balance_.kinetic = balance_.elastic = 0;
	for (int g = 0; g < grains_.count(); ++g)
		balance_.elastic += grains_.setOf(g).report(grains_.indexInSet(g)).elasticEnergy;
	ContactWork::Halves loads, damping;
	for (int g : grains_.awake()) { // one after the other, whoever computed it
		balance_.kinetic += works_[g].kinetic;
		loads += works_[g].loads;
		damping += works_[g].damping;
	}
	auto bookGrains = [this](double EnergyBalance::* sum, const ContactWork::Halves& halves) {
		book(balance_, sums_, sum, halves);
	};
	bookGrains(&EnergyBalance::impact, contacts.impact);
	bookGrains(&EnergyBalance::friction, contacts.friction);
	bookGrains(&EnergyBalance::walls, contacts.walls);
	bookGrains(&EnergyBalance::cell, contacts.cell);
	bookGrains(&EnergyBalance::cohesion, contacts.cohesion);
	bookGrains(&EnergyBalance::loads, loads);
	bookGrains(&EnergyBalance::damping, damping);
	bookGrains(&EnergyBalance::sleep, { dropped, 0 });
}

template <int dim>
void Energies<dim>::balanceRigidBodies(const ContactWork& contacts,
				       const std::vector<RigidPartner<dim>>& partners)
{
	ContactWork::Halves loads;
	RigidBalance &now = balance_.rigid, &sums = sums_.rigid;
	now = sums;
	now.kinetic = 0;
	for (const RigidPartner<dim>& p : partners) {
		now.kinetic +=
			0.5 * p.massProduct(p.velocityBefore, p.spinBefore, p.velocity, p.spin);
		const Vec<dim> gained = p.freeVelocity - p.velocityBefore;
		const Spin<dim> spinGained = p.freeSpin - p.spinBefore;
		loads.before +=
			0.5 * p.massProduct(gained, spinGained, p.velocityBefore, p.spinBefore);
		loads.after += 0.5 * p.massProduct(gained, spinGained, p.velocity, p.spin);
	}
	book(now, sums, &RigidBalance::friction, contacts.friction);
	book(now, sums, &RigidBalance::impact, contacts.impact);
	book(now, sums, &RigidBalance::walls, contacts.walls);
	book(now, sums, &RigidBalance::cell, contacts.cell);
	book(now, sums, &RigidBalance::loads, loads);
}

template class Energies<2>;
template class Energies<3>;

} // namespace softgrain
