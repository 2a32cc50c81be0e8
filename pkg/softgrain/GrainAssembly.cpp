#include "GrainAssembly.hpp"
#include "grain/InternalForce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

namespace softgrain {

namespace {

template <int dim> Vec<dim> toKernel(const Vec3& v) { return v.head<dim>(); }
template <int dim> Vec3 toSpace(const Vec<dim>& v, double z = 0)
{
	Vec3 result(0, 0, z);
	result.head<dim>() = v;
	return result;
}
template <int dim> Mat3 toSpace(const Mat<dim>& m)
{
	Mat3 result = Mat3::Zero();
	result.topLeftCorner<dim, dim>() = m;
	return result;
}
template <int dim> typename WholeGrain<dim>::Angular angularToKernel(const Vec3& omega)
{
	if constexpr (dim == 2)
		return typename WholeGrain<2>::Angular(omega[2]);
	else
		return omega;
}
template <int dim> Vec3 angularToSpace(const typename WholeGrain<dim>::Angular& omega)
{
	if constexpr (dim == 2)
		return Vec3(0, 0, omega[0]);
	else
		return omega;
}
template <int dim> Mat<dim> rotationToKernel(const Rotation& q)
{
	return q.toRotationMatrix().template topLeftCorner<dim, dim>();
}

template <int dim> class PairContactsOf : public PairContacts {
public:
	PairContactsOf(const System<dim>& system, double z)
		: system_(&system)
		, z_(z)
	{
	}
	bool hasContact() const override { return !list.contacts.empty() || list.deepest > 0; }
	double deepest() const override { return list.deepest; }
	void setFriction(double coefficient) override { list.friction = coefficient; }

	std::vector<ContactRecord> records() const override
	{
		std::vector<ContactRecord> result;
		for (const Contact<dim>& c : list.contacts) {
			const int grain = c.key.side == 0 ? list.first : list.second;
			result.push_back(
				{ c.key,
				  toSpace<dim>(system_->body(grain).position[c.key.node], z_),
				  toSpace<dim>(c.normal), toSpace<dim>(c.impulse), c.gap });
		}
		return result;
	}

	void restore(const std::vector<ContactRecord>& saved) override
	{
		list.contacts.clear();
		for (const ContactRecord& record : saved) {
			Contact<dim> c;
			c.key = record.key;
			c.impulse = toKernel<dim>(record.impulse);
			list.contacts.push_back(c);
		}
	}

	ContactList<dim> list;

private:
	const System<dim>* system_;
	double z_;
};

template <int dim> class GrainAssemblyOf : public GrainAssembly {
public:
	explicit GrainAssemblyOf(const std::vector<GrainDescription>& grains)
		: z_(dim == 2 ? grains.front().position[2] : 0.)
	{
		for (const GrainDescription& d : grains)
			if (dim == 2 && std::abs(d.position[2] - z_) > 1e-6 * d.radius)
				throw std::invalid_argument(
					"grain #" + std::to_string(d.id) +
					": 2D soft grains must lie in one plane z = const");
		addBatches(grains);
		system_.updateSurfaces(1);
	}

	int grains() const override { return system_.grains(); }
	int idOf(int g) const override { return id_[g]; }
	double criticalTimeStep() const override { return system_.criticalTimeStep(); }
	double pointSpacing(int g) const override { return system_.body(g).pointSpacing; }
	double slowestWave() const override
	{
		double slowest = std::numeric_limits<double>::infinity();
		for (int g = 0; g < grains(); ++g) {
			const Batch<dim>& batch = system_.batchOf(g);
			slowest = std::min(slowest,
					   batch.grain[system_.laneOf(g)].constants.waveSpeed(
						   batch.condition));
		}
		return slowest;
	}
	void updateForces(int threads) override { system_.updateForces(threads); }
	double stiffening() const override { return system_.stiffening(); }

	std::unique_ptr<PairContacts> newPair() const override
	{
		return std::make_unique<PairContactsOf<dim>>(system_, z_);
	}

	void search(PairContacts& pair, int first, int second, double dt) const override
	{
		ContactList<dim>& list = listOf(pair);
		list.first = first;
		list.second = second;
		findContacts(system_.body(first), system_.body(second),
			     system_.reach(first, second, dt), list);
	}

	void search(PairContacts& pair, int g, const WallDescription& wall,
		    double dt) const override
	{
		ContactList<dim>& list = listOf(pair);
		list.first = g;
		list.second = -1 - wall.id;
		list.plane = { toKernel<dim>(wall.point), toKernel<dim>(wall.normal),
			       toKernel<dim>(wall.velocity) };
		findContacts(system_.body(g), system_.reach(g, list.plane, dt), list);
	}

	StepReport step(const StepSettings& settings,
			const std::vector<PairContacts*>& pairs) override
	{
		std::vector<ContactList<dim>*> lists;
		for (PairContacts* pair : pairs)
			lists.push_back(&listOf(*pair));
		return system_.step(settings, lists);
	}

	void setLoad(int g, const Vec3& acceleration, const Vec3& angularAcceleration) override
	{
		system_.loads()[g] = { toKernel<dim>(acceleration),
				       spinMatrix<dim>(angularToKernel<dim>(angularAcceleration)) };
	}

	GrainMotion motion(int g) const override
	{
		const Batch<dim>& batch = system_.batchOf(g);
		const WholeGrain<dim> whole = wholeGrain(batch, system_.laneOf(g));
		GrainMotion m;
		m.mass = whole.mass;
		m.inertia = whole.inertia.trace() / whole.inertia.rows();
		m.position = toSpace<dim>(
			Vec<dim>(batch.grain[system_.laneOf(g)].origin + whole.centre), z_);
		m.velocity = toSpace<dim>(whole.velocity);
		m.angularVelocity = angularToSpace<dim>(whole.angularVelocity);
		Mat3 rotation = toSpace<dim>(whole.rotation);
		if (dim == 2) rotation(2, 2) = 1;
		m.orientation = Rotation(rotation);
		return m;
	}

	void moveRigidly(int g, const Rotation& turn, const Vec3& shift, const Vec3& velocity,
			 const Vec3& angularVelocity) override
	{
		Batch<dim>& batch = system_.batchOf(g);
		const int lane = system_.laneOf(g);
		batch.moveRigidly(lane, wholeGrain(batch, lane).centre, rotationToKernel<dim>(turn),
				  toKernel<dim>(shift), toKernel<dim>(velocity),
				  spinMatrix<dim>(angularToKernel<dim>(angularVelocity)));
		system_.updateSurface(g);
		system_.invalidateForces();
	}

	EnergyBalance energy() const override { return system_.energy(); }
	Continuation continuation() const override { return system_.continuation(); }
	void continueFrom(const Continuation& state) override { system_.continueFrom(state); }

	Box<3> box(int g) const override
	{
		const Box<dim>& b = system_.body(g).box;
		Box<3> result { toSpace<dim>(b.low, z_), toSpace<dim>(b.high, z_) };
		if (dim == 2) { // as thick as the grain is wide, as for a sphere of YADE
			const double R = system_.batchOf(g).grain[system_.laneOf(g)].radius;
			result.low[2] -= R;
			result.high[2] += R;
		}
		return result;
	}

	std::vector<Vec3> outline(int g) const override
	{
		std::vector<Vec3> result;
		for (const Vec<dim>& x : system_.body(g).position)
			result.push_back(toSpace<dim>(x, z_));
		return result;
	}

	PointFields points(int g) const override
	{
		const Batch<dim>& batch = system_.batchOf(g);
		const int lane = system_.laneOf(g);
		const auto& shapes = batch.reference->pointShapes;
		PointFields fields;
		int p = 0;
		for (const PointResponse<dim>& response : pointResponses(batch, lane)) {
			Vec<dim> x = batch.grain[lane].origin;
			for (int k = shapes.begin(p); k < shapes.end(p); ++k)
				x += shapes.value[k].N * batch.x.get(lane, shapes.column[k]);
			fields.position.push_back(toSpace<dim>(x, z_));
			Mat3 F = toSpace<dim>(response.F), cauchy = toSpace<dim>(response.cauchy);
			if (dim == 2) {
				F(2, 2) = response.F33;
				cauchy(2, 2) = response.cauchy33;
			}
			fields.F.push_back(F);
			fields.cauchy.push_back(cauchy);
			fields.volume.push_back(batch.pointScale[lane] *
						batch.reference->pointVolume[p] * response.J);
			++p;
		}
		return fields;
	}

	void nodalState(int g, Vec3& origin, std::vector<double>& x,
			std::vector<double>& v) const override
	{
		const Batch<dim>& batch = system_.batchOf(g);
		const int lane = system_.laneOf(g);
		origin = toSpace<dim>(batch.grain[lane].origin, z_);
		x.clear();
		v.clear();
		for (int I = 0; I < batch.reference->nodes(); ++I)
			for (int a = 0; a < dim; ++a) {
				x.push_back(batch.x.get(lane, I)[a]);
				v.push_back(batch.v.get(lane, I)[a]);
			}
	}

private:
	static ContactList<dim>& listOf(PairContacts& pair)
	{
		return static_cast<PairContactsOf<dim>&>(pair).list;
	}

	/// Grains with equal recipe, law and condition form a batch; batches keep the order of ids
	/// within.
	void addBatches(const std::vector<GrainDescription>& grains)
	{
		using Kind = std::tuple<TemplateRecipe, Law, Condition>;
		std::map<Kind, std::vector<const GrainDescription*>> kinds;
		for (const GrainDescription& d : grains)
			kinds[{ d.recipe, d.law, d.condition }].push_back(&d);
		for (const auto& [kind, members] : kinds) {
			const auto& [recipe, law, condition] = kind;
			std::vector<GrainParameters<dim>> parameters;
			for (const GrainDescription* d : members)
				parameters.push_back(
					{ d->radius, d->constants,
					  toKernel<dim>(d->x.empty() ? d->position : d->origin) });
			Batch<dim> batch(makeGrainTemplate<dim>(recipe), law, condition,
					 parameters);
			for (int lane = 0; lane < batch.grains(); ++lane) {
				setState(batch, lane, *members[lane]);
				id_.push_back(members[lane]->id);
			}
			system_.addBatch(std::move(batch));
		}
	}

	static void setState(Batch<dim>& batch, int lane, const GrainDescription& d)
	{
		if (d.x.empty()) {
			batch.place(lane, rotationToKernel<dim>(d.orientation),
				    toKernel<dim>(d.velocity),
				    spinMatrix<dim>(angularToKernel<dim>(d.angularVelocity)));
			return;
		}
		const std::size_t expected =
			static_cast<std::size_t>(batch.reference->nodes()) * dim;
		if (d.x.size() != expected || d.v.size() != expected)
			throw std::invalid_argument(
				"grain #" + std::to_string(d.id) + ": its saved nodal state has " +
				std::to_string(d.x.size()) + " numbers, its discretisation needs " +
				std::to_string(expected) +
				"; discretisation parameters cannot be changed after the first "
				"step");
		for (int I = 0; I < batch.reference->nodes(); ++I) {
			batch.x.set(lane, I, Eigen::Map<const Vec<dim>>(&d.x[I * dim]));
			batch.v.set(lane, I, Eigen::Map<const Vec<dim>>(&d.v[I * dim]));
		}
	}

	System<dim> system_;
	std::vector<int> id_; ///< of the YADE body by index in the system
	double z_;
};

} // namespace

std::shared_ptr<GrainAssembly> GrainAssembly::create(const std::vector<GrainDescription>& grains)
{
	if (grains.empty()) throw std::invalid_argument("there is no soft grain to assemble");
	for (const GrainDescription& d : grains) {
		const GrainDescription& first = grains.front();
		if (d.dim != first.dim)
			throw std::invalid_argument(
				"grains #" + std::to_string(first.id) + " and #" +
				std::to_string(d.id) +
				" have different dim; a scene is either 2D or 3D");
		if (d.recipe.contact != first.recipe.contact)
			throw std::invalid_argument("grains #" + std::to_string(first.id) +
						    " and #" + std::to_string(d.id) +
						    " have different contact geometries; a scene "
						    "uses 'surface' or 'points' for all");
	}
	if (grains.front().dim == 2) return std::make_shared<GrainAssemblyOf<2>>(grains);
	return std::make_shared<GrainAssemblyOf<3>>(grains);
}

} // namespace softgrain
