// Nodes of several candidates at a time against the curves that they are nearest to.
#pragma once

#include "contact/Contact.hpp"
#include "contact/ContactOutline.hpp"
#include "contact/search/OutlineCurve.hpp"

namespace softgrain {

/// Up to `most` nodes, each with a piece of an outline.
class NodesInLanes {
public:
	/// What is computed in one set of lanes is waited for; two overlap.
	static constexpr int sets = 2, most = sets * laneWidth;

	int count() const { return count_; }
	void clear() { count_ = 0; }
	bool isFull() const { return count_ == most; }
	/// A node at `x`, nearest to the place `t` of this facet of `other`.
	void add(const Vec<2>& x, const ContactOutline<2>& other, int facet, double t);
	/// Finds the places of the curves that are nearest to the nodes.
	void measure();
	double gap(int node) const { return set_[node / laneWidth].gap[node % laneWidth]; }
	/// As measureGap.
	void write(int node, Contact<2>& contact) const;

private:
	/// Nodes, curves and the nearest places on them, `laneWidth` of each.
	struct Set {
		VectorLanes x {}, normal;
		NodeWays<VectorLanes> curve {};
		Lanes t {}, gap, weight[4];
		void measure();
	};

	int count_ = 0;
	int facet_[most];
	const ContactOutline<2>* other_[most];
	Set set_[sets];
};

} // namespace softgrain
