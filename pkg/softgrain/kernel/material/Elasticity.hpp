// Elastic constants and kinematic conditions common to all laws.
#pragma once

#include "lanes/Parts.hpp"

#include <string>

namespace softgrain {

/// What closes the third dimension of a grain.
enum class Condition {
	planeStrain, ///< 2D, F33 = 1
	planeStress, ///< 2D, F33 from P33 = 0 at every point
	solid        ///< 3D
};

/// The constitutive laws, by the name users give.
enum class Law {
	neoHookean ///< compressible neo-Hookean, P = mu (F - F^-T) + lambda ln J F^-T
};

/// Throws std::invalid_argument listing the known names.
Law lawByName(const std::string& name);
/// "planeStrain" or "planeStress"; throws std::invalid_argument listing the known names.
Condition conditionByName(const std::string& name);

/// Constants of one grain's material.
struct ElasticConstants {
	double young = 1e6;    ///< Pa, > 0
	double poisson = 0.45; ///< dimensionless, in (-1, 0.5)
	double density = 1000; ///< kg/m^3, > 0

	bool operator==(const ElasticConstants& o) const
	{
		return young == o.young && poisson == o.poisson && density == o.density;
	}
	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate() const;
	/// First and second Lame constant, Pa.
	double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
	double mu() const { return 0.5 * young / (1 + poisson); }
	/// First Lame constant that acts in the plane (or space) of the grain at small strain, Pa.
	double effectiveLambda(Condition condition) const;
	/// Speed of pressure waves in the undeformed grain, m/s.
	double waveSpeed(Condition condition) const;
	/// What their stress is over the velocity of its points, Pa s/m.
	double waveImpedance(Condition condition) const { return density * waveSpeed(condition); }
};

/// Constants of the grains in a part of a block as laws use them.
template <class Part> struct LameNumbers {
	typename Part::Numbers lambda, mu; ///< Pa
	/// Square of the highest frequency that 2 mu alone gives an undeformed grain over that of
	/// all; 0 where pressure waves are the stiffest however it is deformed.
	typename Part::Numbers isochoricShare;
	bool anyIsochoric = false; ///< in some lane of the block
};

/// Of all of its grains.
struct LameConstants : LameNumbers<WholeLanes> {
	template <class Part> LameNumbers<Part> part(int begin) const
	{
		return { partOf<Part>(lambda, begin), partOf<Part>(mu, begin),
			 partOf<Part>(isochoricShare, begin), anyIsochoric };
	}
	void set(int lane, const ElasticConstants& constants, double isochoric)
	{
		lambda[lane] = constants.lambda();
		mu[lane] = constants.mu();
		isochoricShare[lane] = isochoric;
		anyIsochoric = anyIsochoric || isochoric > 0;
	}
	/// The same in all lanes.
	static LameConstants ofAll(const ElasticConstants& constants, double isochoric = 0)
	{
		LameConstants all;
		for (int l = 0; l < laneWidth; ++l)
			all.set(l, constants, isochoric);
		return all;
	}
};

} // namespace softgrain
