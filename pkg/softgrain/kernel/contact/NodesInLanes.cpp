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

void NodesInLanes::add(const Vec<2>& x, const ContactBody<2>& other, int facet, double t)
{
	const int lane = count_++;
	facet_[lane] = facet;
	node_[lane] = other.mesh->carriers(facet);
	t_[lane] = t;
	setLane(x_, lane, x);
	for (int k = 0; k < 4; ++k)
		setLane(carrier_[k], lane, other.position[node_[lane][k]]);
}

/// Lanes without a node compute whatever there is.
SOFTGRAIN_FOR_ALL_INSTRUCTION_SETS void NodesInLanes::measure()
{
	const CurvePiece<VectorLanes> curve(carrier_[1], carrier_[1] - carrier_[0],
					    carrier_[2] - carrier_[1], carrier_[3] - carrier_[2]);
	const auto foot = curve.nearest(x_, t_);
	normal_ = foot.normal();
	gap_ = (x_ - foot.position).dot(normal_);
	curve.weights(foot.t, weight_);
}

void NodesInLanes::write(int lane, Contact<2>& contact) const
{
	contact.partners = mostPartners<2>;
	contact.facet = facet_[lane];
	contact.partner = node_[lane];
	for (int k = 0; k < 4; ++k)
		contact.weight[k] = weight_[k][lane];
	contact.normal = { normal_.x[lane], normal_.y[lane] };
	contact.gap = gap_[lane];
}

} // namespace softgrain
