// Contact dynamics: Signorini's and Coulomb's conditions at velocity level for all contacts of a
// step, by nonlinear Gauss-Seidel on the contact nodes (method: section 3).
//
// For each contact, with u the relative velocity of the node at the end of the step and r its
// impulse:
//     0 <= u_n + b  _|_  r_n >= 0,     |r_t| <= mu r_n, sliding opposite to u_t at the bound,
// where b = g/dt for a gap and, for an overlap, the capped speed at which it is worked off. Nodal
// masses are isotropic, so the Delassus block of a contact is W times the identity and the
// one-contact problem has a closed solution (CoulombCone.hpp). How well all conditions hold
// together is measured apart from the sweeps (Residual.hpp).
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactBody.hpp"
#include "contact/ContactProblem.hpp"

#include <vector>

namespace softgrain {

struct SolverSettings {
	/// Residual (ResidualSum) at which sweeps end: doc/decisions/0002-sweep-tolerance.md.
	double tolerance = 1e-2;
	int maxSweeps = 100; ///< cap; steps that hit it are counted
	/// Share of an overlap that is worked off per step. All at once would throw the grains
	/// apart.
	double overlapRelaxation = 0.1;
	/// Cap on the speed at which overlaps are worked off, m/s.
	double overlapSpeed = 1e300;
};

struct SolverReport {
	int contacts = 0; ///< within reach
	int active = 0;   ///< with an impulse
	int sweeps = 0;
	double residual = 0;   ///< of the impulses found
	bool converged = true; ///< residual <= tolerance within maxSweeps
};

/// Work of the contact impulses of one step, J (2D: J/m), split into the halves done at the
/// velocities before and after the impulse; their sum is exact for the kinetic energy.
struct ContactWork {
	struct Halves {
		double before = 0, after = 0;
	};
	Halves impact;   ///< lost by normal impulses (gained where an overlap is pushed out)
	Halves friction; ///< lost by friction
	Halves planes;   ///< done by moving planes on the grains
};

template <int dim> class ContactSolver {
public:
	/// Lists all contacts of `lists` whose bodies are in `bodies`, in the given order.
	void prepare(std::vector<ContactBody<dim>>& bodies, std::vector<ContactList<dim>*>& lists,
		     double dt, const SolverSettings& settings);
	/// Applies the impulses left by the last step, made admissible for the present normals.
	void warmStart();
	/// Gauss-Seidel sweeps: two backwards and two forwards in the order of the lists (in one
	/// direction alone, few sweeps a step shake grains at rest:
	/// doc/decisions/0010-grains-at-rest.md), then always forwards
	/// (doc/decisions/0004-sweep-order.md), until the residual is within the tolerance or the
	/// cap is hit; then the contacts of the lists have their impulses.
	SolverReport solve();
	/// Of the present impulses: see ResidualSum.
	double residual() const;
	/// Sums the impulses on every contact node into ContactBody::impulse.
	void collectImpulses();
	ContactWork work() const;
	/// The problem and its solution, of the last `solve`; lists and velocities are not needed
	/// any more; the mobility tables of the bodies are, as they were then.
	ContactProblem<dim> problem() const;

private:
	struct Constraint {
		Contact<dim> contact;      ///< a copy with the present impulse
		Contact<dim>* listed;      ///< valid up to the end of `solve`
		ContactBody<dim>* body;    ///< of the node
		ContactBody<dim>* partner; ///< of the partner nodes, null for a plane
		Vec<dim> planeVelocity;
		Vec<dim> freeVelocity;             ///< u without impulses
		Vec<dim> start = Vec<dim>::Zero(); ///< impulse before the first sweep
		double inverseW;                   ///< kg
		double bias;                       ///< b, m/s
		double friction;
	};

	Vec<dim> relativeVelocity(const Constraint& c,
				  std::vector<Vec<dim>> ContactBody<dim>::* field) const;
	/// Adds a row to `partnerMobility_`; returns what of it the contact itself feels, the
	/// partner's share of W.
	double appendPartnerMobility(const Contact<dim>& contact, const ContactBody<dim>* partner);
	Vec<dim> solvedImpulse(const Constraint& c) const;
	void applyImpulse(const Constraint& c, const Vec<dim>& J);
	enum class Order { forwards, backwards };
	double sweep(Order order); ///< relative change of the impulses, in the residual's norm
	SparseRows<double> delassus() const;
	/// Calls with each body, node and share of the node in the contact's relative velocity.
	template <class Visit> static void forEachShare(const Constraint& c, Visit&& visit)
	{
		visit(c.body, c.contact.key.node, 1.);
		for (int i = 0; i < c.contact.partners; ++i)
			visit(c.partner, c.contact.partner[i], -c.contact.weight[i]);
	}

	std::vector<Constraint> constraints_;
	/// Row k: sum_i w_i W_is of all nodes s of the partner that an impulse on contact k moves,
	/// 1/kg; empty for a plane.
	SparseRows<double> partnerMobility_;
	std::vector<double> partnerSum_; ///< of a row in the making, by node
	SolverSettings settings_;
};

} // namespace softgrain
