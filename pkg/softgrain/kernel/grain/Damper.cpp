#include "grain/Damper.hpp"
#include "grain/BulkPass.hpp"
#include "grain/Observables.hpp"
#include "material/Kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// beta times the small-strain stiffness, lane by lane; 0 in lanes without a grain.
struct Viscosity {
	Lanes lambda = {}, mu = {}; ///< Pa s
};

template <int dim, class Side> Viscosity viscosityOf(const Batch<dim>& batch, const Side& side)
{
	Viscosity viscosity;
	side.forEachGrain(batch, [&](int g, int begin, int end) {
		const GrainParameters<dim>& grain = batch.grain[g];
		const double beta = grain.damping.stiffness;
		for (int l = begin; l < end; ++l) {
			viscosity.lambda[l] =
				beta * grain.constants.effectiveLambda(batch.condition);
			viscosity.mu[l] = beta * grain.constants.mu();
		}
	});
	return viscosity;
}

template <int dim> bool isViscous(const Batch<dim>& batch, int block)
{
	for (int l = 0; l < batch.grainsInBlock(block); ++l)
		if (batch.grain[batch.grainInLane(block, l)].damping.stiffness > 0) return true;
	return false;
}

/// tr(E')
template <int dim> Lanes traceOf(const Lanes (&F)[dim][dim], const Lanes (&rate)[dim][dim])
{
	Lanes sum = {};
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			sum += F[a][b] * rate[a][b];
	return sum;
}

/// F becomes V F S, with `trace` in the place of tr(E').
template <int dim>
void becomeStress(Lanes (&F)[dim][dim], const Lanes (&rate)[dim][dim], const Viscosity& viscosity,
		  const Lanes& trace, const Lanes& V)
{
	Lanes S[dim][dim];
	for (int b = 0; b < dim; ++b)
		for (int c = b; c < dim; ++c) {
			Lanes twice = {};
			for (int a = 0; a < dim; ++a)
				twice += F[a][b] * rate[a][c] + F[a][c] * rate[a][b];
			S[b][c] = V * (viscosity.mu * twice);
			if (b == c) S[b][c] += V * (viscosity.lambda * trace);
			S[c][b] = S[b][c];
		}
	for (int a = 0; a < dim; ++a) {
		Lanes P[dim] = {};
		for (int c = 0; c < dim; ++c)
			for (int b = 0; b < dim; ++b)
				P[c] += F[a][b] * S[b][c];
		for (int c = 0; c < dim; ++c)
			F[a][c] = P[c];
	}
}

/// The second term for what a side has in its lanes.
template <int dim, class Side> class ViscousPass {
public:
	ViscousPass(const Batch<dim>& batch, Side positions, Side velocities)
		: batch_(batch)
		, reference_(*batch.reference)
		, positions_(std::move(positions))
		, velocities_(std::move(velocities))
		, viscosity_(viscosityOf(batch, positions_))
	{
	}

	/// Tells the largest squared stretch of each grain besides.
	void computeForces(NodalField<dim>& to, std::vector<double>& largestStretch)
	{
		const bool projected = !reference_.pressureSpace.empty();
		if (projected) projectTraces();
		auto forces = positions_.noForces();
		Lanes stretch = Lanes {} + 1;
		forEachStripOfBoth([&] {
			for (int group = 0; group < F_.groups; ++group)
				evaluate(group, projected, stretch);
			positions_.scatter(F_, forces);
		});
		positions_.storeForces(forces, batch_, to);
		positions_.forEachGrain(batch_, [&](int g, int begin, int end) {
			largestStretch[g] = 1;
			for (int l = begin; l < end; ++l)
				largestStretch[g] = std::max(largestStretch[g], stretch[l]);
		});
	}

private:
	template <class Use> void forEachStripOfBoth(Use&& use)
	{
		forEachStrip(positions_, reference_.pointLines, F_, [&] {
			rate_.lines = F_.lines;
			velocities_.gather(rate_);
			use();
		});
	}
	SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void evaluate(int group, bool projected, Lanes& stretch)
	{
		auto &F = F_.tensor[group], &rate = rate_.tensor[group];
		stretch = larger(largestSquaredStretch(F), stretch);
		const Lanes trace =
			projected ? trace_.template part<WholeLanes>(positions_, F_, group, 0)
				  : traceOf<dim>(F, rate);
		becomeStress<dim>(F, rate, viscosity_, trace,
				  positions_.template volume<WholeLanes>(F_, group, 0));
	}
	/// As the volumetric strain of the law: else this term would lock, and damp stiffer modes
	/// than there are.
	void projectTraces()
	{
		trace_.resize<Side>(reference_);
		forEachStripOfBoth([&] { findTraces(); });
		trace_.project<Side>(reference_);
	}
	SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void findTraces()
	{
		for (int group = 0; group < F_.groups; ++group)
			trace_.set(positions_, F_, group,
				   traceOf<dim>(F_.tensor[group], rate_.tensor[group]));
	}

	const Batch<dim>& batch_;
	const GrainTemplate<dim>& reference_;
	Side positions_, velocities_;
	Viscosity viscosity_;
	Strip<dim> F_, rate_;
	ProjectedField trace_; ///< of projected grains
};

} // namespace

template <int dim>
Damper<dim>::Damper(const Batch<dim>& batch)
	: nodes_(batch.reference->nodes())
	, rateStiffening_(batch.grains(), 1.)
{
	force_.resize(batch.grains(), nodes_);
}

template <int dim> bool Damper<dim>::isNeeded(const Batch<dim>& batch)
{
	return std::any_of(batch.grain.begin(), batch.grain.end(),
			   [](const GrainParameters<dim>& grain) { return grain.damping.acts(); });
}

template <int dim> void Damper<dim>::updateForces(const Batch<dim>& batch, int threads)
{
	const int blocks = batch.activeBlocks();
#pragma omp parallel for schedule(static) num_threads(threads)
	for (int b = 0; b < blocks; ++b) {
		if (!isViscous(batch, b)) continue;
		forEachSide(batch, b, [&](auto&& sideOf) {
			ViscousPass pass(batch, sideOf(batch.x), sideOf(batch.v));
			pass.computeForces(force_, rateStiffening_);
		});
	}
}

template <int dim> void Damper<dim>::stop(int g)
{
	std::fill_n(force_.of(g), nodes_, Vec<dim>::Zero());
}

template <int dim> void Damper<dim>::forget(int g)
{
	stop(g);
	rateStiffening_[g] = 1;
}

template <int dim> std::vector<double> Damper<dim>::numbers(int g) const
{
	return numbersOf(rateStiffening_[g], force_.allOf(g));
}

template <int dim> void Damper<dim>::restore(int g, NumbersInTurn& saved)
{
	saved.take(rateStiffening_[g], force_.allOf(g));
}

namespace {

/// The first term: velocities come nearer to those of the grain's rigid motion by a share.
template <int dim> struct MassDamping {
	double share;
	RigidVelocities<dim> rigid;

	MassDamping(const Batch<dim>& batch, int g, double kick)
		: share(-std::expm1(-batch.grain[g].damping.mass * kick))
	{
		if (share > 0) rigid = wholeGrain(batch, g).rigidVelocities();
	}
	/// Of the velocity of a node at x.
	Vec<dim> change(const Vec<dim>& x, const Vec<dim>& v) const
	{
		return share * (rigid.at(x) - v);
	}
};

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void addMassDamping(Batch<dim>& batch, int g,
						       const MassDamping<dim>& damping)
{
	const Vec<dim>*x = batch.x.of(g), *v = batch.v.of(g);
	Vec<dim>* vNext = batch.vNext.of(g);
	for (int I = 0, nodes = batch.reference->nodes(); I < nodes; ++I)
		vNext[I] += damping.change(x[I], v[I]);
}

} // namespace

template <int dim> void Damper<dim>::addImpulses(Batch<dim>& batch, int g, double kick) const
{
	const MassDamping<dim> damping(batch, g, kick);
	if (damping.share > 0) addMassDamping(batch, g, damping);
	if (batch.grain[g].damping.stiffness == 0) return;
	const double scale = kick / batch.massScale[g];
	const Vec<dim>* force = force_.of(g);
	Vec<dim>* vNext = batch.vNext.of(g);
	for (int I = 0; I < nodes_; ++I)
		addScaled<dim>(vNext[I], scale * batch.reference->inverseNodeMass[I], force[I]);
}

template <int dim>
void Damper<dim>::addLoss(const Batch<dim>& batch, int g, double kick, double& before,
			  double& after) const
{
	const MassDamping<dim> damping(batch, g, kick);
	const Vec<dim>*force = force_.of(g), *x = batch.x.of(g), *v = batch.v.of(g),
	      *vNext = batch.vNext.of(g);
	for (int I = 0; I < nodes_; ++I) {
		const Vec<dim> impulse =
			kick * force[I] + batch.nodeMass(g, I) * damping.change(x[I], v[I]);
		before -= 0.5 * impulse.dot(v[I]);
		after -= 0.5 * impulse.dot(vNext[I]);
	}
}

template class Damper<2>;
template class Damper<3>;

} // namespace softgrain
