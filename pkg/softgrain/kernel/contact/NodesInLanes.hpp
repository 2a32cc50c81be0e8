// Nodes of several candidates at a time against the curves that they are nearest to.
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactBody.hpp"
#include "material/VectorLanes.hpp"

namespace softgrain {

/// Up to `laneWidth` nodes, each with a piece of an outline without sharp nodes.
class NodesInLanes {
public:
	int count() const { return count_; }
	void clear() { count_ = 0; }
	bool isFull() const { return count_ == laneWidth; }
	/// A node at `x`, nearest to the place `t` of this facet of `other`.
	void add(const Vec<2>& x, const ContactBody<2>& other, int facet, double t);
	/// Finds the places of the curves that are nearest to the nodes.
	void measure();
	double gap(int lane) const { return gap_[lane]; }
	/// As measureGap.
	void write(int lane, Contact<2>& contact) const;

private:
	int count_ = 0;
	int facet_[laneWidth];
	std::array<int, 4> node_[laneWidth];
	VectorLanes x_ {}, carrier_[4] {}, normal_;
	Lanes t_ {}, gap_, weight_[4];
};

} // namespace softgrain
