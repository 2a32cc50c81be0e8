#include "contact/solve/ContactProblem.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/Residual.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

namespace softgrain {

template <int dim> double ContactProblem<dim>::mobility(int k) const
{
	for (int e = delassus.begin(k); e < delassus.end(k); ++e)
		if (delassus.column[e] == k) return delassus.value[e];
	return 0;
}

template <int dim> std::vector<Vec<dim>> ContactProblem<dim>::velocity() const
{
	std::vector<Vec<dim>> u = freeVelocity;
	for (int k = 0; k < contacts(); ++k)
		for (int e = delassus.begin(k); e < delassus.end(k); ++e)
			u[k] += delassus.value[e] * impulse[delassus.column[e]];
	return u;
}

template <int dim> double ContactProblem<dim>::residual() const
{
	const std::vector<Vec<dim>> u = velocity();
	ResidualSum sum;
	for (int k = 0; k < contacts(); ++k) {
		const double W = mobility(k);
		sum.add<dim>(impulse[k],
			     solvedContact<dim>(impulse[k], u[k], normal[k], bias[k], 1 / W,
						friction[k]),
			     W);
	}
	return sum.value();
}

// --- taken out of a solver ------------------------------

template <int dim>
template <class Visit>
void ContactSolver<dim>::forEachConstraint(Visit&& visit) const
{
	for (int k = 0; k < pairs_.count(); ++k)
		pairs_.withGrainPair(k, [&](const auto& pair) {
			for (const auto& c : pair.constraints())
				visit(pair, c);
		});
}

template <int dim> SparseRows<double> ContactSolver<dim>::delassus() const
{
	using Share = std::pair<int, double>; // of a contact in a node
	std::map<std::pair<const ContactBody<dim>*, int>, std::vector<Share>> at;
	int contacts = 0;
	forEachConstraint([&](const auto& pair, const auto& c) {
		pair.forEachShare(c, [&](const ContactBody<dim>* body, int node, double w) {
			at[{ body, node }].push_back({ contacts, w });
		});
		++contacts;
	});
	SparseRows<double> rows;
	forEachConstraint([&](const auto& pair, const auto& c) {
		std::map<int, double> row;
		pair.forEachShare(c, [&](const ContactBody<dim>* body, int node, double w) {
			const SparseRows<double>& table = *body->delassus;
			for (int e = table.begin(node); e < table.end(node); ++e) {
				const auto found = at.find({ body, table.column[e] });
				if (found == at.end()) continue;
				for (const auto& [l, share] : found->second)
					row[l] += w * share * body->delassusScale * table.value[e];
			}
		});
		for (const auto& [l, W] : row)
			rows.append(l, W);
		rows.closeRow();
	});
	return rows;
}

template <int dim> ContactProblem<dim> ContactSolver<dim>::problem() const
{
	ContactProblem<dim> problem;
	if (!solved_) return problem;
	if (std::any_of(islands_.begin(), islands_.end(),
			[](const IslandSweeps& island) { return island.movesRigidBodies; }))
		throw std::logic_error(
			"the contact problem cannot be given as data: a rigid body that "
			"contact moves takes part, whose blocks of W are no multiples of "
			"the identity");
	problem.delassus = delassus();
	for (int k = 0; k < pairs_.count(); ++k)
		pairs_.withGrainPair(k, [&](const auto& pair) {
			problem.start.insert(problem.start.end(), pair.start().begin(),
					     pair.start().end());
		});
	forEachConstraint([&](const auto& pair, const auto& c) {
		problem.freeVelocity.push_back(pair.velocity(c));
		problem.normal.push_back(c.normal);
		problem.bias.push_back(c.bias);
		problem.friction.push_back(pair.friction(c));
		problem.impulse.push_back(c.impulse);
	});
	for (int k = 0; k < problem.contacts(); ++k) // takes out what the impulses did
		for (int e = problem.delassus.begin(k); e < problem.delassus.end(k); ++e)
			problem.freeVelocity[k] -= problem.delassus.value[e] *
						   problem.impulse[problem.delassus.column[e]];
	return problem;
}

// --- solved on its own ------------------------------

/// The contacts become the nodes of one body, each against a plane of its own.
template <int dim> SolverReport solve(ContactProblem<dim>& problem, double tolerance, int maxSweeps)
{
	std::vector<ContactBody<dim>> bodies(1);
	bodies[0].delassus = &problem.delassus;
	bodies[0].delassusScale = 1;
	bodies[0].velocity = problem.freeVelocity;
	bodies[0].position.assign(problem.contacts(), Vec<dim>::Zero());
	bodies[0].impulse = bodies[0].position;
	std::vector<ContactList<dim>> lists(problem.contacts());
	std::vector<ContactList<dim>*> pointers;
	for (int k = 0; k < problem.contacts(); ++k) {
		Contact<dim> contact;
		contact.key = { 0, k, -1 };
		contact.normal = problem.normal[k];
		contact.gap = problem.bias[k]; // in a step of one second
		contact.impulse = problem.start[k];
		lists[k].first = 0;
		lists[k].friction = problem.friction[k];
		lists[k].contacts = { contact };
		pointers.push_back(&lists[k]);
	}
	SolverSettings settings;
	settings.tolerance = tolerance;
	settings.maxSweeps = maxSweeps;
	settings.overlapRelaxation = 1;
	settings.overlapSpeed = std::numeric_limits<double>::infinity();

	ContactSolver<dim> solver;
	solver.plan(pointers, static_cast<int>(bodies.size()));
	solver.prepare(bodies, 1, settings);
	const SolverReport report = solver.solve();
	problem.impulse.resize(problem.contacts());
	for (int k = 0; k < problem.contacts(); ++k)
		problem.impulse[k] = lists[k].contacts[0].impulse;
	return report;
}

template struct ContactProblem<2>;
template struct ContactProblem<3>;
template ContactProblem<2> ContactSolver<2>::problem() const;
template ContactProblem<3> ContactSolver<3>::problem() const;
template SolverReport solve(ContactProblem<2>&, double, int);
template SolverReport solve(ContactProblem<3>&, double, int);

} // namespace softgrain
