#include "contact/ContactProblem.hpp"
#include "contact/ContactSolver.hpp"
#include "contact/CoulombCone.hpp"
#include "contact/Residual.hpp"

#include <limits>

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
template SolverReport solve(ContactProblem<2>&, double, int);
template SolverReport solve(ContactProblem<3>&, double, int);

} // namespace softgrain
