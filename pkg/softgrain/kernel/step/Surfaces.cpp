#include "step/Surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace softgrain {

template <class Renew> void Freshness::renew(Renew&& renewNow)
{
	auto become = [this](State state) {
		state_.store(state, std::memory_order_release);
		state_.notify_all();
	};
	for (int found = stale; !state_.compare_exchange_strong(found, busy); found = stale) {
		if (found == fresh) return;
		state_.wait(busy);
	}
	try {
		renewNow();
	} catch (...) { // out of memory: who waits tries in turn
		become(stale);
		throw;
	}
	become(fresh);
}

template <int dim> void Surfaces<dim>::followNewGrains()
{
	for (int g = static_cast<int>(bodies_.size()); g < grains_.count(); ++g)
		add(g);
	surface_.resize(bodies_.size());
}

template <int dim> void Surfaces<dim>::add(int g)
{
	const GrainSet<dim>& set = grains_.setOf(g);
	const GrainTemplate<dim>& reference = set.reference();
	const double radius = set.parameters(grains_.indexInSet(g)).radius;
	ContactBody<dim> body;
	body.mesh = &reference.contactMesh;
	body.nodeRadius = radius * reference.contactRadius;
	body.pointSpacing = radius * reference.pointSpacing();
	body.overlap = &reference.overlap;
	body.inradius = radius * reference.inradius;
	set.contactPositions(grains_.indexInSet(g), body.position);
	body.velocity.assign(reference.contactNodes(), Vec<dim>::Zero());
	body.impulse = body.velocity;
	lastPosition_.push_back(body.position);
	bodies_.push_back(std::move(body));
	if (reference.recipe.contact == ContactGeometry::nodes)
		gridSpacing_ = std::max(gridSpacing_, radius * reference.recipe.nodeSpacing *
							      reference.pointSpacing());
}

template <int dim> VectorRange<dim> Surfaces<dim>::renewOutline(int g)
{
	ContactBody<dim>& body = bodies_[g];
	lastPosition_[g].swap(body.position);
	surface_[g].expire();
	renew(g);
	const VectorRange<dim> way = rangeOfWays<dim>(lastPosition_[g], body.position);
	body.carried += way.middle;
	body.travelled += way.spread;
	return way;
}

template <int dim> void Surfaces<dim>::renew(int g) const
{
	surface_[g].renew([this, g] { measure(g); });
}

template <int dim> void Surfaces<dim>::measure(int g) const
{
	ContactBody<dim>& body = bodies_[g];
	grains_.setOf(g).contactPositions(grains_.indexInSet(g), body.position);
	body.updateGeometry();
	if (haveCommonGrid()) updateGridNodes(g);
}

template <int dim> void Surfaces<dim>::update(int g)
{
	renewOutline(g);
	bodies_[g].velocities = grains_.setOf(g).contactVelocityRange(grains_.indexInSet(g));
}

template <int dim> void Surfaces<dim>::followMotion(int g, double dt)
{
	ContactBody<dim>& body = bodies_[g];
	const GrainSet<dim>& set = grains_.setOf(g);
	const int k = grains_.indexInSet(g);
	if (grains_.isRigid(g)) {
		body.velocities = set.rigidBounds(k).velocities;
		body.travelled += dt * body.velocities.largestNorm();
		surface_[g].expire();
		return;
	}
	const VectorRange<dim> way = renewOutline(g);
	// a set that prepares its moves goes on with other velocities than it moved with
	body.velocities = set.preparesMove()
				  ? set.contactVelocityRange(k)
				  : VectorRange<dim> { way.middle / dt, way.spread / dt };
}

/// What the grain gives to the common grid at its present place.
template <int dim> void Surfaces<dim>::updateGridNodes(int g) const
{
	GridPoints<dim> points;
	grains_.setOf(g).massPoints(grains_.indexInSet(g), points.position, points.mass);
	bodies_[g].gridSpacing = gridSpacing_;
	bodies_[g].gridNode = nodesOnGrid(points, gridSpacing_);
}

template <int dim> void Surfaces<dim>::updateAll(int threads)
{
	std::vector<int> all(grains_.count());
	std::iota(all.begin(), all.end(), 0);
	grains_.forEachOf(all, threads, [this](int g, auto&&...) { update(g); });
}

template <int dim> void Surfaces<dim>::useGridNodes(const std::vector<ContactList<dim>*>& lists)
{
	std::vector<std::vector<char>> used(grains_.count());
	auto use = [&](int g, int node) {
		used[g].resize(bodies_[g].gridNode.size(), 0);
		used[g][node] = 1;
	};
	for (const ContactList<dim>* list : lists)
		for (const Contact<dim>& contact : list->contacts) {
			use(list->first, contact.key.node);
			if (contact.partners > 0) use(list->second, contact.partner[0]);
		}
	for (int g = 0; g < grains_.count(); ++g)
		if (!used[g].empty())
			grains_.setOf(g).useContactNodes(grains_.indexInSet(g),
							 pointShares(bodies_[g].gridNode, used[g]));
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
double Surfaces<dim>::reach(int first, int second, const PairImage<dim>& image, double dt) const
{
	const ContactBody<dim>&a = bodies_[first], &b = bodies_[second];
	const Vec<dim> apart = a.velocities.middle - b.velocities.middle - image.velocity;
	return withinRange(apart.norm() + a.velocities.spread + b.velocities.spread, dt,
			   std::min(a.pointSpacing, b.pointSpacing),
			   std::max(a.pointSpacing, b.pointSpacing), interfaceRange_);
}

template <int dim> double Surfaces<dim>::reach(int g, const Plane<dim>& plane, double dt) const
{
	const ContactBody<dim>& body = bodies_[g];
	const Vec<dim> apart = body.velocities.middle - plane.velocity;
	return withinRange(apart.norm() + body.velocities.spread, dt, body.pointSpacing,
			   body.pointSpacing, interfaceRange_);
}

template <int dim>
double Surfaces<dim>::reach(int g, const RigidSide<dim>& rigid, const PairImage<dim>& image,
			    double dt) const
{
	const ContactBody<dim>& body = bodies_[g];
	const Vec<dim> apart = body.velocities.middle - rigid.velocities.middle - image.velocity;
	return withinRange(apart.norm() + body.velocities.spread + rigid.velocities.spread, dt,
			   body.pointSpacing, body.pointSpacing, interfaceRange_);
}

template <int dim> double Surfaces<dim>::reachAtRest(int g) const
{
	const double spacing = bodies_[g].pointSpacing;
	return withinRange(0, 0, spacing, spacing, interfaceRange_);
}

template <int dim> typename Surfaces<dim>::Ball Surfaces<dim>::ballAbout(int g) const
{
	if (grains_.isRigid(g)) {
		const RigidBounds<dim> bounds = grains_.setOf(g).rigidBounds(grains_.indexInSet(g));
		return { bounds.centre, bounds.radius + bounds.bulge };
	}
	const ContactBody<dim>& own = body(g);
	return { own.box.centre(), own.outerRadius() };
}

/// Of two outlines that are further apart nothing is a contact: on the common grid each gives mass
/// to nodes up to a step of the grid away.
template <int dim> double Surfaces<dim>::outsideReach(double reach) const
{
	return reach + 2 * gridSpacing_;
}

template <int dim>
bool Surfaces<dim>::areFarApart(int first, int second, const PairImage<dim>& image, double dt) const
{
	const Ball a = ballAbout(first), b = ballAbout(second);
	const double distance = a.radius + b.radius + outsideReach(reach(first, second, image, dt));
	return (a.centre - b.centre - image.shift).squaredNorm() > distance * distance;
}

template <int dim> bool Surfaces<dim>::isFarFrom(int g, const Plane<dim>& plane, double reach) const
{
	if (!grains_.isRigid(g)) return false;
	const Ball ball = ballAbout(g);
	return (ball.centre - plane.point).dot(plane.normal) > ball.radius + outsideReach(reach);
}

template <int dim>
bool Surfaces<dim>::isFarFrom(int g, const RigidSide<dim>& rigid, double reach) const
{
	if (!grains_.isRigid(g)) return false;
	const Ball own = ballAbout(g);
	const BallSurface<dim> other = softgrain::ballAbout<dim>(rigid.surface);
	const double distance = own.radius + other.radius + outsideReach(reach);
	return (own.centre - other.centre).squaredNorm() > distance * distance;
}

namespace {

/// The outline, or its image where that is displaced: valid until the next call of this thread.
template <int dim>
const ContactOutline<dim>& imageOf(const ContactOutline<dim>& outline, const PairImage<dim>& image)
{
	if (image.shift.isZero(0)) return outline;
	thread_local ContactOutline<dim> displaced;
	displaced.becomeImage(outline, image.shift);
	return displaced;
}

} // namespace

template <int dim> bool Surfaces<dim>::search(ContactList<dim>& list, double dt) const
{
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

template <int dim> bool Surfaces<dim>::isInside(int g, const Box<dim>& box, double margin) const
{
	if (grains_.isRigid(g)) {
		const RigidBounds<dim> bounds = grains_.setOf(g).rigidBounds(grains_.indexInSet(g));
		if (box.contains({ bounds.centre, bounds.centre },
				 Vec<dim>::Constant(bounds.radius + margin)))
			return true;
	}
	return box.contains(body(g).box, Vec<dim>::Constant(margin));
}

template class Surfaces<2>;
template class Surfaces<3>;

} // namespace softgrain
