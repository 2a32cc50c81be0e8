// The balance of energies of a system.
#pragma once

#include "contact/RigidPartner.hpp"
#include "contact/solve/ContactWork.hpp"
#include "step/Grains.hpp"

#include <vector>

namespace softgrain {

/// Energies at t_n of rigid bodies as far as they are free, and of their contacts with each other,
/// J. kinetic = initial + walls + cell + loads - friction - impact, less what they did on grains
/// (EnergyBalance::walls).
struct RigidBalance {
	double kinetic = 0; ///< as EnergyBalance::kinetic
	double friction = 0, impact = 0;
	double walls = 0; ///< work of bodies (degrees of freedom) that move as prescribed
	double cell = 0;  ///< work of moving images
	double loads = 0; ///< work of all that acts on them besides contact dynamics
};

/// Energies at t_n, J (2D: J/m). kinetic + elastic = initial + work - friction - impact - damping
/// - sleep - cohesion up to rounding and the second-order error of the time integration.
struct EnergyBalance {
	double kinetic = 0; ///< 1/2 sum mI v(t_n - dt/2) . v(t_n + dt/2)
	double elastic = 0;
	double friction = 0; ///< dissipated by friction since the start
	double impact = 0;   ///< dissipated by normal impulses since the start
	double walls = 0; ///< work of moving planes and rigid bodies on the grains since the start
	double cell = 0;  ///< work of moving images on the grains since the start
	double loads = 0; ///< work of body loads since the start
	double damping = 0;  ///< dissipated by damping since the start
	double sleep = 0;    ///< taken away by grains falling asleep since the start
	double cohesion = 0; ///< taken by the tractions of interfaces since the start
	RigidBalance rigid;  ///< as far as StepSettings::trackRigidBodies was on
};

/// Kept where energies are tracked. Works are done half at the velocities before t_n and half at
/// those after: the sums run half a step ahead of the balance.
template <int dim> class Energies {
public:
	/// Of these grains, which must outlive it.
	explicit Energies(Grains<dim>& grains)
		: grains_(grains)
	{
	}
	/// At the last t_n.
	const EnergyBalance& balance() const { return balance_; }
	/// Works up to half a step after t_n.
	const EnergyBalance& sums() const { return sums_; }
	void continueFrom(const EnergyBalance& sums) { balance_ = sums_ = sums; }

	/// In each step, before the grains move: room for what follows, which threads may call for
	/// different grains.
	void beginMove() { works_.resize(grains_.count()); }
	/// With the new velocities.
	void noteKineticEnergy(int g);
	/// Of one that fell asleep.
	void noteRest(int g) { works_[g].kinetic = 0; }
	/// Of loads and damping, before the new velocities take the place of those that they are
	/// of; the loads act for `kick`.
	void measureWorks(int g, double kick);

	/// The balance at t_n, with what contacts did and what grains that fell asleep had.
	void balanceGrains(const ContactWork& contacts, double dropped);
	/// Afterwards, of rigid bodies: with their velocities without and with contact.
	void balanceRigidBodies(const ContactWork& contacts,
				const std::vector<RigidPartner<dim>>& partners);

private:
	/// Of a grain in a step, J: its energy at t_n, and what was done on it besides contact.
	struct GrainWork {
		double kinetic = 0;
		ContactWork::Halves loads, damping;
	};

	Grains<dim>& grains_;
	std::vector<GrainWork> works_; ///< by grain
	EnergyBalance balance_, sums_;
};

} // namespace softgrain
