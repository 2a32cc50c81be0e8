#pragma once

#include "Yade.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"
#include "scene/EngineScene.hpp"

#include <map>

namespace yade {

class SoftenWhenLoaded : public GlobalEngine {
public:
	void action() override;
	/// Checks `load`; throws std::invalid_argument (ValueError in Python). (Shape and material
	/// may be assigned later.)
	void postLoad(SoftenWhenLoaded&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(SoftenWhenLoaded, GlobalEngine,
		"Turns spheres into soft grains one by one, each when it first bears load, in place, with its velocity and spin. It stands after the InteractionLoop and before :yref:`SoftGrainIntegrator`; sg.soften(when='loaded') puts it there. In the step in which a grain is turned, the contact forces that act on it already, and on its partners, act on the soft grain; contact dynamics (rigid = 'nonsmooth') has found none by then, and the contact bears nothing in that step. Either way momentum is kept, of spheres that have the mass of the soft grain, as sg.soften() gives it to them. (With SoftMat.massScaling the velocity is kept, as by sg.scale_mass().) Its contacts are found anew in the next step; what overlap the rigid contact had is worked off. Bonds of the sphere end (:yref:`SoftGrainIntegrator.lostBonds`); where they form at touch they form anew.",
		((vector<int>, ids, , , "Spheres that still wait. |yupdate|"))
		((shared_ptr<SoftGrain>, shape, , Attr::triggerPostLoad, "Shape of the soft grains, whose radius and colour are those of the spheres; they begin undeformed, however the shape is deformed if a body has it."))
		((shared_ptr<SoftMat>, material, , Attr::triggerPostLoad, "Their material."))
		((Real, load, 1e-3, Attr::triggerPostLoad, "A grain is turned when the force of one of its contacts is above load times E D (3D: E D²), with E of the material and D the diameter of the sphere, ≥ 0 [-]."))
		((int, softened, 0, Attr::readonly, "Spheres turned so far. |yupdate|"))
		((Real, dt, 0, Attr::hidden, "O.dt before the first was turned [s]."))
	);
	// clang-format on

private:
	bool hasSoftGrains() const;
	bool isLoaded(const Body& body) const;
	/// Returns the bonds to soft grains that end.
	int soften(Body& body) const;
	void leaveTimeStepToIntegrator();
	void forgetOtherScene();

	EngineScene ownScene_;
	vector<int> lastIds_;                         ///< in the last step
	std::map<int, boost::weak_ptr<Body>> bodies_; ///< that had the ids then
};
REGISTER_SERIALIZABLE(SoftenWhenLoaded);

} // namespace yade
