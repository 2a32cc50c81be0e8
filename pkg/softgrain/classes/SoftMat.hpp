#pragma once

#include "Yade.hpp"
#include "material/Damping.hpp"
#include "material/Elasticity.hpp"

namespace yade {

/// What an assembly takes of a SoftMat.
struct AssembledMaterial {
	softgrain::ElasticConstants constants;
	softgrain::Damping damping;
	string law, condition;
};

/// Whether friction has a coefficient with it.
bool isFrictionAngle(Real angle);
/// Throws std::invalid_argument unless it is one.
void requireFrictionAngle(const string& parameter, Real angle);

class SoftMat : public Material {
public:
	/// Throws std::invalid_argument on the scale of the density, which nobody sees after that.
	AssembledMaterial assembled() const;
	/// Whether nothing of that has changed.
	bool isAs(const AssembledMaterial& before) const
	{
		return before.constants == constants() && before.damping == damping() &&
		       before.law == law && before.condition == condition;
	}
	/// With the density that inertia sees.
	softgrain::ElasticConstants constants() const
	{
		return { young, poisson, massScaling * density };
	}
	softgrain::Damping damping() const { return { massDamping, stiffnessDamping }; }
	softgrain::Law constitutiveLaw() const { return softgrain::lawByName(law); }
	/// What closes the third dimension of a grain of this dimension.
	softgrain::Condition conditionIn(int dim) const;
	Real waveImpedance(int dim) const { return constants().waveImpedance(conditionIn(dim)); }
	/// Checks all attributes; throws std::invalid_argument (ValueError in Python).
	void postLoad(SoftMat&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(SoftMat, Material,
		"Continuum material of soft grains (:yref:`SoftGrain`), with Coulomb friction on their boundary. Wrong values raise ValueError. :yref:`density<Material.density>` is that of the undeformed grain [kg/m³].",
		((Real, young, 1e6, Attr::triggerPostLoad, "Young's modulus at small strain, > 0 [Pa]."))
		((Real, poisson, 0.45, Attr::triggerPostLoad, "Poisson's ratio at small strain, in (-1, 0.5) [-]. Below 0 grains soften under pressure and collapse: doc/user_guide.md, 'Materials and interfaces'."))
		((Real, frictionAngle, 0, Attr::triggerPostLoad, "Angle of Coulomb friction, in [0, π/2) [rad]. The smaller one of two bodies in contact counts, as everywhere in YADE; it is read when the contact is made."))
		((string, law, "neoHookean", Attr::triggerPostLoad, "Constitutive law: 'neoHookean', the compressible neo-Hookean solid P = μ(F − F⁻ᵀ) + λ ln J F⁻ᵀ."))
		((string, condition, "planeStrain", Attr::triggerPostLoad, "What closes the third dimension of 2D grains: 'planeStrain' (F₃₃ = 1) or 'planeStress' (P₃₃ = 0 at every point). 3D grains do not use it."))
		((Real, massDamping, 0, Attr::triggerPostLoad, "Viscous damping α (the mass-proportional term of Rayleigh damping), ≥ 0 [1/s]: velocities of a grain relative to its own rigid motion decay as exp(−α t), so a vibration of angular frequency ω has the damping ratio α/(2 ω). Flight, rotation and all momenta stay as they are; static answers do not change. 0: none, at no cost. Doc: doc/theory.md, Damping."))
		((Real, stiffnessDamping, 0, Attr::triggerPostLoad, "Stiffness-proportional (Kelvin-Voigt) term β of Rayleigh damping, ≥ 0 [s]: stress F S with S = β (λ tr Ė 1 + 2 μ Ė), Ė the rate of Green's strain; damping ratio β ω/2. Shortens the critical time step, to dt_c (√(1 + ξ²) − ξ) with ξ = β/dt_c, which the check of the step knows. 0: none, at no cost."))
		((Real, massScaling, 1, Attr::triggerPostLoad, "Factor on the density that inertia sees, ≥ 1 [-], for quasi-static loading: the critical time step grows with its square root, weight (gravity) and forces stay as they are, and whatever moves is so much more inert. :yref:`State.mass` and kinetic energies show the scaled mass. See sg.scale_mass().")),
		createIndex();,
		.def("waveImpedance", &SoftMat::waveImpedance, "Density, scaled (*massScaling*), times the speed of pressure waves in the undeformed grain [Pa s/m], by the dimension of the grain, 2 or 3: stress over velocity in such a wave.")
	);
	// clang-format on
	REGISTER_CLASS_INDEX(SoftMat, Material);
};
REGISTER_SERIALIZABLE(SoftMat);

} // namespace yade
