// From the names of law and condition to the evaluator, resolved once per pass over a batch.
#pragma once

#include "material/NeoHookean.hpp"

#include <concepts>

namespace softgrain {

/// What a law is made of, all of it static. (A law whose `canProject` is true has besides
/// volumetricStrain(point) and evaluateProjected(point, lame, theta).)
template <class L, int dim>
concept ConstitutiveLaw =
	requires(PointLanes<dim>& point, const LameConstants& lame, const Lanes& theta,
		 PointLanes<dim, HalfLanes>& half, const LameNumbers<HalfLanes>& lameOfHalf) {
		L::evaluate(point, lame); // P, J, energy and stiffening from F
		L::evaluate(half, lameOfHalf);
		L::stiffenInSpace(point, lame); // then: stiffening as a grid fixed in space sees it
		{ L::outOfPlane(point, lame, theta) } -> std::same_as<OutOfPlane>;
		{ L::canProject } -> std::convertible_to<bool>;
	};

/// Calls `use(evaluator)` with a law that is checked to be one.
template <int dim, ConstitutiveLaw<dim> L, class Use> void useLaw(Use&& use) { use(L {}); }

/// Calls `use(Evaluator{})` with the evaluator of (law, condition). (Names of laws are in
/// Elasticity.cpp.)
template <int dim, class Use> void withLaw(Law law, Condition condition, Use&& use)
{
	switch (law) {
	case Law::neoHookean:
		if constexpr (dim == 3)
			useLaw<3, NeoHookean<3, Condition::solid>>(use);
		else if (condition == Condition::planeStress)
			useLaw<2, NeoHookean<2, Condition::planeStress>>(use);
		else
			useLaw<2, NeoHookean<2, Condition::planeStrain>>(use);
	}
}

} // namespace softgrain
