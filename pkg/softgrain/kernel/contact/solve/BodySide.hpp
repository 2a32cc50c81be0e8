// A body as the sweeps see it: what they read and change of it, and how an impulse moves its nodes.
// Kept beside the contacts of a pair until the next `prepare`: read off the body it would be three
// or four more cache lines for each of the two, which counts in the plane, where contacts are
// cheap.
#pragma once

#include "contact/ContactBody.hpp"

namespace softgrain {

template <int dim> struct BodySide {
	const ContactBody<dim>* body = nullptr; ///< null for a plane
	Vec<dim>* velocity = nullptr;           ///< of its nodes
	const SurfaceMobility<dim>* mobility = nullptr;
	double scale = 0; ///< ContactBody::delassusScale
	/// Nodes that contacts read, from the first to behind the last (2D: where the outline
	/// closes in between, it is all of them).
	int firstRead = 0, endOfRead = 0;

	BodySide() = default;
	explicit BodySide(ContactBody<dim>& of)
		: body(&of)
		, velocity(of.velocity.data())
		, mobility(of.surfaceMobility)
		, scale(of.delassusScale)
	{
	}

	/// W of a contact node, and of the place that partners of a contact bear, 1/kg. `Bearing`
	/// is a Contact or what is kept of one: facet, partners, partner, weight.
	double mobilityOf(int node) const
	{
		return mobility ? scale * mobility->ofNode(node) : body->mobility(node, node);
	}
	template <class Bearing> double mobilityOf(const Bearing& place) const;
	/// W between two contact nodes, and between such a place and a node, 1/kg.
	double mobilityBetween(int node, int other) const
	{
		return mobility ? scale * mobility->between(node, other)
				: body->mobility(node, other);
	}
	template <class Bearing> double mobilityBetween(const Bearing& place, int other) const;
	/// v += W J, at least of the nodes in contact: an impulse on a node, and on a place, where
	/// it is `sign` J.
	void push(Vec<dim>* v, int node, const Vec<dim>& J) const;
	template <class Bearing>
	void push(Vec<dim>* v, const Bearing& place, const Vec<dim>& J, double sign) const;

private:
	/// v += w W J of all nodes.
	void pushRow(Vec<dim>* v, int node, double w, const Vec<dim>& scaled) const;
};

// --- inline, since sweeps consist of it ----------------------------------------------------------

template <int dim>
template <class Bearing>
double BodySide<dim>::mobilityOf(const Bearing& place) const
{
	if (mobility) return scale * mobility->ofPlace(place.facet, place.weight);
	double W = 0;
	for (int i = 0; i < place.partners; ++i)
		for (int j = 0; j < place.partners; ++j)
			W += place.weight[i] * place.weight[j] *
			     body->mobility(place.partner[i], place.partner[j]);
	return W;
}

template <int dim>
template <class Bearing>
double BodySide<dim>::mobilityBetween(const Bearing& place, int other) const
{
	if (mobility) return scale * mobility->between(place.facet, place.weight, other);
	double W = 0;
	for (int i = 0; i < place.partners; ++i)
		W += place.weight[i] * body->mobility(place.partner[i], other);
	return W;
}

template <int dim>
void BodySide<dim>::pushRow(Vec<dim>* v, int node, double w, const Vec<dim>& scaled) const
{
	const SparseRows<double>& W = *body->delassus;
	for (int k = W.begin(node); k < W.end(node); ++k)
		addScaled<dim>(v[W.column[k]], w * W.value[k], scaled);
}

template <int dim> void BodySide<dim>::push(Vec<dim>* v, int node, const Vec<dim>& J) const
{
	const Vec<dim> scaled = scale * J;
	if (mobility) {
		if constexpr (dim == 2)
			mobility->push(v, node, scaled);
		else
			mobility->push(v, body->markedBlocks.data(), node, scaled);
	} else
		pushRow(v, node, 1, scaled);
}

template <int dim>
template <class Bearing>
void BodySide<dim>::push(Vec<dim>* v, const Bearing& place, const Vec<dim>& J, double sign) const
{
	const Vec<dim> scaled = (sign * scale) * J;
	if (mobility) {
		if constexpr (dim == 2)
			mobility->push(v, place.facet, place.weight, scaled);
		else
			mobility->push(v, body->markedBlocks.data(), place.facet, place.weight,
				       scaled);
	} else
		for (int i = 0; i < place.partners; ++i)
			pushRow(v, place.partner[i], place.weight[i], scaled);
}

} // namespace softgrain
