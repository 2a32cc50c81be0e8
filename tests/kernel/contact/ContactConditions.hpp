// Checks Signorini's and Coulomb's conditions contact by contact.
#pragma once

#include "Vector.hpp"

#include <catch2/catch_test_macros.hpp>
#include <cmath>

namespace softgrain::testing {

class ContactConditions {
public:
	explicit ContactConditions(double friction)
		: friction_(friction)
	{
	}
	/// One contact of normal n that takes the impulse r, and moves by u relatively after it, in
	/// a step of 1 s.
	template <int dim>
	void check(const Vec<dim>& n, const Vec<dim>& r, const Vec<dim>& u, double gap)
	{
		const double un = u.dot(n) + gap, rn = r.dot(n);
		const Vec<dim> ut = u - u.dot(n) * n, rt = r - rn * n;
		CHECK(un > -1e-10);
		CHECK(rn >= 0);
		CHECK(std::abs(un * rn) < 1e-10);
		CHECK(rt.norm() < friction_ * rn + 1e-10);
		if (rn < 1e-10)
			++open;
		else if (ut.norm() < 1e-9)
			++stick;
		else {
			++slip;
			CHECK(std::abs(rt.norm() - friction_ * rn) < 1e-10);
			CHECK(std::abs(ut.dot(rt) + ut.norm() * rt.norm()) < 1e-10);
		}
	}

	int open = 0, stick = 0, slip = 0; ///< contacts so far

private:
	double friction_;
};

} // namespace softgrain::testing
