// Surfaces of the grains of a system: when they are made anew, and what lies within reach of them.
#include "step/System.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace softgrain {

template <class Renew> void Freshness::renew(Renew&& renewNow)
{
	int found = stale;
	if (state_.compare_exchange_strong(found, busy)) {
		renewNow();
		state_.store(fresh, std::memory_order_release);
		state_.notify_all();
	} else if (found == busy)
		state_.wait(busy);
}

template <int dim> void System<dim>::renewOutline(int g)
{
	ContactBody<dim>& body = bodies_[g];
	const Vec<dim> lastCentre = body.box.centre();
	lastPosition_[g].swap(body.position);
	surface_[g].expire();
	renewSurface(g);
	const Vec<dim> together = body.box.centre() - lastCentre;
	body.carried += together;
	body.travelled += farthestWay<dim>(lastPosition_[g], body.position, together);
}

template <int dim> void System<dim>::renewSurface(int g) const
{
	surface_[g].renew([this, g] { measureSurface(g); });
}

template <int dim> void System<dim>::measureSurface(int g) const
{
	ContactBody<dim>& body = bodies_[g];
	setOf(g).contactPositions(indexInSet(g), body.position);
	body.updateGeometry();
	if (gridSpacing_ > 0) updateGridNodes(g);
}

template <int dim> void System<dim>::updateSurface(int g)
{
	renewOutline(g);
	bodies_[g].velocities = setOf(g).contactVelocityRange(indexInSet(g));
}

/// Of the present positions, dt after the last ones; that of a rigid grain is left to who asks.
template <int dim> void System<dim>::followMotion(int g, double dt)
{
	ContactBody<dim>& body = bodies_[g];
	body.velocities = setOf(g).contactVelocityRange(indexInSet(g));
	if (isRigid(g)) {
		body.travelled += dt * body.velocities.fastest();
		surface_[g].expire();
	} else
		renewOutline(g);
}

/// What the grain gives to the common grid at its present place.
template <int dim> void System<dim>::updateGridNodes(int g) const
{
	GridPoints<dim> points;
	setOf(g).massPoints(indexInSet(g), points.position, points.mass);
	bodies_[g].gridSpacing = gridSpacing_;
	bodies_[g].gridNode = nodesOnGrid(points, gridSpacing_);
}

template <int dim> void System<dim>::updateSurfaces(int threads)
{
	std::vector<int> all(grains());
	std::iota(all.begin(), all.end(), 0);
	forEachOf(all, threads, [this](int g, auto&&...) { updateSurface(g); });
	forcesFresh_ = false;
}

namespace {

/// Gaps that both bodies together could close in two steps at their present speeds, and never less
/// than a twentieth of the point spacing, for grains that are just being accelerated.
double reachOf(double speed, double dt, double pointSpacing)
{
	return std::max(2 * dt * speed, 0.05 * pointSpacing);
}

/// The same with interfaces that act across `range`: nodes beyond it stand for places within, on
/// outlines that are inclined to each other up to half of the coarser spacing.
double withinRange(double speed, double dt, double finer, double coarser, double range)
{
	const double touch = reachOf(speed, dt, finer);
	return range > 0 ? range + std::max(touch, 0.5 * coarser) : touch;
}

} // namespace

template <int dim>
double System<dim>::reach(int first, int second, const PairImage<dim>& image, double dt) const
{
	const ContactBody<dim>&a = bodies_[first], &b = bodies_[second];
	const Vec<dim> apart = a.velocities.middle - b.velocities.middle - image.velocity;
	return withinRange(apart.norm() + a.velocities.spread + b.velocities.spread, dt,
			   std::min(a.pointSpacing, b.pointSpacing),
			   std::max(a.pointSpacing, b.pointSpacing), interfaceRange_);
}

template <int dim> double System<dim>::reach(int g, const Plane<dim>& plane, double dt) const
{
	const ContactBody<dim>& body = bodies_[g];
	const Vec<dim> apart = body.velocities.middle - plane.velocity;
	return withinRange(apart.norm() + body.velocities.spread, dt, body.pointSpacing,
			   body.pointSpacing, interfaceRange_);
}

template <int dim>
double System<dim>::reach(int g, const RigidSide<dim>& rigid, const PairImage<dim>& image,
			  double dt) const
{
	const double spacing = bodies_[g].pointSpacing;
	return withinRange(bodies_[g].velocities.fastest() + rigid.speed + image.velocity.norm(),
			   dt, spacing, spacing, interfaceRange_);
}

template <int dim> typename System<dim>::Ball System<dim>::ballAbout(int g) const
{
	if (isRigid(g)) {
		const RigidBounds<dim> bounds = setOf(g).rigidBounds(indexInSet(g));
		return { bounds.centre, bounds.radius + bounds.bulge };
	}
	const ContactBody<dim>& own = body(g);
	// the outline bulges out of its facets by less than half of an edge
	return { own.box.centre(), own.circumradius + own.nodeRadius + 0.5 * own.longestEdge };
}

/// Of two outlines that are further apart nothing is a contact: on the common grid each gives mass
/// to nodes up to a step of the grid away.
template <int dim> double System<dim>::outsideReach(double reach) const
{
	return reach + 2 * gridSpacing_;
}

template <int dim>
bool System<dim>::areFarApart(int first, int second, const PairImage<dim>& image, double dt) const
{
	const Ball a = ballAbout(first), b = ballAbout(second);
	const double distance = a.radius + b.radius + outsideReach(reach(first, second, image, dt));
	return (a.centre - b.centre - image.shift).squaredNorm() > distance * distance;
}

template <int dim> bool System<dim>::isFarFrom(int g, const Plane<dim>& plane, double reach) const
{
	if (!isRigid(g)) return false;
	const Ball ball = ballAbout(g);
	return (ball.centre - plane.point).dot(plane.normal) > ball.radius + outsideReach(reach);
}

template <int dim>
bool System<dim>::isFarFrom(int g, const RigidSide<dim>& rigid, double reach) const
{
	if (!isRigid(g)) return false;
	const Ball own = ballAbout(g);
	const BallSurface<dim> other = softgrain::ballAbout<dim>(rigid.surface);
	const double distance = own.radius + other.radius + outsideReach(reach);
	return (own.centre - other.centre).squaredNorm() > distance * distance;
}

namespace {

/// The body, or its image where that is displaced: valid until the next call of this thread.
template <int dim>
const ContactBody<dim>& imageOf(const ContactBody<dim>& body, const PairImage<dim>& image)
{
	if (image.shift.isZero(0)) return body;
	thread_local ContactBody<dim> displaced;
	displaced.becomeImage(body, image.shift);
	return displaced;
}

} // namespace

template <int dim> bool System<dim>::search(ContactList<dim>& list, double dt) const
{
	if (list.isAsleep()) {
		if (!liesStill(list))
			list.rest.changed = true;
		else if (list.rest.found)
			return false;
	}
	list.rest.found = true;
	auto searchWithin = [&](double within, bool isFar) {
		if (isFar)
			list.clearContacts();
		else if (list.second < 0)
			findContacts(body(list.first), within, list);
		else
			findContacts(body(list.first), imageOf(body(list.second), list.image),
				     within, list);
		return !isFar;
	};
	if (list.second >= 0)
		return searchWithin(reach(list.first, list.second, list.image, dt),
				    areFarApart(list.first, list.second, list.image, dt));
	auto searchOn = [&](const auto& surface, double within) {
		return searchWithin(within, isFarFrom(list.first, surface, within));
	};
	return list.rigid ? searchOn(*list.rigid, reach(list.first, *list.rigid, list.image, dt))
			  : searchOn(list.plane, reach(list.first, list.plane, dt));
}

template <int dim> bool System<dim>::isInside(int g, const Box<dim>& box, double margin) const
{
	auto holds = [&box](const Box<dim>& own) {
		return (own.low.array() >= box.low.array()).all() &&
		       (own.high.array() <= box.high.array()).all();
	};
	if (isRigid(g)) {
		const RigidBounds<dim> bounds = setOf(g).rigidBounds(indexInSet(g));
		const Box<dim> about { bounds.centre, bounds.centre };
		if (holds(about.grown(bounds.radius + margin))) return true;
	}
	return holds(body(g).box.grown(margin));
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void System<dim>::updateSurfaces(int);                                            \
	template void System<dim>::updateSurface(int);                                             \
	template void System<dim>::renewSurface(int) const;                                        \
	template void System<dim>::followMotion(int, double);                                      \
	template double System<dim>::reach(int, int, const PairImage<dim>&, double) const;         \
	template double System<dim>::reach(int, const Plane<dim>&, double) const;                  \
	template double System<dim>::reach(int, const RigidSide<dim>&, const PairImage<dim>&,      \
					   double) const;                                          \
	template bool System<dim>::search(ContactList<dim>&, double) const;                        \
	template bool System<dim>::areFarApart(int, int, const PairImage<dim>&, double) const;     \
	template bool System<dim>::isInside(int, const Box<dim>&, double) const;
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
