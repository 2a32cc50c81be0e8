// Contact problems to solve on their own: bodies that only translate, each a node with a mass.
#pragma once

#include "Helpers.hpp"
#include "contact/solve/ContactConditions.hpp"
#include "contact/solve/ContactProblem.hpp"

#include <Eigen/Dense>

namespace softgrain::testing {

/// A contact between places on bodies: shares of each body in its relative velocity.
template <int dim> struct Touch {
	Eigen::VectorXd shares;
	Vec<dim> normal;
	double bias = 0;
	double friction = 0;
};

/// W = H M^-1 H^T and u_free = H v from the touches of bodies with the given masses and velocities.
template <int dim>
ContactProblem<dim> assembled(const std::vector<Touch<dim>>& touches, const Eigen::VectorXd& mass,
			      const std::vector<Vec<dim>>& velocity)
{
	ContactProblem<dim> problem;
	for (const Touch<dim>& a : touches) {
		for (std::size_t l = 0; l < touches.size(); ++l) {
			const double W = a.shares.dot(touches[l].shares.cwiseQuotient(mass));
			if (W != 0) problem.delassus.append(static_cast<int>(l), W);
		}
		problem.delassus.closeRow();
		Vec<dim> u = Vec<dim>::Zero();
		for (int b = 0; b < mass.size(); ++b)
			u += a.shares[b] * velocity[b];
		problem.freeVelocity.push_back(u);
		problem.normal.push_back(a.normal);
		problem.bias.push_back(a.bias);
		problem.friction.push_back(a.friction);
	}
	problem.start.assign(touches.size(), Vec<dim>::Zero());
	problem.impulse = problem.start;
	return problem;
}

/// Contacts in all directions between `bodies` bodies, some of them with a fixed one. No overlap: a
/// solution exists, since the bodies could stand still.
template <int dim>
ContactProblem<dim> randomProblem(unsigned seed, int bodies, int contacts, double friction)
{
	Random random(seed);
	Eigen::VectorXd mass(bodies);
	std::vector<Vec<dim>> velocity;
	for (int b = 0; b < bodies; ++b) {
		mass[b] = random.uniform(0.5, 2);
		velocity.push_back(random.vector<dim>());
	}
	std::vector<Touch<dim>> touches;
	for (int k = 0; k < contacts; ++k) {
		Touch<dim> touch { Eigen::VectorXd::Zero(bodies), random.direction<dim>(),
				   random.uniform(0, 0.3), friction * random.uniform(0.5, 1) };
		touch.shares[random.index(bodies)] += 1;
		const int other = random.index(bodies + 1);
		if (other < bodies) touch.shares[other] -= 1;
		if (!touch.shares.isZero(0)) touches.push_back(touch);
	}
	return assembled<dim>(touches, mass, velocity);
}

/// A tower of blocks on the ground, one step of gravity and a push sideways at its top. Each pair
/// of neighbours touches in `redundancy` contacts of one normal: their matrix W is singular.
template <int dim> ContactProblem<dim> tower(int blocks, int redundancy, double friction)
{
	const Vec<dim> up = Vec<dim>::Unit(dim - 1), sideways = Vec<dim>::Unit(0);
	std::vector<Touch<dim>> touches;
	for (int b = 0; b < blocks; ++b)
		for (int k = 0; k < redundancy; ++k) {
			Touch<dim> touch { Eigen::VectorXd::Zero(blocks), up, 0, friction };
			touch.shares[b] = 1;
			if (b > 0) touch.shares[b - 1] = -1;
			touches.push_back(touch);
		}
	std::vector<Vec<dim>> velocity(blocks, -0.1 * up);
	velocity.back() += 0.05 * sideways;
	return assembled<dim>(touches, Eigen::VectorXd::Ones(blocks), velocity);
}

/// Signorini's and Coulomb's conditions, one by one, with velocities summed anew.
template <int dim> States checkConditions(const ContactProblem<dim>& problem, double tolerance)
{
	States states;
	const std::vector<Vec<dim>> velocity = problem.velocity();
	for (int k = 0; k < problem.contacts(); ++k)
		states += checkContact<dim>(problem.normal[k], problem.impulse[k], velocity[k],
					    problem.bias[k], problem.friction[k],
					    { tolerance, tolerance });
	return states;
}

} // namespace softgrain::testing
