#include "contact/Pressure.hpp"

#include <algorithm>
#include <cmath>

namespace softgrain {

namespace {

/// Impulses of the pair on all nodes of the body on `side`.
template <int dim>
std::vector<Vec<dim>> nodeImpulses(const ContactBody<dim>& body, int side,
				   const std::vector<Contact<dim>>& contacts)
{
	std::vector<Vec<dim>> sum(body.nodes(), Vec<dim>::Zero());
	for (const Contact<dim>& c : contacts)
		if (c.key.body() == side)
			c.forOwnNodes([&](int node, double w) { sum[node] += w * c.impulse; });
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

namespace {

template <int dim> ContactArea partOf(const ContactBody<dim>& body, const Contact<dim>& contact)
{
	const int node = contact.key.node;
	const Vec<dim> area = body.nodeArea(node);
	const double along = -contact.normal.dot(area);
	if (along <= 0) return {};
	if (body.isSharp(node)) return { along, 0 };
	const double length = dim == 2 ? area.norm() : std::sqrt(area.norm());
	const double cosine = contact.normal.dot(body.normal[node]);
	return { along, length * std::sqrt(std::max(0., 1 - cosine * cosine)) };
}

} // namespace

template <int dim>
std::vector<ContactArea> contactAreas(const ContactBody<dim>& first, const ContactBody<dim>* second,
				      const std::vector<Contact<dim>>& contacts)
{
	std::vector<ContactArea> result(contacts.size());
	for (int side : { 0, 1 }) {
		const ContactBody<dim>* body = side == 0 ? &first : second;
		if (!body || !body->isSurface()) continue;
		for (std::size_t c = 0; c < contacts.size(); ++c) {
			if (contacts[c].key.side != side) continue;
			result[c] = partOf<dim>(*body, contacts[c]);
			if (second) result[c].area *= 0.5;
		}
	}
	return result;
}

template std::vector<ContactArea> contactAreas<2>(const ContactBody<2>&, const ContactBody<2>*,
						  const std::vector<Contact<2>>&);
template std::vector<ContactArea> contactAreas<3>(const ContactBody<3>&, const ContactBody<3>*,
						  const std::vector<Contact<3>>&);
template std::vector<ContactPressure> contactPressures<2>(const ContactBody<2>&,
							  const ContactBody<2>*,
							  const std::vector<Contact<2>>&, double);
template std::vector<ContactPressure> contactPressures<3>(const ContactBody<3>&,
							  const ContactBody<3>*,
							  const std::vector<Contact<3>>&, double);

} // namespace softgrain
