// The contacts of one pair of bodies as the sweeps see them: little memory for each, in one piece.
// What it does changes the velocities of these two bodies only, so pairs without a common body can
// be worked on at the same time.
#pragma once

#include "contact/ContactList.hpp"
#include "contact/RigidPartner.hpp"
#include "contact/solve/Bias.hpp"
#include "contact/solve/BodySide.hpp"
#include "contact/solve/ContactWork.hpp"
#include "contact/solve/PairProblem.hpp"
#include "contact/solve/Residual.hpp"
#include "contact/solve/SolverSettings.hpp"
#include "contact/solve/Sweep.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace softgrain {

template <int dim> class PairSolver {
public:
	/// One contact as the sweeps see it.
	struct Constraint : PlaceOnEdge<dim> {
		Vec<dim> normal, impulse;
		double bias;     ///< b, m/s
		double W;        ///< 1/kg
		double inverseW; ///< kg
		double coupling; ///< W between this contact and the next one of the pair, 1/kg
		std::array<double, mostPartners<dim>> weight;
		std::array<int, mostPartners<dim>> partner;
		int node;             ///< of the body on which the impulse acts, if not on an edge
		int facet;            ///< as in Contact
		signed char partners; ///< nodes of the other body that bear it
		bool onFirst;         ///< which body the impulse acts on
	};
	/// Constraints side by side, kept by somebody else. (Headers are for C++17, too.)
	class Constraints {
	public:
		Constraints() = default;
		Constraints(Constraint* first, std::size_t count)
			: first_(first)
			, count_(count)
		{
		}
		std::size_t size() const { return count_; }
		Constraint& operator[](std::size_t k) { return first_[k]; }
		const Constraint& operator[](std::size_t k) const { return first_[k]; }
		Constraint* begin() { return first_; }
		Constraint* end() { return first_ + count_; }
		const Constraint* begin() const { return first_; }
		const Constraint* end() const { return first_ + count_; }

	private:
		Constraint* first_ = nullptr;
		std::size_t count_ = 0;
	};

	/// Takes the contacts of `list`, whose bodies are in `bodies`, and applies the impulses
	/// left by the last step, made admissible for the present normals. `room` is where the
	/// constraints are to be kept until the next call, one for each contact.
	void prepare(std::vector<ContactBody<dim>>& bodies, ContactList<dim>& list, double dt,
		     const SolverSettings& settings, Constraint* room);
	/// Ask for memory that will be worked on. The first two may come before `prepare`: they go
	/// by addresses of the last step then, and read nothing through them.
	void fetchBodies() const;      ///< `prepare`
	void fetchVelocities() const;  ///< `prepare`, `sweep`, `residual`
	void fetchConstraints() const; ///< the last two
	void fetchResults() const;     ///< `finish`
	/// Solves each contact once, the others held; there must be one.
	SweepChange sweep(SweepOrder order);
	/// Solves all contacts together, those of other pairs held, until the violation (that of
	/// `residual`) is at most so much or the cap is hit; returns the number of sweeps.
	int solveAlone(double violation, int maxSweeps);
	/// Whether `solveAlone` does more than `sweep`, and its table is not too large.
	bool canBeSolvedAlone() const
	{
		return contacts() > 1 && contacts() <= PairProblem<dim>::mostContacts;
	}
	/// How far the present impulses are from a solution.
	ResidualSum residual() const;
	/// Gives the list its impulses and their sums, and adds them up on every contact node
	/// (ContactBody::impulse).
	void finish();
	int active() const { return list_->impulse.active; } ///< contacts with an impulse
	ContactWork work() const;
	void addHeldMotion(HeldMotion<dim>& motion) const;

	int contacts() const { return static_cast<int>(constraints_.size()); }
	const Constraints& constraints() const { return constraints_; }
	double friction(const Constraint& c) const
	{
		return frictions_.empty() ? friction_ : frictions_[numberOf(c)];
	}
	/// Impulses before the first sweep, contact by contact.
	const std::vector<Vec<dim>>& start() const { return start_; }
	/// u with the present impulses.
	Vec<dim> velocity(const Constraint& c) const
	{
		return relativeVelocity(c, ownSide(c).velocity, otherSide(c).velocity,
					drift_[c.onFirst]);
	}
	/// Calls with each body, node and share of the node in the contact's relative velocity.
	template <class Visit> void forEachShare(const Constraint& c, Visit&& visit) const
	{
		forOwnNodes<dim>(c, c.node, [&](int node, double w) {
			visit(static_cast<const ContactBody<dim>*>(own(c)), node, w);
		});
		for (int i = 0; i < c.partners; ++i)
			visit(static_cast<const ContactBody<dim>*>(other(c)), c.partner[i],
			      -c.weight[i]);
	}

private:
	ContactBody<dim>* own(const Constraint& c) const { return c.onFirst ? first_ : second_; }
	ContactBody<dim>* other(const Constraint& c) const { return c.onFirst ? second_ : first_; }
	/// All of a constraint but its coupling.
	void describe(const Contact<dim>& contact, const Bias& bias, Constraint& c) const;
	void engageInterface();
	/// W between two contacts.
	double couplingOf(const Constraint& c, const Constraint& d) const;
	Vec<dim> velocityBefore(const Constraint& c) const;
	/// Those of the nodes of the other body; null for a plane.
	const Vec<dim>* otherBefore(const Constraint& c) const
	{
		return c.partners > 0 ? other(c)->velocityBefore.data() : nullptr;
	}
	/// From velocities of the nodes of the body on which the impulse acts, and of the other.
	Vec<dim> relativeVelocity(const Constraint& c, const Vec<dim>* own, const Vec<dim>* other,
				  const Vec<dim>& drift) const;
	std::size_t numberOf(const Constraint& c) const { return &c - constraints_.begin(); }
	/// CoulombCone.hpp: with the present velocities.
	Vec<dim> wantedImpulse(const Constraint& c) const;
	double wantedAlongNormal(const Constraint& c) const; ///< its part along the normal
	bool isFrictionless() const { return friction_ == 0 && frictions_.empty(); }
	/// Calls with a function that tells the friction of a constraint: for most pairs a
	/// constant.
	template <class Visit> decltype(auto) withFriction(Visit&& visit) const
	{
		if (frictions_.empty())
			return visit([this](const Constraint&) { return friction_; });
		return visit([this](const Constraint& c) { return friction(c); });
	}
	void applyImpulse(const Constraint& c, const Vec<dim>& J);
	/// As the first body sees it, m.
	Vec<dim> placeOf(const Constraint& c) const;
	double spinOfOther(const Constraint& c) const; ///< ContactOutcome::spin
	/// Of a bond: calls with the nodes that bear it and their levers (Lever.hpp).
	template <class Visit> void forEachLever(const Constraint& c, Visit&& visit) const;
	/// u less what is no slip, as both bodies turn; from u and the velocities of the other
	/// body.
	Vec<dim> velocityAcross(const Constraint& c, const Vec<dim>& u,
				const Vec<dim>* bearing) const;
	/// Adds what an impulse does to velocities of the nodes of both bodies.
	void push(const Constraint& c, const Vec<dim>& J, Vec<dim>* own, Vec<dim>* other) const;
	void describe(PairProblem<dim>& problem) const;

	void findStretch(BodySide<dim>& side, bool ofFirst) const;
	const BodySide<dim>& ownSide(const Constraint& c) const
	{
		return c.onFirst ? firstSide_ : secondSide_;
	}
	const BodySide<dim>& otherSide(const Constraint& c) const
	{
		return c.onFirst ? secondSide_ : firstSide_;
	}

	ContactBody<dim>* first_ = nullptr;
	ContactBody<dim>* second_ = nullptr; ///< null for a plane
	ContactList<dim>* list_ = nullptr;   ///< valid for the step
	/// Of the plane, or of the image of the other body beyond its own velocity, m/s: for
	/// impulses on the second body and on the first.
	std::array<Vec<dim>, 2> drift_;
	PairInterface<dim>* interface_ = nullptr; ///< of the list; null if there is none
	double friction_ = 0;
	std::vector<double> frictions_; ///< contact by contact, where there is an interface
	BodySide<dim> firstSide_, secondSide_;
	Constraints constraints_; ///< in the room given
	std::vector<Vec<dim>> start_;
};

} // namespace softgrain
