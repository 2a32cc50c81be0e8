// How far contacts are solved, and how overlaps are worked off.
#pragma once

namespace softgrain {

struct SolverSettings {
	/// Residual (ResidualSum) at which sweeps end: doc/decisions/0002-sweep-tolerance.md.
	double tolerance = 1e-2;
	int maxSweeps = 100; ///< cap; steps that hit it are counted
	/// Share of an overlap that is worked off per step. All at once would throw the grains
	/// apart.
	double overlapRelaxation = 0.1;
	/// Cap on the speed at which overlaps are worked off, m/s.
	double overlapSpeed = 1e300;
};

} // namespace softgrain
