// Energies of rigid bodies under contact dynamics.
#include "step/System.hpp"

namespace softgrain {

/// With the sums up to here: energies at t_n, of which the first halves of works are done.
template <int dim> void System<dim>::balanceRigidBodies()
{
	ContactWork::Halves loads;
	RigidBalance &now = energy_.rigid, &sums = continuation_.sums.rigid;
	now = sums;
	now.kinetic = 0;
	for (std::size_t k = 0; k < partners_.size(); ++k) {
		const RigidPartner<dim>&p = partners_[k], &free = free_[k];
		now.kinetic +=
			0.5 * p.massProduct(p.velocityBefore, p.spinBefore, p.velocity, p.spin);
		const Vec<dim> gained = free.velocity - p.velocityBefore;
		const Spin<dim> spinGained = free.spin - p.spinBefore;
		loads.before +=
			0.5 * p.massProduct(gained, spinGained, p.velocityBefore, p.spinBefore);
		loads.after += 0.5 * p.massProduct(gained, spinGained, p.velocity, p.spin);
	}
	auto book = [&](double RigidBalance::* sum, const ContactWork::Halves& halves) {
		now.*sum += halves.before;
		sums.*sum += halves.before + halves.after;
	};
	const ContactWork work = solver_.rigidWork();
	book(&RigidBalance::friction, work.friction);
	book(&RigidBalance::impact, work.impact);
	book(&RigidBalance::walls, work.planes);
	book(&RigidBalance::cell, work.cell);
	book(&RigidBalance::loads, loads);
}

template void System<2>::balanceRigidBodies();
template void System<3>::balanceRigidBodies();

} // namespace softgrain
