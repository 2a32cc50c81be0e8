#include "contact/ContactSolver.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Projection onto Coulomb's cone, normal part first (exact for the one-contact problem).
template <int dim> Vec<dim> onCone(const Vec<dim>& r, const Vec<dim>& n, double friction)
{
	const double normal = r.dot(n);
	if (normal <= 0) return Vec<dim>::Zero();
	const Vec<dim> tangential = r - normal * n;
	const double size = tangential.norm(), bound = friction * normal;
	if (size <= bound) return r;
	return normal * n + (bound / size) * tangential;
}

template <int dim>
double inverseMobility(const Contact<dim>& contact, const ContactBody<dim>& body,
		       const ContactBody<dim>* partner)
{
	double W = body.mobility(contact.key.node, contact.key.node);
	for (int i = 0; i < contact.partners; ++i)
		for (int j = 0; j < contact.partners; ++j)
			W += contact.weight[i] * contact.weight[j] *
			     partner->mobility(contact.partner[i], contact.partner[j]);
	return 1 / W;
}

} // namespace

template <int dim>
void ContactSolver<dim>::prepare(std::vector<ContactBody<dim>>& bodies,
				 std::vector<ContactList<dim>*>& lists, double dt,
				 const SolverSettings& settings)
{
	settings_ = settings;
	constraints_.clear();
	for (ContactList<dim>* list : lists)
		for (Contact<dim>& contact : list->contacts) {
			ContactBody<dim>* first = &bodies[list->first];
			ContactBody<dim>* second =
				list->second < 0 ? nullptr : &bodies[list->second];
			Constraint c;
			c.contact = &contact;
			c.body = contact.key.side == 0 ? first : second;
			c.partner = contact.key.side == 0 ? second : first;
			c.planeVelocity =
				second ? Vec<dim>(Vec<dim>::Zero()) : list->plane.velocity;
			c.inverseW = inverseMobility(contact, *c.body, c.partner);
			c.bias = contact.gap >= 0
					 ? contact.gap / dt
					 : std::max(settings.overlapRelaxation * contact.gap / dt,
						    -settings.overlapSpeed);
			c.friction = list->friction;
			constraints_.push_back(c);
		}
}

template <int dim>
Vec<dim> ContactSolver<dim>::relativeVelocity(const Constraint& c,
					      std::vector<Vec<dim>> ContactBody<dim>::* field) const
{
	const Contact<dim>& contact = *c.contact;
	Vec<dim> u = (c.body->*field)[contact.key.node] - c.planeVelocity;
	for (int i = 0; i < contact.partners; ++i)
		u -= contact.weight[i] * (c.partner->*field)[contact.partner[i]];
	return u;
}

template <int dim> void ContactSolver<dim>::applyImpulse(const Constraint& c, const Vec<dim>& J)
{
	const Contact<dim>& contact = *c.contact;
	c.body->push(contact.key.node, J);
	for (int i = 0; i < contact.partners; ++i)
		c.partner->push(contact.partner[i], -contact.weight[i] * J);
}

template <int dim>
Vec<dim> ContactSolver<dim>::solvedImpulse(const Constraint& c, const Vec<dim>& r) const
{
	const Vec<dim>& n = c.contact->normal;
	const Vec<dim> u = relativeVelocity(c, &ContactBody<dim>::velocity);
	return onCone<dim>(r - c.inverseW * (u + c.bias * n), n, c.friction);
}

template <int dim> void ContactSolver<dim>::warmStart()
{
	for (const Constraint& c : constraints_) {
		c.contact->impulse = onCone<dim>(c.contact->impulse, c.contact->normal, c.friction);
		if (!c.contact->impulse.isZero(0)) applyImpulse(c, c.contact->impulse);
	}
}

template <int dim> double ContactSolver<dim>::sweep(bool forwards)
{
	double changed = 0, total = 0;
	const std::size_t count = constraints_.size();
	for (std::size_t k = 0; k < count; ++k) {
		const Constraint& c = constraints_[forwards ? k : count - 1 - k];
		const Vec<dim> r = solvedImpulse(c, c.contact->impulse);
		const Vec<dim> J = r - c.contact->impulse;
		total += r.squaredNorm() / c.inverseW;
		if (J.isZero(0)) continue;
		changed += J.squaredNorm() / c.inverseW;
		c.contact->impulse = r;
		applyImpulse(c, J);
	}
	return total > 0 ? std::sqrt(changed / total) : std::sqrt(changed);
}

template <int dim> SolverReport ContactSolver<dim>::solve()
{
	SolverReport report;
	report.contacts = static_cast<int>(constraints_.size());
	if (constraints_.empty()) return report;
	do {
		report.change = sweep(report.sweeps % 2 == 0);
		++report.sweeps;
	} while (report.change > settings_.tolerance && report.sweeps < settings_.maxSweeps);
	report.converged = report.change <= settings_.tolerance;
	for (const Constraint& c : constraints_)
		report.active += !c.contact->impulse.isZero(0);
	return report;
}

template <int dim> double ContactSolver<dim>::residual() const
{
	double largest = 0, violation = 0;
	for (const Constraint& c : constraints_) {
		largest = std::max(largest, c.contact->impulse.norm());
		violation = std::max(
			violation,
			(solvedImpulse(c, c.contact->impulse) - c.contact->impulse).norm());
	}
	return largest > 0 ? violation / largest : violation;
}

template <int dim> void ContactSolver<dim>::collectImpulses()
{
	for (const Constraint& c : constraints_) {
		const Contact<dim>& contact = *c.contact;
		c.body->impulse[contact.key.node] += contact.impulse;
		for (int i = 0; i < contact.partners; ++i)
			c.partner->impulse[contact.partner[i]] -=
				contact.weight[i] * contact.impulse;
	}
}

template <int dim> ContactWork ContactSolver<dim>::work() const
{
	ContactWork work;
	for (const Constraint& c : constraints_) {
		const Vec<dim>& r = c.contact->impulse;
		const Vec<dim> normal = r.dot(c.contact->normal) * c.contact->normal;
		const Vec<dim> before = relativeVelocity(c, &ContactBody<dim>::velocityBefore);
		const Vec<dim> after = relativeVelocity(c, &ContactBody<dim>::velocity);
		work.impact.before -= 0.5 * normal.dot(before);
		work.impact.after -= 0.5 * normal.dot(after);
		work.friction.before -= 0.5 * (r - normal).dot(before);
		work.friction.after -= 0.5 * (r - normal).dot(after);
		work.planes.before += 0.5 * r.dot(c.planeVelocity);
		work.planes.after += 0.5 * r.dot(c.planeVelocity);
	}
	return work;
}

template class ContactSolver<2>;
template class ContactSolver<3>;

} // namespace softgrain
