#include "contact/Pressure.hpp"

namespace softgrain {

namespace {

/// Impulses of the pair on all nodes of the body on `side`.
template <int dim>
std::vector<Vec<dim>> nodeImpulses(const ContactBody<dim>& body, int side,
				   const std::vector<Contact<dim>>& contacts)
{
	std::vector<Vec<dim>> sum(body.nodes(), Vec<dim>::Zero());
	for (const Contact<dim>& c : contacts)
		if (c.key.side == side)
			sum[c.key.node] += c.impulse;
		else
			for (int i = 0; i < c.partners; ++i)
				sum[c.partner[i]] -= c.weight[i] * c.impulse;
	return sum;
}

} // namespace

template <int dim>
std::vector<ContactPressure>
contactPressures(const ContactBody<dim>& first, const ContactBody<dim>* second,
		 const std::vector<Contact<dim>>& contacts, double kick)
{
	std::vector<ContactPressure> result(contacts.size());
	if (!first.isSurface() || !(kick > 0)) return result;
	for (int side : { 0, 1 }) {
		const ContactBody<dim>* body = side == 0 ? &first : second;
		if (!body) continue;
		const auto impulse = nodeImpulses(*body, side, contacts);
		const auto area = body->nodeAreas();
		for (std::size_t c = 0; c < contacts.size(); ++c) {
			if (contacts[c].key.side != side) continue;
			const int s = contacts[c].key.node;
			const Vec<dim>& n = contacts[c].normal; // into the body
			Vec<dim> pushed = Vec<dim>::Zero();
			double smoothedArea = 0;
			for (int k = body->overlap->begin(s); k < body->overlap->end(s); ++k) {
				const int other = body->overlap->column[k];
				pushed += body->overlap->value[k] * impulse[other];
				smoothedArea -= body->overlap->value[k] * n.dot(area[other]);
			}
			result[c].area = -n.dot(area[s]);
			if (!(smoothedArea > 0)) continue;
			const Vec<dim> traction = pushed / (kick * smoothedArea);
			result[c].pressure = n.dot(traction);
			result[c].shear.template head<dim>() = traction - n.dot(traction) * n;
		}
	}
	return result;
}

template std::vector<ContactPressure> contactPressures<2>(const ContactBody<2>&,
							  const ContactBody<2>*,
							  const std::vector<Contact<2>>&, double);
template std::vector<ContactPressure> contactPressures<3>(const ContactBody<3>&,
							  const ContactBody<3>*,
							  const std::vector<Contact<3>>&, double);

} // namespace softgrain
