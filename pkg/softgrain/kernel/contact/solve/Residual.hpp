// How far impulses are from a solution, whoever found them.
#pragma once

#include "Vector.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

/// Sums the natural map rho = proj_C(r - (u + b n)/W) - r over all contacts in the energy norm:
///     residual = sqrt( sum W |rho|^2 / max(sum W |r|^2, sum W |r + rho|^2) )
/// It has no unit, lies between 0 and 2, and is 0 exactly at solutions. The second sum takes over
/// where impulses are still missing (r = 0); where no contact has or needs one the residual is 0.
///
/// On rigid bodies that impulses move, sum W |r|^2 along a column, or through a light body, is far
/// more than the energy that is exchanged, r . W r, and a hundredth of it may throw the bodies
/// apart. `countExchanged` leaves out what it has beyond that
/// (doc/decisions/0020-rigid-contact-dynamics.md). The residual has no bound then.
class ResidualSum {
public:
	/// One contact: its impulse, the one that would solve it (`solvedContact`), its mobility W.
	template <int dim> void add(const Vec<dim>& impulse, const Vec<dim>& solved, double W)
	{
		violation_ += W * (solved - impulse).squaredNorm();
		present_ += W * impulse.squaredNorm();
		wanted_ += W * solved.squaredNorm();
	}
	/// One contact of another energy norm |.|^2: of rho, of its impulse, of the solved one.
	void add(double violation, double present, double wanted)
	{
		violation_ += violation;
		present_ += present;
		wanted_ += wanted;
	}
	/// Of a contact that has been added, with a rigid body that impulses move: its part of
	/// sum W |r|^2, and of r . W r.
	void addExchange(double present, double exchanged)
	{
		ofRigid_ += present;
		exchanged_ += exchanged;
	}
	void countExchanged(double atLeast)
	{
		countsExchanged_ = true;
		exchanged_ = std::max(exchanged_, atLeast);
	}
	ResidualSum& operator+=(const ResidualSum& other)
	{
		violation_ += other.violation_;
		present_ += other.present_;
		wanted_ += other.wanted_;
		addExchange(other.ofRigid_, other.exchanged_);
		return *this;
	}
	double violation() const { return violation_; } ///< sum W |rho|^2
	/// What the violation is to be compared with: the square of the residual's denominator.
	double scale() const { return sumOfSquares() - beyondExchange(); }
	/// The root of the scale over what it is without `countExchanged`.
	double strictness() const
	{
		return beyondExchange() > 0 ? std::sqrt(scale() / sumOfSquares()) : 1;
	}
	/// Not a number where an impulse or a velocity is none.
	double value() const { return violation_ == 0 ? 0 : std::sqrt(violation_ / scale()); }

private:
	double sumOfSquares() const { return std::max(present_, wanted_); }
	double beyondExchange() const
	{
		if (!countsExchanged_) return 0;
		// of the sum: with less, packings of rigid bodies that settle reach it too late
		constexpr double least = 1e-2;
		const double counts = std::max(exchanged_, least * ofRigid_);
		return std::max(ofRigid_ - counts, 0.);
	}

	double violation_ = 0, present_ = 0, wanted_ = 0; ///< kg m^2/s^2
	double ofRigid_ = 0, exchanged_ = 0;              ///< addExchange
	bool countsExchanged_ = false;
};

/// What changed in a sweep over the residual after it, at most: the residual was 0.55 to 1.1 times
/// the change in problems of a compaction.
inline constexpr double changePerResidual = 2;

} // namespace softgrain
