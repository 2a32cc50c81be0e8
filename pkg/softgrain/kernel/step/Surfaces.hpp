// Surfaces of the grains of a system: when they are made anew, and what lies within reach of them.
#pragma once

#include "contact/ContactBody.hpp"
#include "contact/search/Search.hpp"
#include "step/Grains.hpp"

#include <atomic>
#include <vector>

namespace softgrain {

/// Whether a surface follows the state; it is renewed when it is asked for. Whoever asks first
/// renews it, others who ask meanwhile wait.
class Freshness {
public:
	Freshness() = default;
	Freshness(const Freshness& other) { *this = other; }
	Freshness& operator=(const Freshness& other)
	{
		state_.store(other.state_.load());
		return *this;
	}
	bool isFresh() const { return state_.load(std::memory_order_acquire) == fresh; }
	void expire() { state_.store(stale, std::memory_order_relaxed); }
	template <class Renew> void renew(Renew&& renewNow);

private:
	enum State : int { stale, busy, fresh };
	std::atomic<int> state_ { stale };
};

template <int dim> class Surfaces {
public:
	/// Of these grains, which must outlive it.
	explicit Surfaces(Grains<dim>& grains)
		: grains_(grains)
	{
	}
	/// After a set was added.
	void followNewGrains();

	/// With its surface as the state is. May be asked by several threads at a time.
	const ContactBody<dim>& body(int g) const
	{
		if (!surface_[g].isFresh()) renew(g);
		return bodies_[g];
	}
	/// With their surfaces as they were when somebody asked last.
	std::vector<ContactBody<dim>>& bodies() { return bodies_; }
	const std::vector<ContactBody<dim>>& bodies() const { return bodies_; }

	/// Renews positions of contact nodes and outlines from the state, after that was set by
	/// hand.
	void update(int g);
	void updateAll(int threads);
	/// Of the present positions, dt after the last ones; that of a rigid grain is left to who
	/// asks.
	void followMotion(int g, double dt);

	bool haveCommonGrid() const { return gridSpacing_ > 0; }
	/// ContactGeometry::nodes: nodes of the common grid in contact become the contact nodes of
	/// their grains.
	void useGridNodes(const std::vector<ContactList<dim>*>& lists);

	/// Tractions of interfaces act across gaps up to this, m; adds to every reach.
	void setInterfaceRange(double range) { interfaceRange_ = range; }
	double interfaceRange() const { return interfaceRange_; }
	/// Distance within which gaps must be handed to a step of dt: none closes by more in it.
	double reach(int first, int second, const PairImage<dim>& image, double dt) const;
	double reach(int g, const Plane<dim>& plane, double dt) const;
	double reach(int g, const RigidSide<dim>& rigid, const PairImage<dim>& image,
		     double dt) const;
	/// That of a grain at rest, from another as fine as it.
	double reachAtRest(int g) const;
	/// Renews the contacts of a pair (of a grain and a plane or a rigid body) within reach for
	/// a step of dt; may be called by several threads at a time. Balls about both come first:
	/// false if they are so far apart that no surface was looked at.
	bool search(ContactList<dim>& list, double dt) const;
	/// Whether balls about two grains are so far apart that nothing lies within reach for a
	/// step of dt. False: the search must tell.
	bool areFarApart(int first, int second, const PairImage<dim>& image, double dt) const;
	/// Whether the box of a grain grown by a margin lies within a box.
	bool isInside(int g, const Box<dim>& box, double margin) const;

private:
	/// A ball about a grain's outline.
	struct Ball {
		Vec<dim> centre;
		double radius;
	};

	void add(int g);
	/// Tells how far the contact nodes have come since the last time, m.
	VectorRange<dim> renewOutline(int g);
	void renew(int g) const;
	void measure(int g) const;
	void updateGridNodes(int g) const;
	Ball ballAbout(int g) const;
	bool isFarFrom(int g, const Plane<dim>& plane, double reach) const;
	bool isFarFrom(int g, const RigidSide<dim>& rigid, double reach) const;
	double outsideReach(double reach) const;

	Grains<dim>& grains_;
	mutable std::vector<ContactBody<dim>> bodies_;    ///< where `surface_` is fresh
	std::vector<std::vector<Vec<dim>>> lastPosition_; ///< of the contact nodes, m
	mutable std::vector<Freshness> surface_;
	double gridSpacing_ = 0; ///< ContactGeometry::nodes: the largest h of all grains, m
	double interfaceRange_ = 0;
};

} // namespace softgrain
