// The contacts of one pair of bodies as a problem of its own, all other impulses held:
//     u = u_0 + W (r - r_0),
// with W between these contacts as a dense table. Contacts of one grain with different bodies feel
// each other only where they share background nodes, so this is nearly the whole problem, and small
// enough for sweeps that cost half of those over surface nodes.
//
// Sweeps are extrapolated (Sweep.hpp). Velocities are linear in the impulses and are extrapolated
// with them.
#pragma once

#include "Vector.hpp"
#include "contact/solve/Residual.hpp"
#include "contact/solve/Sweep.hpp"

#include <array>
#include <vector>

namespace softgrain {

template <int dim> class PairProblem {
public:
	/// More make the table as expensive as the sweeps it saves.
	static constexpr int mostContacts = 128;

	/// Empties the table.
	void resize(int contacts);
	int contacts() const { return contacts_; }
	/// Column `contact` of W, 1/kg, has to be filled at the first contacts() places.
	double* column(int contact) { return &W_[contact * stride_]; }
	/// r_0 and u_0; after its column.
	void setContact(int contact, const Vec<dim>& normal, double bias, double friction,
			const Vec<dim>& impulse, const Vec<dim>& velocity);
	/// Sweeps until sum W |rho|^2 (Residual.hpp), kg m^2/s^2, is at most `violation`, or the
	/// cap is hit; returns their number, at least 1. If that sum has not fallen, the impulses
	/// are those of before.
	int solve(double violation, int maxSweeps);
	const Vec<dim>& impulse(int contact) const { return impulse_[contact]; }

private:
	SweepChange sweep();
	double remaining() const; ///< sum W |rho|^2
	void extrapolate(double share);
	Vec<dim> solved(int contact) const;
	void push(int contact, const Vec<dim>& J);

	int contacts_ = 0, stride_ = 0;
	std::vector<double> W_;                                          ///< column by column
	std::array<std::vector<double>, dim> velocity_, velocityBefore_; ///< u + b n, by component
	std::vector<Vec<dim>> impulse_, impulseBefore_, start_, normal_;
	std::vector<double> ownW_, inverseW_, friction_;
};

} // namespace softgrain
