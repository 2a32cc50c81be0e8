// A random problem of two bodies, as lists of contacts and as one dense matrix, and slow methods
// that solve it in other ways than the kernel does.
#pragma once

#include "Helpers.hpp"
#include "contact/solve/ContactProblem.hpp"
#include "contact/solve/ContactSolver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace softgrain::testing {

/// Two bodies with dense random mobility, six contacts of nodes and in 3D one of edges between them
/// and two against a moving plane, and the same problem once more as one dense matrix: u = u0 + A r
/// for all relative velocities u.
template <int dim> struct Problem {
	static constexpr int nodes = 6;

	std::vector<SparseRows<double>> table = std::vector<SparseRows<double>>(2);
	OutlineMesh<dim> mesh;
	std::vector<ContactBody<dim>> body = std::vector<ContactBody<dim>>(2);
	ContactList<dim> pair, plane;
	double dt = 0.5;
	SolverSettings settings;
	std::vector<Eigen::MatrixXd> W;           ///< of both bodies
	std::vector<std::vector<Vec<dim>>> start; ///< velocities without contact

	Problem(unsigned seed, double friction)
	{
		Random random(seed);
		settings.tolerance = 1e-14;
		settings.maxSweeps = 100000;
		settings.overlapRelaxation = 0.2;
		settings.overlapSpeed = 0.3;
		for (int b = 0; b < 2; ++b) {
			Eigen::MatrixXd L(nodes, nodes);
			for (int i = 0; i < nodes; ++i)
				for (int j = 0; j < nodes; ++j)
					L(i, j) = random.uniform(-1, 1);
			W.push_back(L * L.transpose() / nodes +
				    0.3 * Eigen::MatrixXd::Identity(nodes, nodes));
			body[b].delassusScale = b + 2;
			for (int i = 0; i < nodes; ++i) {
				for (int j = 0; j < nodes; ++j)
					table[b].append(j, W[b](i, j) / body[b].delassusScale);
				table[b].closeRow();
			}
			body[b].delassus = &table[b];
			body[b].mesh = &mesh;
			body[b].position.resize(nodes);
			for (int i = 0; i < nodes; ++i) {
				body[b].velocity.push_back(random.vector<dim>());
				body[b].velocityBefore.push_back(random.vector<dim>());
			}
			start.push_back(body[b].velocity);
			body[b].impulse.assign(nodes, Vec<dim>::Zero());
		}
		pair.first = plane.first = 0;
		pair.second = 1;
		pair.friction = friction;
		plane.friction = 1.5 * friction;
		plane.plane = { Vec<dim>::Zero(), random.direction<dim>(),
				random.vector<dim>(0.5) };
		for (int side : { 0, 1 })
			for (int n = 0; n < 3; ++n) {
				Contact<dim> c;
				c.key = { side, n, -1 };
				c.partners = dim;
				double sum = 0;
				const int offset = random.index(nodes);
				for (int i = 0; i < dim; ++i) {
					c.partner[i] = (offset + i) % nodes;
					sum += c.weight[i] = random.uniform(0, 1);
				}
				for (int i = 0; i < dim; ++i)
					c.weight[i] /= sum;
				c.normal = random.direction<dim>();
				c.gap = random.uniform(-0.4, 0.2);
				pair.contacts.push_back(c);
			}
		if constexpr (dim == 3) {
			Contact<3> c;
			c.key = { ContactKey::edges, 4, 1 };
			c.from = 2;
			c.to = 5;
			c.share = random.uniform(0, 1);
			c.partners = dim;
			c.partner = { 4, 0, 1 };
			c.weight = { 0.3, 0.7, 0 };
			c.normal = random.direction<dim>();
			c.gap = random.uniform(-0.4, 0.2);
			pair.contacts.push_back(c);
		}
		for (int n : { 3, 5 }) {
			Contact<dim> c;
			c.key = { 0, n, -1 };
			c.normal = plane.plane.normal;
			c.gap = random.uniform(-0.4, 0.2);
			plane.contacts.push_back(c);
		}
	}
	Problem(const Problem&) = delete; // bodies point into it

	std::vector<ContactList<dim>*> lists() { return { &pair, &plane }; }
	std::vector<Contact<dim>*> contacts()
	{
		std::vector<Contact<dim>*> all;
		for (ContactList<dim>* list : lists())
			for (Contact<dim>& c : list->contacts)
				all.push_back(&c);
		return all;
	}
	double friction(int c)
	{
		return c < static_cast<int>(pair.contacts.size()) ? pair.friction : plane.friction;
	}
	bool onPlane(int c) const { return c >= static_cast<int>(pair.contacts.size()); }

	void restart()
	{
		for (int b = 0; b < 2; ++b) {
			body[b].velocity = start[b];
			body[b].impulse.assign(nodes, Vec<dim>::Zero());
		}
	}
	SolverReport solve(ContactSolver<dim>& solver)
	{
		restart();
		auto l = lists();
		solver.plan(l, static_cast<int>(body.size()));
		solver.prepare(body, dt, settings);
		return solver.solve();
	}

	/// What the node of contact c moves relative to, as shares of the nodes of body b.
	Eigen::VectorXd shares(int c, int b)
	{
		const Contact<dim>& contact = *contacts()[c];
		Eigen::VectorXd H = Eigen::VectorXd::Zero(nodes);
		const int own = onPlane(c) ? 0 : contact.key.body();
		if (b == own) contact.forOwnNodes([&](int node, double w) { H[node] += w; });
		if (!onPlane(c) && b != own)
			for (int i = 0; i < dim; ++i)
				H[contact.partner[i]] -= contact.weight[i];
		return H;
	}
	/// Delassus matrix between contacts; all its blocks are multiples of the identity.
	Eigen::MatrixXd delassus()
	{
		const int n = static_cast<int>(contacts().size());
		Eigen::MatrixXd A(n, n);
		for (int c = 0; c < n; ++c)
			for (int d = 0; d < n; ++d)
				A(c, d) = shares(c, 0).dot(W[0] * shares(d, 0)) +
					  shares(c, 1).dot(W[1] * shares(d, 1));
		return A;
	}
	/// The same as numbers alone, with the present impulses; the bias is part of the
	/// velocities.
	ContactProblem<dim> dense()
	{
		ContactProblem<dim> result;
		const Eigen::MatrixXd A = delassus();
		const auto all = contacts();
		result.freeVelocity = free();
		for (int c = 0; c < static_cast<int>(all.size()); ++c) {
			for (int d = 0; d < static_cast<int>(all.size()); ++d)
				result.delassus.append(d, A(c, d));
			result.delassus.closeRow();
			result.normal.push_back(all[c]->normal);
			result.bias.push_back(0);
			result.friction.push_back(friction(c));
			result.impulse.push_back(all[c]->impulse);
		}
		return result;
	}
	/// Relative velocities without impulses, with the bias b n added.
	std::vector<Vec<dim>> free()
	{
		std::vector<Vec<dim>> u;
		const auto all = contacts();
		for (int c = 0; c < static_cast<int>(all.size()); ++c) {
			Vec<dim> sum = Vec<dim>::Zero();
			for (int b = 0; b < 2; ++b)
				for (int i = 0; i < nodes; ++i)
					sum += shares(c, b)[i] * start[b][i];
			if (onPlane(c)) sum -= plane.plane.velocity;
			const double gap = all[c]->gap;
			double bias = gap / dt;
			if (gap < 0)
				bias = -std::min(settings.overlapRelaxation * -gap / dt,
						 settings.overlapSpeed);
			u.push_back(sum + bias * all[c]->normal);
		}
		return u;
	}
};

/// Solution of the frictionless problem by trying all sets of active contacts.
template <int dim> Eigen::VectorXd enumerated(Problem<dim>& problem)
{
	const auto all = problem.contacts();
	const int n = static_cast<int>(all.size());
	Eigen::MatrixXd A = problem.delassus();
	Eigen::VectorXd u(n);
	const auto free = problem.free();
	for (int c = 0; c < n; ++c) {
		u[c] = free[c].dot(all[c]->normal);
		for (int d = 0; d < n; ++d)
			A(c, d) *= all[c]->normal.dot(all[d]->normal);
	}
	for (int set = 0; set < (1 << n); ++set) {
		std::vector<int> active;
		for (int c = 0; c < n; ++c)
			if (set >> c & 1) active.push_back(c);
		Eigen::VectorXd r = Eigen::VectorXd::Zero(n);
		if (!active.empty()) {
			const Eigen::MatrixXd among = A(active, active);
			const Eigen::VectorXd target = -u(active);
			const Eigen::VectorXd pressed = among.ldlt().solve(target);
			r(active) = pressed;
		}
		const Eigen::VectorXd after = u + A * r;
		bool holds = true;
		for (int c = 0; c < n; ++c)
			holds = holds && r[c] >= 0 && ((set >> c & 1) || after[c] >= 0);
		if (holds) return r;
	}
	return Eigen::VectorXd::Constant(n, std::nan(""));
}

/// Solution of the problem with friction by damped simultaneous projections.
template <int dim> std::vector<Vec<dim>> projected(Problem<dim>& problem)
{
	const auto all = problem.contacts();
	const int n = static_cast<int>(all.size());
	const Eigen::MatrixXd A = problem.delassus();
	const double rho = 0.5 / A.operatorNorm();
	const auto free = problem.free();
	std::vector<Vec<dim>> r(n, Vec<dim>::Zero());
	for (int k = 0; k < 20000; ++k) {
		std::vector<Vec<dim>> next = r;
		for (int c = 0; c < n; ++c) {
			Vec<dim> u = free[c];
			for (int d = 0; d < n; ++d)
				u += A(c, d) * r[d];
			const Vec<dim> trial = r[c] - rho * u, normal = all[c]->normal;
			const double pressure = std::max(0., trial.dot(normal));
			Vec<dim> slip = trial - trial.dot(normal) * normal;
			const double bound = problem.friction(c) * pressure;
			if (slip.norm() > bound) slip *= bound / slip.norm();
			next[c] = pressure * normal + slip;
		}
		r = next;
	}
	return r;
}

} // namespace softgrain::testing
