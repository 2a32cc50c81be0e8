#include "grain/Damper.hpp"
#include "grain/BlockField.hpp"
#include "grain/Observables.hpp"
#include "material/NeoHookean.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// What differs from lane to lane: beta times the small-strain stiffness, and scales.
struct ViscousLanes {
	Lanes lambda, mu; ///< Pa s
	Lanes inverseRadius, volumeOverRadius;
};

template <int dim> ViscousLanes viscousLanes(const Batch<dim>& batch, int block)
{
	ViscousLanes lanes;
	for (int l = 0; l < laneWidth; ++l) {
		const int g = batch.grainInLane(block, l);
		const GrainParameters<dim>& grain = batch.grain[g];
		lanes.lambda[l] =
			grain.damping.stiffness * grain.constants.effectiveLambda(batch.condition);
		lanes.mu[l] = grain.damping.stiffness * grain.constants.mu();
		lanes.inverseRadius[l] = 1 / grain.radius;
		lanes.volumeOverRadius[l] = batch.pointScale[g] / grain.radius;
	}
	return lanes;
}

template <int dim> bool isViscous(const Batch<dim>& batch, int block)
{
	for (int l = 0; l < laneWidth; ++l)
		if (batch.grain[batch.grainInLane(block, l)].damping.stiffness > 0) return true;
	return false;
}

/// sum_I field_I (x) G_I at a point.
template <int dim>
void gather(const GrainTemplate<dim>& reference, const BlockField<dim>& field, int p,
	    const Lanes& inverseRadius, Lanes (&gradient)[dim][dim])
{
	Lanes sum[dim][dim] = {};
	const auto& shapes = reference.pointShapes;
	for (int k = shapes.begin(p); k < shapes.end(p); ++k)
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				sum[a][b] += field.at(shapes.column[k], a) * shapes.value[k].G[b];
	for (int a = 0; a < dim; ++a)
		for (int b = 0; b < dim; ++b)
			gradient[a][b] = sum[a][b] * inverseRadius;
}

/// Strain and strain rate of a point.
template <int dim> struct Rate {
	Lanes F[dim][dim], velocity[dim][dim];

	Lanes trace() const
	{
		Lanes sum = {};
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				sum += F[a][b] * velocity[a][b];
		return sum;
	}
	/// P = F S, with `trace` in the place of tr(E').
	void stress(const ViscousLanes& lanes, const Lanes& trace, Lanes (&P)[dim][dim]) const
	{
		Lanes S[dim][dim];
		for (int b = 0; b < dim; ++b)
			for (int c = 0; c < dim; ++c) {
				Lanes twice = {};
				for (int a = 0; a < dim; ++a)
					twice +=
						F[a][b] * velocity[a][c] + F[a][c] * velocity[a][b];
				S[b][c] = lanes.mu * twice;
				if (b == c) S[b][c] += lanes.lambda * trace;
			}
		for (int a = 0; a < dim; ++a)
			for (int c = 0; c < dim; ++c) {
				P[a][c] = Lanes {};
				for (int b = 0; b < dim; ++b)
					P[a][c] += F[a][b] * S[b][c];
			}
	}
};

template <int dim> class ViscousBlock {
public:
	ViscousBlock(const Batch<dim>& batch, int block)
		: reference_(*batch.reference)
		, lanes_(viscousLanes(batch, block))
		, x_(reference_.nodes())
		, v_(reference_.nodes())
	{
		x_.load(batch.x, batch, block);
		v_.load(batch.v, batch, block);
	}

	/// Raises `stretch` to the largest squared stretch.
	void addForces(BlockField<dim>& force, Lanes& stretch)
	{
		const bool projected = !reference_.pressureSpace.empty();
		if (projected) projectTraces();
		Rate<dim> rate;
		for (int p = 0; p < reference_.points(); ++p) {
			gatherRate(p, rate);
			Lanes P[dim][dim];
			rate.stress(lanes_,
				    projected ? loadLanes(&trace_[p * laneWidth]) : rate.trace(),
				    P);
			stretch = larger(detail::largestSquaredStretch(rate.F), stretch);
			scatter(p, P, force);
		}
	}

private:
	void gatherRate(int p, Rate<dim>& rate) const
	{
		gather(reference_, x_, p, lanes_.inverseRadius, rate.F);
		gather(reference_, v_, p, lanes_.inverseRadius, rate.velocity);
	}
	/// As the volumetric strain of the law: else this term would lock, and damp stiffer modes
	/// than there are.
	void projectTraces()
	{
		trace_.resize(static_cast<std::size_t>(reference_.points()) * laneWidth);
		Rate<dim> rate;
		for (int p = 0; p < reference_.points(); ++p) {
			gatherRate(p, rate);
			storeLanes(&trace_[p * laneWidth], rate.trace());
		}
		project<laneWidth>(reference_.pressureSpace, reference_.pointVolume, trace_.data());
	}
	/// f_I -= Vp0 P G_I
	void scatter(int p, const Lanes (&P)[dim][dim], BlockField<dim>& force) const
	{
		const Lanes weight = reference_.pointVolume[p] * lanes_.volumeOverRadius;
		const auto& shapes = reference_.pointShapes;
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			for (int a = 0; a < dim; ++a) {
				Lanes sum = {};
				for (int b = 0; b < dim; ++b)
					sum += P[a][b] * shapes.value[k].G[b];
				force.at(shapes.column[k], a) -= weight * sum;
			}
	}

	const GrainTemplate<dim>& reference_;
	ViscousLanes lanes_;
	BlockField<dim> x_, v_;
	std::vector<double> trace_; ///< projected, [point][lane]
};

template <int dim>
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void forceOfBlock(const Batch<dim>& batch, int block,
						     NodalField<dim>& to,
						     std::vector<double>& rateStiffening)
{
	BlockField<dim> force(batch.reference->nodes());
	Lanes stretch = Lanes {} + 1;
	ViscousBlock<dim>(batch, block).addForces(force, stretch);
	force.store(to, batch, block);
	for (int l = 0; l < laneWidth && batch.hasGrain(block, l); ++l)
		rateStiffening[batch.grainInLane(block, l)] = stretch[l];
}

} // namespace

template <int dim>
Damper<dim>::Damper(const Batch<dim>& batch)
	: nodes_(batch.reference->nodes())
	, rateStiffening_(batch.grains(), 1.)
{
	force_.resize(batch.grains(), nodes_);
	impulse_.resize(batch.grains(), nodes_);
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
		if (isViscous(batch, b)) forceOfBlock(batch, b, force_, rateStiffening_);
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

template <int dim> void Damper<dim>::append(int g, std::vector<double>& numbers) const
{
	numbers.push_back(rateStiffening_[g]);
	appendField(force_, g, nodes_, numbers);
}

template <int dim> void Damper<dim>::restore(int g, const double* numbers)
{
	rateStiffening_[g] = *numbers++;
	setField(force_, g, nodes_, numbers);
}

template <int dim> void Damper<dim>::addMassDamping(const Batch<dim>& batch, int g, double kick)
{
	const double share = -std::expm1(-batch.grain[g].damping.mass * kick);
	const WholeGrain<dim> whole = wholeGrain(batch, g);
	const Mat<dim> spin = spinMatrix<dim>(whole.angularVelocity);
	const Vec<dim>*x = batch.x.of(g), *v = batch.v.of(g);
	Vec<dim>* impulse = impulse_.of(g);
	for (int I = 0; I < nodes_; ++I) {
		const Vec<dim> rigid = whole.velocity + spin * (x[I] - whole.centre);
		impulse[I] -= share * batch.nodeMass(g, I) * (v[I] - rigid);
	}
}

template <int dim> void Damper<dim>::addImpulses(Batch<dim>& batch, int g, double kick)
{
	const Vec<dim>* force = force_.of(g);
	Vec<dim>*impulse = impulse_.of(g), *vNext = batch.vNext.of(g);
	for (int I = 0; I < nodes_; ++I)
		impulse[I] = kick * force[I];
	if (batch.grain[g].damping.mass > 0) addMassDamping(batch, g, kick);
	const double inverseScale = 1 / batch.massScale[g];
	for (int I = 0; I < nodes_; ++I)
		addScaled<dim>(vNext[I], inverseScale * batch.reference->inverseNodeMass[I],
			       impulse[I]);
}

template <int dim>
void Damper<dim>::addLoss(const Batch<dim>& batch, int g, double& before, double& after) const
{
	const Vec<dim>*impulse = impulse_.of(g), *v = batch.v.of(g), *vNext = batch.vNext.of(g);
	for (int I = 0; I < nodes_; ++I) {
		before -= 0.5 * impulse[I].dot(v[I]);
		after -= 0.5 * impulse[I].dot(vNext[I]);
	}
}

template class Damper<2>;
template class Damper<3>;

} // namespace softgrain
