#include "grain/HighestFrequency.hpp"
#include "grain/InternalForce.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace softgrain {

namespace {

/// Of Lanczos' iteration: the square of the frequency is then within 0.2 %, 1.6 % and 6.5 % from
/// below (doc/decisions/0003-time-step.md). Times these it has what it may lack, and a little more.
constexpr int exactIterations = 40, quickIterations = 24, earlyIterations = 8;
constexpr double raiseConverged = 1.01, raiseEarly = 1.04;

/// Of the node that moves most, in differences of forces, over the radius.
constexpr double displacement = 1e-6;

/// Fixed: the same grain gives the same time step.
Eigen::VectorXd randomDirection(int size)
{
	std::mt19937 generator(1);
	Eigen::VectorXd q = Eigen::VectorXd::Zero(size);
	for (double& number : q)
		number = 2. * generator() / static_cast<double>(std::mt19937::max()) - 1;
	return q.normalized();
}

/// Largest eigenvalue, from below, of M^-1/2 K M^-1/2 of a grain in its present shape: symmetric,
/// its eigenvalues are squares of angular frequencies. Forces of displaced shapes are computed by
/// somebody else.
template <int dim> class Lanczos {
public:
	/// With the forces of the present shape; of so many iterations at most.
	Lanczos(const Batch<dim>& batch, int g, const Vec<dim>* force, int most)
		: grain_(g)
		, radius_(batch.grain[g].radius)
		, x_(numbersOf(batch.x.of(g), batch.reference->nodes()))
		, force_(numbersOf(force, batch.reference->nodes()))
		, rootOfMobility_(size())
		, q_(randomDirection(size()))
		, before_(q_)
		, diagonal_(most)
		, beside_(most)
	{
		for (int i = 0; i < size(); ++i)
			rootOfMobility_[i] = 1 / std::sqrt(batch.nodeMass(g, i / dim));
	}
	int grain() const { return grain_; }
	bool isDone(int iterations) const
	{
		const bool exact = found_ > 0 && beside_[found_ - 1] == 0;
		return exact || found_ == std::min(iterations, size());
	}
	/// An iteration: the shape whose forces it asks for, and those.
	void displace(Vec<dim>* x)
	{
		const Eigen::ArrayXd u = q_.array() * rootOfMobility_;
		step_ = displacement * radius_ / u.abs().maxCoeff();
		Eigen::Map<Eigen::ArrayXd>(x->data(), size()) = x_ + step_ * u;
	}
	void iterate(const Vec<dim>* force)
	{
		Eigen::VectorXd next =
			(force_ - numbersOf(force, size() / dim)) / step_ * rootOfMobility_;
		diagonal_[found_] = next.dot(q_);
		next -= diagonal_[found_] * q_;
		if (found_ > 0) next -= beside_[found_ - 1] * before_;
		beside_[found_] = next.norm();
		++found_;
		before_ = q_;
		q_ = next / beside_[found_ - 1];
	}
	double largest() const
	{
		Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
		solver.computeFromTridiagonal(diagonal_.head(found_), beside_.head(found_ - 1),
					      Eigen::EigenvaluesOnly);
		return solver.eigenvalues()[found_ - 1];
	}

private:
	int size() const { return static_cast<int>(x_.size()); }
	/// Of all nodes, component by component.
	static Eigen::Map<const Eigen::ArrayXd> numbersOf(const Vec<dim>* field, int nodes)
	{
		return { field->data(), nodes * dim };
	}

	int grain_;
	double radius_, step_ = 0;
	Eigen::ArrayXd x_, force_, rootOfMobility_;
	Eigen::VectorXd q_, before_;
	Eigen::VectorXd diagonal_, beside_; ///< of the tridiagonal matrix
	int found_ = 0;
};

template <int dim>
std::vector<Lanczos<dim>> beginAll(const Batch<dim>& batch, const std::vector<int>& grains,
				   int most)
{
	Batch<dim> present = batch.copyOf(grains);
	const int count = static_cast<int>(grains.size());
	computeInternalForce(present, 1);
	std::vector<Lanczos<dim>> begun;
	for (int k = 0; k < count; ++k)
		begun.emplace_back(batch, grains[k], present.force.of(k), most);
	return begun;
}

/// Until each has made so many.
template <int dim>
void iterateAll(const Batch<dim>& batch, const std::vector<Lanczos<dim>*>& all, int iterations)
{
	std::vector<int> grains;
	for (const Lanczos<dim>* lanczos : all)
		grains.push_back(lanczos->grain());
	Batch<dim> displaced = batch.copyOf(grains);
	auto forEachLeft = [&](auto&& use) {
		bool any = false;
		for (std::size_t k = 0; k < all.size(); ++k) {
			if (all[k]->isDone(iterations)) continue;
			use(*all[k], static_cast<int>(k));
			any = true;
		}
		return any;
	};
	while (forEachLeft([&](auto& left, int k) { left.displace(displaced.x.of(k)); })) {
		computeInternalForce(displaced, 1);
		forEachLeft([&](auto& left, int k) { left.iterate(displaced.force.of(k)); });
	}
}

} // namespace

template <int dim> double highestFrequency(const Batch<dim>& batch, int g)
{
	std::vector<Lanczos<dim>> alone = beginAll(batch, { g }, exactIterations);
	iterateAll<dim>(batch, { &alone[0] }, exactIterations);
	return raiseConverged * std::sqrt(alone[0].largest());
}

template <int dim>
std::vector<MeasuredFrequency>
highestFrequencies(const Batch<dim>& batch, const std::vector<int>& grains,
		   const std::function<bool(std::size_t, double)>& suffices)
{
	std::vector<Lanczos<dim>> all = beginAll(batch, grains, quickIterations);
	std::vector<Lanczos<dim>*> left;
	for (Lanczos<dim>& lanczos : all)
		left.push_back(&lanczos);
	iterateAll(batch, left, earlyIterations);
	std::vector<MeasuredFrequency> measured;
	left.clear();
	for (std::size_t k = 0; k < all.size(); ++k) {
		const double early = raiseEarly * std::sqrt(all[k].largest());
		measured.push_back({ early, earlyIterations });
		if (!suffices(k, early)) left.push_back(&all[k]);
	}
	iterateAll(batch, left, quickIterations);
	for (const Lanczos<dim>* lanczos : left)
		measured[lanczos - all.data()] = { raiseConverged * std::sqrt(lanczos->largest()),
						   quickIterations };
	return measured;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template double highestFrequency<dim>(const Batch<dim>&, int);                             \
	template std::vector<MeasuredFrequency> highestFrequencies<dim>(                           \
		const Batch<dim>&, const std::vector<int>&,                                        \
		const std::function<bool(std::size_t, double)>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
