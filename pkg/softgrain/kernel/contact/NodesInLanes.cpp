#include "contact/NodesInLanes.hpp"
#include "contact/OutlineCurve.hpp"

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
	carrier_[count_] = other.mesh->carriers(facet);
	set.t[lane] = t;
	setLane(set.x, lane, x);
	for (int k = 0; k < 4; ++k)
		setLane(set.carrier[k], lane, other.position[carrier_[count_][k]]);
	++count_;
}

void NodesInLanes::Set::measure()
{
	const CurvePiece<VectorLanes> curve(carrier[1], carrier[1] - carrier[0],
					    carrier[2] - carrier[1], carrier[3] - carrier[2]);
	const auto foot = curve.nearest(x, t);
	normal = foot.normal();
	gap = (x - foot.position).dot(normal);
	curve.weights(foot.t, weight);
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
	contact.partners = mostPartners<2>;
	contact.facet = facet_[node];
	contact.partner = carrier_[node];
	for (int k = 0; k < 4; ++k)
		contact.weight[k] = set.weight[k][lane];
	contact.normal = { set.normal.x[lane], set.normal.y[lane] };
	contact.gap = set.gap[lane];
}

} // namespace softgrain
