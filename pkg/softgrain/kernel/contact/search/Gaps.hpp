// Gaps of nodes to places on outlines, in the plane some at a time.
#pragma once

#include "contact/search/NodesInLanes.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <array>
#include <utility>

namespace softgrain {

/// Calls `take(node, measured)` for nodes in their order: `measured.write(contact)` is measureGap.
/// `Node`: what the caller knows them by. Of one kind one at a time in a thread.
template <int dim, class Node, class Take> class Gaps;

template <class Node, class Take> class Gaps<2, Node, Take> {
public:
	explicit Gaps(Take take)
		: take_(std::move(take))
	{
		lanes_.clear();
	}
	/// That of the next node, to be filled in before it is added.
	Node& next() { return node_[lanes_.count()]; }
	/// The next node is at `x`, nearest to a place of `other`.
	void add(const Vec<2>& x, const ContactOutline<2>& other, const PlaceOnOutline<2>& place)
	{
		lanes_.add(x, other, place.facet, place.weight[1]);
		if (lanes_.isFull()) measure();
	}
	/// Those that are left.
	void measure()
	{
		if (lanes_.count() == 0) return;
		lanes_.measure();
		for (int lane = 0; lane < lanes_.count(); ++lane)
			take_(node_[lane], Measured { lanes_, lane });
		lanes_.clear();
	}

private:
	struct Measured {
		const NodesInLanes& lanes;
		int lane;

		double gap() const { return lanes.gap(lane); }
		void write(Contact<2>& contact) const { lanes.write(lane, contact); }
	};
	/// (To make them anew for each pair takes a tenth of its search.)
	static NodesInLanes& lanesOfThread()
	{
		thread_local NodesInLanes lanes;
		return lanes;
	}
	static std::array<Node, NodesInLanes::most>& nodesOfThread()
	{
		thread_local std::array<Node, NodesInLanes::most> nodes;
		return nodes;
	}

	NodesInLanes& lanes_ = lanesOfThread();
	std::array<Node, NodesInLanes::most>& node_ = nodesOfThread();
	Take take_;
};

template <class Node, class Take> class Gaps<3, Node, Take> {
public:
	explicit Gaps(Take take)
		: take_(std::move(take))
	{
	}
	Node& next() { return node_; }
	void add(const Vec<3>& x, const ContactOutline<3>& other, const PlaceOnOutline<3>& place)
	{
		take_(node_, Measured { x, other, place });
	}
	void measure() {}

private:
	struct Measured {
		const Vec<3>& x;
		const ContactOutline<3>& other;
		const PlaceOnOutline<3>& place;

		void write(Contact<3>& contact) const { measureGap(x, other, place, contact); }
	};

	Node node_ {};
	Take take_;
};

} // namespace softgrain
