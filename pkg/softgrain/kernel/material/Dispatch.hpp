// From the names of law and condition to the evaluator, resolved once per pass over a batch.
#pragma once

#include "material/NeoHookean.hpp"

namespace softgrain {

/// Calls `use(Evaluator{})` with the evaluator of (law, condition). The only list of laws.
template <int dim, class Use> void withLaw(Law law, Condition condition, Use&& use)
{
	switch (law) {
	case Law::neoHookean:
		if constexpr (dim == 3)
			use(NeoHookean<3, Condition::solid> {});
		else if (condition == Condition::planeStress)
			use(NeoHookean<2, Condition::planeStress> {});
		else
			use(NeoHookean<2, Condition::planeStrain> {});
	}
}

} // namespace softgrain
