#include "contact/search/NodesInLanes.hpp"

namespace softgrain {

namespace {

void setLane(VectorLanes& lanes, int lane, const Vec<2>& v)
{
	lanes.x[lane] = v[0];
	lanes.y[lane] = v[1];
}

} // namespace

void NodesInLanes::add(const Vec<2>& x, const ContactOutline<2>& other, int facet, double t)
{
	Set& set = set_[count_ / laneWidth];
	const int lane = count_ % laneWidth;
	facet_[count_] = facet;
	other_[count_] = &other;
	set.t[lane] = t;
	setLane(set.x, lane, x);
	const NodeWays<Vec<2>> curve = nodesOver(other, facet);
	setLane(set.curve.start, lane, curve.start);
	setLane(set.curve.before, lane, curve.before);
	setLane(set.curve.edge, lane, curve.edge);
	setLane(set.curve.next, lane, curve.next);
	++count_;
}

void NodesInLanes::Set::measure()
{
	const CurvePiece<VectorLanes> piece(curve);
	const auto foot = piece.nearest(x, t);
	normal = foot.normal();
	gap = (x - foot.position).dot(normal);
	piece.weights(foot.t, weight);
}

/// Lanes without a node compute whatever there is.
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void NodesInLanes::measure()
{
	for (int begin = 0; begin < count_; begin += laneWidth)
		set_[begin / laneWidth].measure();
}

void NodesInLanes::write(int node, Contact<2>& contact) const
{
	const Set& set = set_[node / laneWidth];
	const int lane = node % laneWidth;
	const ContactOutline<2>& other = *other_[node];
	contact.partners = mostPartners<2>;
	contact.facet = facet_[node];
	contact.partner = other.mesh->carriers(contact.facet);
	std::array<double, 4> weight;
	for (int k = 0; k < 4; ++k)
		weight[k] = set.weight[k][lane];
	contact.weight = sharesOfNodes(weight, other.isSharp(contact.partner[1]),
				       other.isSharp(contact.partner[2]));
	contact.normal = { set.normal.x[lane], set.normal.y[lane] };
	contact.gap = set.gap[lane];
}

} // namespace softgrain
