// Soft grains in YADE's window.
#pragma once

#include "classes/SoftGrain.hpp"

namespace yade {

class Gl1_SoftGrain : public GlShapeFunctor {
public:
	void go(const shared_ptr<Shape>& shape, const shared_ptr<State>& state, bool wireAsked,
		const GLViewInfo&) override;
	RENDERS(SoftGrain);
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_SoftGrain, GlShapeFunctor,
		"Renders the outline of a :yref:`SoftGrain` as it is deformed: in 2D filled, with its edge darker, in 3D the facets; with contact 'points' the boundary points. During a run it may be that of a step or two ago.",
		((bool, wire, false, , "Only the edges of the facets."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(Gl1_SoftGrain);

} // namespace yade
