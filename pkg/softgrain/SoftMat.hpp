#pragma once

#include "Yade.hpp"
#include "material/Elasticity.hpp"

namespace yade {

class SoftMat : public Material {
public:
	softgrain::ElasticConstants constants() const { return { young, poisson, density }; }
	softgrain::Law constitutiveLaw() const { return softgrain::lawByName(law); }
	/// Checks all attributes; throws std::invalid_argument (ValueError in Python).
	void postLoad(SoftMat&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(SoftMat, Material,
		"Continuum material of soft grains (:yref:`SoftGrain`), with Coulomb friction on their boundary. Wrong values raise ValueError. :yref:`density<Material.density>` is that of the undeformed grain [kg/m³].",
		((Real, young, 1e6, Attr::triggerPostLoad, "Young's modulus at small strain, > 0 [Pa]."))
		((Real, poisson, 0.45, Attr::triggerPostLoad, "Poisson's ratio at small strain, in (-1, 0.5) [-]."))
		((Real, frictionAngle, 0, Attr::triggerPostLoad, "Angle of Coulomb friction, in [0, π/2) [rad]. The smaller one of two bodies in contact counts, as everywhere in YADE; it is read when the contact is made."))
		((string, law, "neoHookean", Attr::triggerPostLoad, "Constitutive law: 'neoHookean', the compressible neo-Hookean solid P = μ(F − F⁻ᵀ) + λ ln J F⁻ᵀ."))
		((string, condition, "planeStrain", Attr::triggerPostLoad, "What closes the third dimension of 2D grains: 'planeStrain' (F₃₃ = 1) or 'planeStress' (P₃₃ = 0 at every point). 3D grains do not use it.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftMat, Material);
};
REGISTER_SERIALIZABLE(SoftMat);

} // namespace yade
