#include "assembly/GrainAssembly.hpp"
#include "assembly/PairContactsOf.hpp"
#include "assembly/RigidInKernel.hpp"
#include "contact/search/SelfOverlap.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace softgrain {

namespace {

template <int dim> class GrainAssemblyOf : public GrainAssembly {
public:
	/// In 2D there must be a grain.
	GrainAssemblyOf(const std::vector<GrainDescription>& grains, const GrainAssembly* last)
		: z_(dim == 2 ? grains.front().position[2] : 0.)
	{
		const auto* assembly = dynamic_cast<const GrainAssemblyOf*>(last);
		const Templates<dim> none, &known = assembly ? assembly->templates_ : none;
		for (auto& described : makeSets<dim>(grains, known, templates_))
			add(described);
		host.publishedAsleep.assign(system_.grains(), false);
		host.moved.assign(system_.grains(), true);
		system_.updateSurfaces(1);
		slowestWave_ = std::numeric_limits<double>::infinity();
		for (int g = 0; g < system_.grains(); ++g)
			slowestWave_ = std::min(
				slowestWave_,
				parameters(g).constants.waveSpeed(system_.setOf(g).condition()));
	}

	int grains() const override { return system_.grains(); }
	int templates() const override { return static_cast<int>(templates_.size()); }
	double criticalTimeStep() const override { return system_.criticalTimeStep(); }
	double presentCriticalTimeStep(double enough, int threads) override
	{
		return system_.presentCriticalTimeStep(enough, threads);
	}
	long takeMeasuredPoints() override { return system_.timeSteps().takeMeasuredPoints(); }
	void setMultirate(bool on) override { system_.setMultirate(on); }
	int rate(int g) const override { return system_.timeSteps().rate(g); }
	double pointSpacing(int g) const override
	{
		return parameters(g).radius * system_.setOf(g).reference().pointSpacing();
	}
	double kickTime(double dt) const override { return system_.kickTime(dt); }
	void limitKick(double longest) override { system_.limitKick(longest); }
	bool setInterfaceRange(double range) override
	{
		if (range == system_.surfaces().interfaceRange()) return false;
		system_.surfaces().setInterfaceRange(range);
		std::fill(host.moved.begin(), host.moved.end(), true);
		return true;
	}
	double interfaceRange() const override { return system_.surfaces().interfaceRange(); }
	double reachAtRest(int g) const override { return system_.surfaces().reachAtRest(g); }
	double slowestWave() const override { return slowestWave_; }
	void updateForces(int threads) override { system_.updateForces(threads); }
	bool isRigid(int g) const override { return system_.isRigid(g); }
	bool isAsleep(int g) const override { return system_.isAsleep(g); }

	std::unique_ptr<PairContacts> newPair() const override
	{
		return std::make_unique<PairContactsOf<dim>>(system_, z_);
	}

	void search(PairContacts& pair, int first, int second, const ImageDescription& image,
		    double dt) const override
	{
		ContactList<dim>& list = listOf(pair);
		place(list.image, image);
		list.first = first;
		list.second = second;
		search(list, dt);
	}

	bool areFarApart(int first, int second, const ImageDescription& image,
			 double dt) const override
	{
		PairImage<dim> seen;
		place(seen, image);
		return system_.surfaces().areFarApart(first, second, seen, dt);
	}

	void search(PairContacts& pair, int g, const WallDescription& wall,
		    double dt) const override
	{
		search(listOn(pair, g, wall), dt);
	}
	void separate(PairContacts& pair, int g, const WallDescription& wall) const override
	{
		ContactList<dim>& list = listOn(pair, g, wall);
		list.clearContacts();
		list.rest.changed = true; // a grain that slept on it is to wake
		countVanishedBonds(list);
	}

	/// Called where nothing may be thrown.
	void search(PairContacts& pair, int g, const RigidBodyDescription& body,
		    const std::function<std::vector<RigidBodyDescription>()>& others,
		    const ImageDescription& image, double dt) const override
	{
		ContactList<dim>& list = listOf(pair);
		place(list.image, image);
		list.first = g;
		list.second = -1 - body.id;
		list.rigid.emplace();
		const auto found = sight().find(displaced(body, image.shift));
		if (!found.surface) {
			list.clearContacts();
			list.deepest = found.refused ? std::numeric_limits<double>::infinity() : 0;
			countVanishedBonds(list);
			return;
		}
		describe(*list.rigid, *found.surface, body, list.image.shift);
		if (others) list.rigid->others = [&] { return sight().beside(body.id, others()); };
		search(list, dt);
		list.rigid->others = nullptr;
	}
	void checkRigidBody(const RigidBodyDescription& body) const override
	{
		sight().surfaceOf(body);
	}

	StepReport step(const StepSettings& settings, const std::vector<PairContacts*>& pairs,
			std::vector<RigidMotionDescription>& partners,
			std::vector<RigidContactDescription>& rigidContacts) override
	{
		listRigidContacts(rigidContacts); // first: it may refuse one
		system_.rigidPartners().clear();
		for (const RigidMotionDescription& partner : partners)
			system_.rigidPartners().push_back(partnerOf<dim>(partner));
		std::vector<ContactList<dim>*> lists;
		for (PairContacts* pair : pairs)
			lists.push_back(&listOf(*pair));
		StepReport report = system_.step(settings, lists);
		for (std::size_t k = 0; k < solvedContacts_.size(); ++k)
			solvedContacts_[k]->impulse =
				toSpace<dim>(system_.rigidContacts()[k].impulse);
		for (std::size_t k = 0; k < partners.size(); ++k) {
			partners[k].shift = toSpace<dim>(system_.rigidPartners()[k].shift);
			partners[k].turn = angularToSpace<dim>(system_.rigidPartners()[k].turn);
		}
		report.work.pairs = searchedPairs_.exchange(0);
		report.work.candidates = testedCandidates_.exchange(0);
		report.work.lostBonds = vanishedBonds_.exchange(0) - report.work.handedOnBonds;
		return report;
	}
	void forgetContactProblem() override { system_.forgetContactProblem(); }
	ContactProblemArrays contactProblem() const override
	{
		return arraysOf(system_.contactProblem());
	}

	void setLoads(const std::function<GrainLoad(int)>& loadOf, int threads) override
	{
		system_.activity().setLoads(
			[&](int g) -> BodyLoad<dim> {
				const GrainLoad load = loadOf(g);
				return { toKernel<dim>(load.acceleration),
					 spinMatrix<dim>(
						 angularToKernel<dim>(load.angularAcceleration)) };
			},
			threads);
	}

	GrainMotion motion(int g) const override
	{
		const WholeGrain<dim> whole = system_.setOf(g).whole(system_.indexInSet(g));
		GrainMotion m;
		m.mass = whole.mass;
		m.inertia = whole.inertia.trace() / whole.inertia.rows();
		m.position = toSpace<dim>(Vec<dim>(parameters(g).origin + whole.centre), z_);
		m.velocity = toSpace<dim>(whole.velocity);
		m.angularVelocity = angularToSpace<dim>(whole.angularVelocity);
		Mat3 rotation = toSpace<dim>(whole.rotation);
		if (dim == 2) rotation(2, 2) = 1;
		m.orientation = Rotation(rotation);
		return m;
	}

	Mat3 inertia(int g) const override
	{
		const WholeGrain<dim> whole = system_.setOf(g).whole(system_.indexInSet(g));
		Mat3 result = Mat3::Zero();
		result.bottomRightCorner(whole.inertia.rows(), whole.inertia.cols()) =
			whole.inertia;
		return result;
	}

	GrainLoad load(int g, const Vec3& force, const Vec3& torque) const override
	{
		const WholeGrain<dim> whole = system_.setOf(g).whole(system_.indexInSet(g));
		return { force / whole.mass, angularToSpace<dim>(whole.inertia.inverse() *
								 angularToKernel<dim>(torque)) };
	}

	void moveRigidly(int g, const Rotation& turn, const Vec3& shift, const Vec3& velocity,
			 const Vec3& angularVelocity) override
	{
		const double rim = system_.body(g).outerRadius() * angularVelocity.norm();
		// of the coming step, as far as it is known: after a load there was no last one
		const double kick = system_.kickTime(system_.continuation().lastStep);
		system_.activity().jolt(g, velocity.norm() + rim, kick);
		system_.setOf(g).moveRigidly(
			system_.indexInSet(g), rotationToKernel<dim>(turn), toKernel<dim>(shift),
			toKernel<dim>(velocity),
			spinMatrix<dim>(angularToKernel<dim>(angularVelocity)));
		system_.surfaces().update(g);
		system_.invalidateForces();
	}

	EnergyBalance energy() const override { return system_.energy(); }
	GrainEnergy energy(int g) const override
	{
		const GrainSet<dim>& set = system_.setOf(g);
		const int k = system_.indexInSet(g);
		return { set.presentKineticEnergy(k), set.report(k).elasticEnergy };
	}
	Continuation continuation() const override { return system_.continuation(); }
	void continueFrom(const Continuation& state) override { system_.continueFrom(state); }

	Box<3> box(int g, const Mat3& map) const override
	{
		const ContactBody<dim>& body = system_.body(g);
		Box<3> result;
		for (int s = 0; s < body.nodes(); ++s) {
			const Vec3 x = map * toSpace<dim>(body.position[s], z_);
			if (s == 0) result = { x, x };
			result.low = result.low.cwiseMin(x);
			result.high = result.high.cwiseMax(x);
		}
		const Vec3 about = body.nodeRadius * map.rowwise().norm();
		result.low -= about;
		result.high += about;
		if (dim == 2) { // as thick as the grain is wide, as for a sphere of YADE
			result.low[2] -= parameters(g).radius;
			result.high[2] += parameters(g).radius;
		}
		return result;
	}

	bool isInside(int g, const Box<3>& outer, double margin, const Mat3& map) const override
	{
		auto holds = [&](const Box<3>& own, double about) {
			return boxInScene(outer).contains(
				boxInScene(own), about * map.rowwise().norm().template head<dim>());
		};
		if (system_.isRigid(g)) {
			const RigidBounds<dim> bounds =
				system_.setOf(g).rigidBounds(system_.indexInSet(g));
			const Vec3 centre = map * toSpace<dim>(bounds.centre, z_);
			if (holds({ centre, centre }, bounds.radius + margin)) return true;
		}
		return holds(box(g, map), margin);
	}

	bool isInside(int g, const Box<3>& outer, double margin) const override
	{
		return system_.surfaces().isInside(g, boxInScene(outer), margin);
	}

	std::vector<Vec3> outline(int g) const override
	{
		return allToSpace<dim>(system_.body(g).position, z_);
	}

	double overlapWithItself(int g) const override
	{
		if constexpr (dim == 2) {
			const ContactOutline<2>& body = system_.body(g);
			if (body.mesh->mayMeetItself) return selfOverlap(body) / body.pointSpacing;
		}
		return 0;
	}

	std::vector<int> facets(int g) const override
	{
		std::vector<int> nodes;
		for (const auto& facet : system_.body(g).mesh->facet)
			nodes.insert(nodes.end(), facet.begin(), facet.end());
		return nodes;
	}

	PointFields points(int g) const override
	{
		PointFields fields;
		for (const PointResponse<dim>& response :
		     system_.setOf(g).points(system_.indexInSet(g))) {
			fields.position.push_back(toSpace<dim>(response.position, z_));
			Mat3 F = toSpace<dim>(response.F), cauchy = toSpace<dim>(response.cauchy);
			if (dim == 2) {
				F(2, 2) = response.F33;
				cauchy(2, 2) = response.cauchy33;
			}
			fields.F.push_back(F);
			fields.cauchy.push_back(cauchy);
			fields.volume.push_back(response.volume);
		}
		return fields;
	}

	double presentVolume(int g) const override
	{
		return system_.setOf(g).presentVolume(system_.indexInSet(g));
	}

	double undeformedVolume(int g) const override
	{
		const GrainParameters<dim>& grain = parameters(g);
		return std::pow(grain.radius, dim) * system_.setOf(g).reference().volume;
	}

	std::vector<Vec3> nodePositions(int g) const override
	{
		return allToSpace<dim>(system_.setOf(g).nodePositions(system_.indexInSet(g)), z_);
	}
	std::vector<Vec3> nodeVelocities(int g) const override
	{
		return allToSpace<dim>(system_.setOf(g).nodeVelocities(system_.indexInSet(g)));
	}

	GrainState state(int g, Vec3& origin) const override
	{
		origin = toSpace<dim>(parameters(g).origin, z_);
		GrainState state = system_.setOf(g).state(system_.indexInSet(g));
		state.sleep = system_.activity().sleepNumbers(g);
		return state;
	}

private:
	static Box<dim> boxInScene(const Box<3>& box)
	{
		return { toKernel<dim>(box.low), toKernel<dim>(box.high) };
	}

	static ContactList<dim>& listOf(PairContacts& pair)
	{
		return static_cast<PairContactsOf<dim>&>(pair).list;
	}

	static ContactList<dim>& listOn(PairContacts& pair, int g, const WallDescription& wall)
	{
		ContactList<dim>& list = listOf(pair);
		list.first = g;
		list.second = -1 - wall.id;
		list.rigid.reset(); // a wall that was free before
		list.plane = { toKernel<dim>(wall.point), toKernel<dim>(wall.normal),
			       toKernel<dim>(wall.velocity) };
		return list;
	}

	void listRigidContacts(std::vector<RigidContactDescription>& descriptions)
	{
		system_.rigidContacts().clear();
		solvedContacts_.clear();
		for (RigidContactDescription& d : descriptions) {
			const auto contact = contactOf<dim>(d);
			d.impulse.setZero();
			if (!contact) continue;
			system_.rigidContacts().push_back(*contact);
			solvedContacts_.push_back(&d);
		}
	}

	static void place(PairImage<dim>& image, const ImageDescription& description)
	{
		image.shift = toKernel<dim>(description.shift);
		image.velocity = toKernel<dim>(description.velocity);
	}

	/// Rigid bodies as the grains see them.
	RigidSight<dim> sight() const
	{
		return { z_, system_.setOf(0).reference().recipe.contact };
	}

	/// Searches run in parallel.
	void search(ContactList<dim>& list, double dt) const
	{
		if (system_.search(list, dt)) {
			searchedPairs_.fetch_add(1, std::memory_order_relaxed);
			testedCandidates_.fetch_add(list.tested, std::memory_order_relaxed);
		}
		countVanishedBonds(list);
	}
	void countVanishedBonds(ContactList<dim>& list) const
	{
		if (!list.interface) return;
		vanishedBonds_.fetch_add(list.interface->takeLostBonds(),
					 std::memory_order_relaxed);
	}

	const GrainParameters<dim>& parameters(int g) const
	{
		return system_.setOf(g).parameters(system_.indexInSet(g));
	}

	void add(DescribedSet<dim>& described)
	{
		int g = system_.grains();
		system_.add(std::move(described.set));
		for (const GrainDescription* d : described.members) {
			id_.push_back(d->id);
			system_.activity().restoreSleep(g++, d->state.sleep);
		}
	}

	mutable std::atomic<long> searchedPairs_ = 0, testedCandidates_ = 0,
				  vanishedBonds_ = 0; ///< since the last step
	System<dim> system_;
	Templates<dim> templates_;
	/// Where the impulses of the system's rigid contacts go, in the step at hand.
	std::vector<RigidContactDescription*> solvedContacts_;
	double slowestWave_; ///< m/s
	double z_;
};

} // namespace

std::shared_ptr<GrainAssembly> GrainAssembly::create(const std::vector<GrainDescription>& grains,
						     const GrainAssembly* last)
{
	requireOneSystem(grains);
	if (grains.front().dim == 2) return std::make_shared<GrainAssemblyOf<2>>(grains, last);
	return std::make_shared<GrainAssemblyOf<3>>(grains, last);
}

std::shared_ptr<GrainAssembly> GrainAssembly::createWithoutGrains()
{
	return std::make_shared<GrainAssemblyOf<3>>(std::vector<GrainDescription>(), nullptr);
}

} // namespace softgrain
