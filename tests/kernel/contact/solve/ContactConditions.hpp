// Checks Signorini's and Coulomb's conditions contact by contact.
#pragma once

#include "Vector.hpp"

#include <catch2/catch_test_macros.hpp>
#include <cmath>

namespace softgrain::testing {

/// Counts of what the contacts of a solution do.
struct States {
	int open = 0, stick = 0, slip = 0;

	States& operator+=(const States& more)
	{
		open += more.open;
		stick += more.stick;
		slip += more.slip;
		return *this;
	}
};

/// How exactly the conditions hold.
struct Tolerances {
	double conditions; ///< of velocities and impulses
	double still;      ///< tangential velocity below which a contact sticks
};

/// One contact of normal n that takes the impulse r, moves by u relatively after it, and has the
/// bias b: all its conditions. Returns what it does.
template <int dim>
States checkContact(const Vec<dim>& n, const Vec<dim>& r, const Vec<dim>& u, double bias,
		    double friction, const Tolerances& tolerances)
{
	States states;
	const double tolerance = tolerances.conditions;
	const double un = u.dot(n) + bias, rn = r.dot(n), bound = friction * rn;
	const Vec<dim> ut = u - u.dot(n) * n, rt = r - rn * n;
	CHECK(un > -tolerance);
	CHECK(rn >= 0);
	CHECK(std::abs(un * rn) < tolerance);
	CHECK(rt.norm() < bound + tolerance);
	if (rn < tolerance)
		++states.open;
	else if (ut.norm() < tolerances.still)
		++states.stick;
	else {
		++states.slip;
		CHECK(std::abs(rt.norm() - bound) < tolerance);
		CHECK(std::abs(ut.dot(rt) + ut.norm() * rt.norm()) < tolerance);
	}
	return states;
}

/// The same for contacts of one coefficient of friction in a step of 1 s; counts of all so far.
class ContactConditions : public States {
public:
	explicit ContactConditions(double friction)
		: friction_(friction)
	{
	}
	template <int dim>
	void check(const Vec<dim>& n, const Vec<dim>& r, const Vec<dim>& u, double gap)
	{
		*this += checkContact<dim>(n, r, u, gap, friction_, { 1e-10, 1e-9 });
	}

private:
	double friction_;
};

} // namespace softgrain::testing
