#include "Helpers.hpp"
#include "contact/solve/ContactConditions.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/Sharing.hpp"

#include <Eigen/Dense>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <deque>
#include <memory>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Of a grain: how its nodes answer to impulses, over its scale.
struct Tables {
	static constexpr int nodes = 4;
	Eigen::MatrixXd W;
	SparseRows<double> delassus;

	explicit Tables(Random& random)
	{
		Eigen::MatrixXd L(nodes, nodes);
		for (int i = 0; i < nodes; ++i)
			for (int j = 0; j < nodes; ++j)
				L(i, j) = random.uniform(-1, 1);
		W = L * L.transpose() / nodes + 0.5 * Eigen::MatrixXd::Identity(nodes, nodes);
		for (int i = 0; i < nodes; ++i) {
			for (int j = 0; j < nodes; ++j)
				delassus.append(j, W(i, j));
			delassus.closeRow();
		}
	}
};

/// Grains of a few nodes and rigid bodies that touch each other at random places, some with ends of
/// their own (side 1), in a step of 1 s.
template <int dim> struct Mixture {
	Random random;
	std::shared_ptr<const Tables> tables;
	std::shared_ptr<const OutlineMesh<dim>> mesh = std::make_shared<OutlineMesh<dim>>();
	std::vector<ContactBody<dim>> body;
	std::vector<RigidPartner<dim>> partner; ///< the first one is held
	std::deque<ContactList<dim>> lists;
	ContactSolver<dim> solver;
	SolverSettings settings;

	Mixture(unsigned seed, int grains, int partners)
		: random(seed)
		, tables(std::make_shared<Tables>(random))
		, body(grains)
		, partner(partners)
	{
		for (ContactBody<dim>& b : body) {
			b.mesh = mesh.get();
			b.delassus = &tables->delassus;
			b.delassusScale = random.uniform(0.5, 2);
			b.pointSpacing = 1;
			for (int i = 0; i < Tables::nodes; ++i) {
				b.position.push_back(random.vector<dim>());
				b.velocity.push_back(random.vector<dim>());
			}
			b.velocityBefore = b.velocity;
			b.impulse.assign(Tables::nodes, Vec<dim>::Zero());
		}
		for (RigidPartner<dim>& p : partner) {
			p.centre = random.vector<dim>();
			p.velocity = p.velocityBefore = random.vector<dim>();
			p.spin = p.spinBefore = random.vector<spins<dim>>();
			p.inverseMass.setConstant(random.uniform(0.5, 2));
			p.inverseInertia.setIdentity();
			p.inverseInertia *= random.uniform(1, 5);
		}
		partner[0].inverseMass.setZero();
		partner[0].inverseInertia.setZero();
	}
	/// `offset`: how far arms are from the normal, over their length.
	Mixture(unsigned seed, int grains, int partners, double friction, double offset)
		: Mixture(seed, grains, partners)
	{
		for (int g = 0; g < grains; ++g)
			for (int p = 0; p < partners; ++p)
				if (random.uniform(0, 1) < 0.5) addList(g, p, friction, offset);
	}
	ContactList<dim>& addList(int g, int p, double friction, double offset)
	{
		ContactList<dim> list;
		list.first = g;
		list.second = -1 - p;
		list.friction = friction;
		list.image = { random.vector<dim>(), random.vector<dim>(0.3) };
		list.rigid.emplace();
		const Vec<dim> aside = offset * random.vector<dim>();
		if (random.index(2))
			list.rigid->surface = BlockSurface<dim>();
		else
			list.rigid->surface = BallSurface<dim> { centreOf(list, p) + aside, 1 };
		list.rigid->pivot = random.vector<dim>();
		list.rigid->partner = p;
		list.rigid->moves = partner[p].moves();
		for (int node = 0; node < 1 + random.index(2); ++node)
			list.contacts.push_back(contactOf(list, node, offset));
		lists.push_back(list);
		return lists.back();
	}
	SolverReport solve(double tolerance, int maxSweeps = 10000, int threads = 1)
	{
		settings.tolerance = tolerance;
		settings.maxSweeps = maxSweeps;
		std::vector<ContactList<dim>*> pointers;
		for (ContactList<dim>& list : lists)
			pointers.push_back(&list);
		solver.plan(pointers, static_cast<int>(body.size()), &partner);
		solver.prepare(body, 1, settings, threads);
		return solver.solve();
	}

	Vec<dim> centreOf(const ContactList<dim>& list, int p) const
	{
		return partner[p].centre + list.image.shift;
	}
	/// Calls with the nodes of the grain on which a contact acts, and their shares.
	template <class Use> static void forNodes(const Contact<dim>& c, Use&& use)
	{
		if (c.key.side == 0)
			use(c.key.node, 1.);
		else
			for (int i = 0; i < c.partners; ++i)
				use(c.partner[i], c.weight[i]);
	}
	static Vec<dim> normalOf(const Contact<dim>& c) ///< towards the grain
	{
		return c.key.side == 0 ? c.normal : Vec<dim>(-c.normal);
	}
	static Vec<dim> impulseOf(const Contact<dim>& c) ///< on the grain
	{
		return c.key.side == 0 ? c.impulse : Vec<dim>(-c.impulse);
	}
	Vec<dim> placeOf(const ContactList<dim>& list, const Contact<dim>& c) const
	{
		Vec<dim> place = Vec<dim>::Zero();
		forNodes(c, [&](int i, double w) { place += w * body[list.first].position[i]; });
		return place;
	}
	/// From the centre of the rigid body.
	Vec<dim> armOf(const ContactList<dim>& list, const Contact<dim>& c) const
	{
		return placeOf(list, c) - centreOf(list, list.rigid->partner);
	}
	/// Relative velocity, at the place on the rigid body half a step later, as far as that
	/// moves along the surface; a ball turns under it. `spin` is that without impulses.
	Vec<dim> velocityAt(const ContactList<dim>& list, const Contact<dim>& c,
			    const Spin<dim>& spin) const
	{
		const int p = list.rigid->partner;
		const Vec<dim> arm = armOf(list, c), n = normalOf(c);
		const auto* ball = std::get_if<BallSurface<dim>>(&list.rigid->surface);
		const Vec<dim> turned = ball ? Vec<dim>(ball->centre - centreOf(list, p)) : arm;
		const Vec<dim> gained = spinCross<dim>(spin, 0.5 * spinCross<dim>(spin, turned));
		Vec<dim> u = -partner[p].velocityAt(arm) - list.image.velocity -
			     (gained - gained.dot(n) * n);
		forNodes(c, [&](int i, double w) { u += w * body[list.first].velocity[i]; });
		return u;
	}
	/// b: what may rest of an overlap is more where a ball lies against the outline.
	double biasOf(const ContactList<dim>& list, const Contact<dim>& c) const
	{
		const bool isBall = std::holds_alternative<BallSurface<dim>>(list.rigid->surface);
		const double resting = isBall && c.key.side == 1 ? 0.2 : 1e-3;
		return c.gap >= 0 ? c.gap : -0.1 * std::max(-c.gap - resting, 0.);
	}
	/// The impulses found, on the bodies.
	void push()
	{
		for (const ContactList<dim>& list : lists)
			for (const Contact<dim>& c : list.contacts) {
				const Vec<dim> r = impulseOf(c);
				ContactBody<dim>& b = body[list.first];
				forNodes(c, [&](int i, double w) {
					b.impulse[i] += w * r;
					for (int j = 0; j < Tables::nodes; ++j)
						b.velocity[j] +=
							b.delassusScale * w * tables->W(j, i) * r;
				});
				partner[list.rigid->partner].push(armOf(list, c), -r);
			}
	}
	double kineticOfGrains() const
	{
		const Eigen::MatrixXd mass = tables->W.inverse();
		double sum = 0;
		for (const ContactBody<dim>& b : body)
			for (int i = 0; i < Tables::nodes; ++i)
				for (int j = 0; j < Tables::nodes; ++j)
					sum += 0.5 / b.delassusScale * mass(i, j) *
					       b.velocity[i].dot(b.velocity[j]);
		return sum;
	}
	double kineticOfFreeBodies() const
	{
		double sum = 0;
		for (const RigidPartner<dim>& p : partner)
			if (p.moves())
				sum += 0.5 * p.massProduct(p.velocity, p.spin, p.velocity, p.spin);
		return sum;
	}

private:
	Contact<dim> contactOf(const ContactList<dim>& list, int node, double offset)
	{
		Contact<dim> c;
		c.key = { random.index(2), node, -1 };
		if (c.key.side == 1) {
			c.partners = dim;
			c.facet = 0;
			double sum = 0;
			for (int i = 0; i < dim; ++i) {
				c.partner[i] = (node + i) % Tables::nodes;
				sum += c.weight[i] = random.uniform(0, 1);
			}
			for (int i = 0; i < dim; ++i)
				c.weight[i] /= sum;
		}
		const Vec<dim> arm = armOf(list, c);
		c.normal = (arm.normalized() + offset * random.direction<dim>()).normalized();
		if (c.key.side == 1) c.normal = -c.normal;
		c.gap = random.uniform(-0.4, 0.2);
		return c;
	}
};

} // namespace

TEMPLATE_TEST_CASE_SIG("contact with rigid bodies holds all conditions, one by one", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	ContactConditions conditions(0.6);
	States ofEnds;
	for (const double offset : { 0., 0.5 })
		for (unsigned seed = 1; seed < 15; ++seed) {
			Mixture<dim> mixture(seed, 6, 3, 0.6, offset);
			Mixture<dim> anew = mixture;
			const Mixture<dim> before = mixture;
			const SolverReport report = mixture.solve(1e-13);
			REQUIRE(report.converged);
			anew.lists = mixture.lists;
			Mixture<dim> warm = anew; // the same problem again needs no work
			CHECK(warm.solve(1e-10).sweeps <= 4);
			anew.push();
			for (const ContactList<dim>& list : mixture.lists)
				for (const Contact<dim>& c : list.contacts) {
					const Spin<dim>& spin =
						before.partner[list.rigid->partner].spin;
					const Vec<dim> u = anew.velocityAt(list, c, spin);
					CHECK((u - mixture.velocityAt(list, c, spin)).norm() <
					      1e-11);
					const States last = conditions;
					conditions.check<dim>(mixture.normalOf(c),
							      mixture.impulseOf(c), u,
							      mixture.biasOf(list, c));
					if (c.key.side == 0) continue;
					ofEnds.stick += conditions.stick - last.stick;
					ofEnds.slip += conditions.slip - last.slip;
				}
			for (std::size_t g = 0; g < mixture.body.size(); ++g)
				for (int i = 0; i < Tables::nodes; ++i)
					CHECK((anew.body[g].impulse[i] - mixture.body[g].impulse[i])
						      .norm() < 1e-12);
		}
	CHECK(conditions.open > 10);
	CHECK(conditions.stick > 3);
	CHECK(conditions.slip > 10);
	CHECK(ofEnds.stick > 1);
	CHECK(ofEnds.slip > 5);
}

TEMPLATE_TEST_CASE_SIG("the impulse of a pair with a rigid body, and its moment about the pivot",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	Mixture<dim> mixture(3, 12, 3, 0.6, 0.5);
	mixture.solve(1e-10);
	int active = 0;
	for (const ContactList<dim>& list : mixture.lists) {
		Vec<dim> sum = Vec<dim>::Zero();
		Spin<dim> turning = Spin<dim>::Zero();
		for (const Contact<dim>& c : list.contacts) {
			const Vec<dim> r = mixture.impulseOf(c);
			sum += r;
			turning -= moment<dim>(mixture.placeOf(list, c) - list.rigid->pivot, r);
			active += !r.isZero(0);
		}
		CHECK((list.impulse.normal + list.impulse.shear - sum).norm() < 1e-13);
		CHECK((list.impulse.moment - turning).norm() < 1e-13);
	}
	CHECK(active > 5);
}

TEMPLATE_TEST_CASE_SIG("work of contacts with rigid bodies is the change of kinetic energy",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	Mixture<dim> mixture(5, 8, 4, 0.4, 0.3);
	const Mixture<dim> before = mixture;
	REQUIRE(mixture.solve(1e-10).converged);
	const ContactWork work = mixture.solver.work();
	auto sum = [](const ContactWork::Halves& halves) { return halves.before + halves.after; };
	const double walls = sum(work.walls), cell = sum(work.cell),
		     lost = sum(work.friction) + sum(work.impact);
	const double start = before.kineticOfGrains();
	CHECK(sum(work.friction) > 1e-3 * start);
	CHECK(std::abs(walls) > 1e-3 * start);
	CHECK(std::abs(cell) > 1e-3 * start);
	CHECK(std::abs(mixture.kineticOfGrains() - start - (walls + cell - lost)) < 1e-12 * start);
	// what the held one gives comes from outside
	double outside = 0;
	for (const ContactList<dim>& list : mixture.lists)
		for (const Contact<dim>& c : list.contacts)
			if (list.rigid->partner == 0)
				outside += mixture.impulseOf(c).dot(
					mixture.partner[0].velocityAt(mixture.armOf(list, c)));
	const double given = before.kineticOfFreeBodies() - mixture.kineticOfFreeBodies();
	CHECK(std::abs(walls - outside - given) < 1e-12 * start);
}

TEMPLATE_TEST_CASE_SIG("one contact with a ball is solved by one visit", "[rigid]",
		       ((int dim), dim), 2, 3)
{
	int closed[2] = { 0, 0 }; // by side
	for (unsigned seed = 1; seed < 40; ++seed) {
		Mixture<dim> mixture(seed, 1, 2);
		ContactList<dim>& list = mixture.addList(0, 1, 0.5, 0);
		list.rigid->surface = BallSurface<dim> { mixture.centreOf(list, 1), 1 };
		list.contacts.resize(1);
		mixture.solve(1e-300, 1);
		CHECK(mixture.solver.residual() < 1e-14);
		closed[list.contacts[0].key.side] += !list.contacts[0].impulse.isZero(0);
	}
	CHECK(closed[0] > 5);
	CHECK(closed[1] > 5);
}

namespace {

/// Grains and free rigid bodies in turn in a square lattice, neighbours in contact.
template <int dim> Mixture<dim> chessboard(int side)
{
	Mixture<dim> board(7, side * side / 2, side * side / 2);
	auto touch = [&](int site, int other) {
		const bool grainFirst = (site / side + site) % 2 == 0;
		board.addList((grainFirst ? site : other) / 2, (grainFirst ? other : site) / 2, 0.4,
			      0.2);
	};
	for (int i = 0; i < side; ++i)
		for (int j = 0; j + 1 < side; ++j) {
			touch(i * side + j, i * side + j + 1);
			touch(j * side + i, (j + 1) * side + i);
		}
	return board;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("contact with free rigid bodies: the same bits with any number of threads",
		       "[rigid]", ((int dim), dim), 2, 3)
{
	auto solved = [](int threads) {
		Mixture<dim> board = chessboard<dim>(24);
		REQUIRE(threadsThatShare<dim>(board.lists, board.body, board.partner, {},
					      threads) == threads);
		const SolverReport report = board.solve(1e-6, 1000, threads);
		CHECK(report.active > 300);
		std::vector<double> bits { report.residual, report.sweeps,
					   board.solver.work().friction.after };
		auto note = [&](const auto& vector) {
			bits.insert(bits.end(), vector.data(), vector.data() + vector.size());
		};
		for (const ContactList<dim>& list : board.lists) {
			note(list.impulse.moment);
			for (const Contact<dim>& c : list.contacts)
				note(c.impulse);
		}
		for (const ContactBody<dim>& b : board.body)
			for (const auto* field : { &b.velocity, &b.impulse })
				for (const Vec<dim>& v : *field)
					note(v);
		for (const RigidPartner<dim>& p : board.partner) {
			note(p.velocity);
			note(p.spin);
		}
		return bits;
	};
	const auto one = solved(1);
	CHECK(solved(2) == one);
	CHECK(solved(3) == one);
}

TEST_CASE("the contact problem as data names what it cannot hold", "[rigid]")
{
	Mixture<2> mixture(1, 4, 2, 0.3, 0);
	mixture.solve(1e-10);
	CHECK_THROWS_AS(mixture.solver.problem(), std::logic_error);

	Mixture<2> held(1, 4, 1, 0.3, 0);
	held.solve(1e-10);
	const ContactProblem<2> problem = held.solver.problem();
	CHECK(problem.contacts() > 0);
	CHECK(problem.residual() < 1e-9);
}
