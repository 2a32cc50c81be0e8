// A problem of grains and rigid bodies in contact, drawn at random.
#pragma once

#include "Helpers.hpp"
#include "contact/solve/ContactSolver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <deque>
#include <memory>
#include <variant>
#include <vector>

namespace softgrain::testing {

/// Of a grain: how its nodes answer to impulses, over its scale.
struct GrainTables {
	static constexpr int nodes = 4;
	Eigen::MatrixXd W;
	SparseRows<double> delassus;

	explicit GrainTables(Random& random)
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
	std::shared_ptr<const GrainTables> tables;
	std::shared_ptr<const OutlineMesh<dim>> mesh = std::make_shared<OutlineMesh<dim>>();
	std::vector<ContactBody<dim>> body;
	std::vector<RigidPartner<dim>> partner; ///< the first one is held
	std::deque<ContactList<dim>> lists;
	ContactSolver<dim> solver;
	SolverSettings settings;

	Mixture(unsigned seed, int grains, int partners)
		: random(seed)
		, tables(std::make_shared<GrainTables>(random))
		, body(grains)
		, partner(partners)
	{
		for (ContactBody<dim>& b : body) {
			b.mesh = mesh.get();
			b.delassus = &tables->delassus;
			b.delassusScale = random.uniform(0.5, 2);
			b.pointSpacing = 1;
			for (int i = 0; i < GrainTables::nodes; ++i) {
				b.position.push_back(random.vector<dim>());
				b.velocity.push_back(random.vector<dim>());
			}
			b.velocityBefore = b.velocity;
			b.impulse.assign(GrainTables::nodes, Vec<dim>::Zero());
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
					for (int j = 0; j < GrainTables::nodes; ++j)
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
			for (int i = 0; i < GrainTables::nodes; ++i)
				for (int j = 0; j < GrainTables::nodes; ++j)
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
				c.partner[i] = (node + i) % GrainTables::nodes;
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

} // namespace softgrain::testing
