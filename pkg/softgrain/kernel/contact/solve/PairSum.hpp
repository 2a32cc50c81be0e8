// What the contacts of a pair do together, summed contact by contact.
#pragma once

#include "contact/ContactList.hpp"

#include <cmath>

namespace softgrain {

template <int dim> class PairSum {
public:
	/// An impulse that is not zero, at a place, m, with the unit normal to the body on which it
	/// acts; `sign` is 1 if that is the first one, -1 if it is the second.
	void add(const Vec<dim>& impulse, const Vec<dim>& normal, double sign,
		 const Vec<dim>& place)
	{
		const double along = impulse.dot(normal), pressed = std::abs(along);
		const Vec<dim> pressing = along * normal;
		++sum_.active;
		pressure_ += pressed;
		sum_.point += pressed * place;
		sum_.normal += sign * pressing;
		sum_.shear += sign * (impulse - pressing);
	}
	/// All but the moment; where nothing presses, the contact point is the mean of
	/// `place(constraint)`.
	template <class Constraints, class Place>
	PairImpulse<dim> total(const Constraints& constraints, Place&& place) const
	{
		PairImpulse<dim> total = sum_;
		if (pressure_ == 0)
			for (const auto& c : constraints)
				total.point += place(c);
		total.point /= pressure_ > 0 ? pressure_ : static_cast<double>(constraints.size());
		return total;
	}

private:
	PairImpulse<dim> sum_;
	double pressure_ = 0; ///< sum of the sizes of the normal parts, N s
};

} // namespace softgrain
