#include "contact/search/CornerSearch.hpp"
#include "Fetch.hpp"
#include "contact/search/CandidateFacets.hpp"
#include "contact/search/EdgeCrossing.hpp"
#include "contact/search/Gaps.hpp"
#include "contact/search/OutlineEdges.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace softgrain {

namespace {

/// Whether a place outside of a grain lies before a facet, not behind it on the far side of a thin
/// arm.
bool isBefore(const Vec<2>& x, const ContactOutline<2>& body, int facet)
{
	const Vec<2>& start = body.position[body.mesh->facet[facet][0]];
	const double height = (x - start).dot(body.normalOfFacet(facet));
	return height >= 0 || height >= -OutlineCurve(body, facet).bulge();
}

/// In 3D no grain has thin arms.
bool isBefore(const Vec<3>&, const ContactOutline<3>&, int) { return true; }

/// Deeper nodes, in dr, are looked at once more: whether they are inside at all. Bent sides feign 1
/// to 2; what is pressed in stays far below, and need not be looked at.
constexpr double trustedDepth = 0.5;

/// What is always near, as a clearance.
constexpr double none = -std::numeric_limits<double>::infinity();

/// Whether x is outside of a grain, known the place on its facets that is nearest.
bool isOutside(const Vec<2>& x, const ContactOutline<2>& body, const PlaceOnOutline<2>& place)
{
	const auto [before, begin, end, after] = body.mesh->carriers(place.facet);
	const Vec<2> along = body.position[end] - body.position[begin];
	double turn = 0; // where two facets meet
	if (place.weight[0] == 0) turn = cross(along, body.position[after] - body.position[end]);
	if (place.weight[1] == 0) turn = cross(body.position[begin] - body.position[before], along);
	if (turn != 0) return turn > 0;
	return cross(along, x - body.position[begin]) < 0;
}
/// (Beyond an edge or a corner x is before one of the facets that meet there: Baerentzen & Aanaes,
/// IEEE Trans. Vis. Comput. Graph. 11, 2005.)
bool isOutside(const Vec<3>& x, const ContactOutline<3>& body, const PlaceOnOutline<3>& place)
{
	auto isBefore = [&](int facet) {
		const Vec<3>& corner = body.position[body.mesh->facet[facet][0]];
		return (x - corner).dot(body.areaOfFacet(facet)) > 0;
	};
	if (isBefore(place.facet)) return true;
	for (int i = 0; i < 3; ++i) {
		if (!(place.weight[i] > 0)) continue;
		const auto& about = body.mesh->facetsAbout[body.mesh->facet[place.facet][i]];
		if (std::any_of(about.begin(), about.end(), isBefore)) return true;
	}
	return false;
}

/// Whether a node lies beside a place that bears it, beyond the smooth end of the curve over its
/// facet, and farther from it than `reach`.
bool isAside(const Vec<2>& x, const ContactOutline<2>& body, const PlaceOnOutline<2>& place,
	     const Contact<2>& contact, double reach)
{
	for (int i : { 0, 1 })
		if (place.weight[i] == 0 && body.isSharp(body.mesh->facet[place.facet][1 - i]))
			return false;
	Vec<2> apart = x;
	for (int i = 0; i < contact.partners; ++i)
		apart -= contact.weight[i] * body.position[contact.partner[i]];
	return contact.gap > 0 && apart.squaredNorm() >= reach * reach;
}
/// In 3D outlines are smooth but for edges.
bool isAside(const Vec<3>&, const ContactOutline<3>&, const PlaceOnOutline<3>&, const Contact<3>&,
	     double)
{
	return false;
}

/// By how much, in dr, a gap may be less than the distance from the facets: by what an edge is
/// wide, and in 3D as normals turn.
template <int dim> constexpr double lessThanDistance = std::max(edgeWidth, jumpOfGaps<dim>);

/// The same of any outline, bulges included, m.
template <int dim> double mostBelowDistance(const ContactOutline<dim>& body)
{
	return body.bulge() + lessThanDistance<dim> * body.pointSpacing;
}

/// The outline bulges out of a facet by less, m.
double bulgeOver(const ContactOutline<2>& body, int facet)
{
	return OutlineCurve(body, facet).bulge();
}
/// (As measureGap has it: half of a sum with weights w_i w_j, i < j, which are 1/3 together at
/// most.)
double bulgeOver(const ContactOutline<3>& body, int facet)
{
	const auto& vertex = body.mesh->facet[facet];
	double most = 0;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < i; ++j)
			most = std::max(
				most,
				(body.normalAt(facet, vertex[j]) - body.normalAt(facet, vertex[i]))
					.dot(body.position[vertex[j]] - body.position[vertex[i]]));
	return most / 6;
}

/// Some facets of an outline, to be told apart by distance.
template <int dim> struct NearFacets {
	const ContactOutline<dim>& body;
	FacetBalls<dim> facets;
	double bulge = 0; ///< over any of them, m

	NearFacets(const ContactOutline<dim>& of, FacetBalls<dim> some)
		: body(of)
		, facets(std::move(some))
	{
		for (int f : facets.facets())
			bulge = std::max(bulge, bulgeOver(body, f));
	}
	/// Nearest to x of all places, known one on a facet (-1: none).
	PlaceOnOutline<dim> nearest(const Vec<dim>& x, int facet) const
	{
		const PlaceOnOutline<dim> start =
			facet < 0 ? PlaceOnOutline<dim>() : placeOnFacet(x, body, facet);
		return nearestPlace(x, body, facets, anyFacet, start);
	}
	/// What the gap of a node outside is at least, m.
	double leastGap(const PlaceOnOutline<dim>& place) const
	{
		return std::sqrt(place.squaredDistance) - bulge -
		       lessThanDistance<dim> * body.pointSpacing;
	}
};

template <int dim>
void findCandidates(const ContactOutline<dim>& body, const ContactOutline<dim>& other, int side,
		    double within, ContactList<dim>& list)
{
	ContactCandidates<dim>& candidates = list.candidates;
	const double distance = within + mostBelowDistance(other);
	const auto nodes = nodesNear(body, other, distance - other.bulge()); // it adds that itself
	if (nodes.empty()) return;
	const NearFacets<dim> near(other, facetsNear(body, other, distance));
	if (near.facets.empty()) return;
	list.tested += static_cast<int>(nodes.size());
	int facet = -1;
	for (int s : nodes) {
		const Vec<dim>& x = body.position[s];
		const auto place = near.nearest(x, facet);
		const double gap = near.leastGap(place);
		facet = place.facet;
		const bool inside = gap > 0 && !isOutside(x, other, place);
		if (inside || gap < within)
			candidates.nodes.push_back(
				{ side, s, facet, inside ? none : gap + candidates.approached });
	}
}

/// A candidate and where it lies against the other outline.
template <int dim> struct NodeAtPlace {
	const typename ContactCandidates<dim>::Node* node;
	PlaceOnOutline<dim> nearest, beside; ///< of all, and of those that may bear the node
	bool isNearest;                      ///< the first may, too
	bool faces;                          ///< whether the node faces it

	const PlaceOnOutline<dim>& place() const { return isNearest ? nearest : beside; }
};

/// Measures nodes of one body at the outline of the other in one step.
template <int dim> class NodesAtCorners {
public:
	using Node = typename ContactCandidates<dim>::Node;

	NodesAtCorners(const ContactOutline<dim>& body, const ContactOutline<dim>& other,
		       double reach, ContactList<dim>& list)
		: body_(body)
		, other_(other)
		, reach_(reach)
		, deep_(contactDepth(body, other))
		, shallow_(std::max(deep_ - other.bulge(), 0.))
		, list_(list)
		, facets_(body, other,
			  list.candidates.covered - list.candidates.approached +
				  mostBelowDistance(other),
			  list.candidates)
	{
	}

	/// Where a candidate is to be measured, if anywhere.
	bool findPlace(Node& node, NodeAtPlace<dim>& found)
	{
		found.node = &node;
		found.nearest = {};
		facets_.findNearest(node, found.nearest);
		const ContactCandidates<dim>& candidates = list_.candidates;
		const double gap = leastGap(node, found.nearest);
		++list_.tested;
		// nodes that are no candidates may be nearer than that, and no nearer than this
		node.clearance = std::min(gap + candidates.approached, candidates.covered);
		if (gap >= reach_) {
			if (isOutside(positionOf(node), other_, found.nearest)) return false;
			node.clearance = none;
		}
		return findPlaceThatBears(found);
	}
	/// The contact there; returns whether it is one.
	template <class Measured>
	bool makeContact(const NodeAtPlace<dim>& found, const Measured& measured,
			 Contact<dim>& contact) const
	{
		const Vec<dim>& x = positionOf(*found.node);
		measured.write(contact);
		contact.key = { found.node->side, found.node->node, -1 };
		const bool isBeyond = isBeyondEdge(x, other_, found.place(), edgeWidth, contact);
		if (isBeyond && !NodeFacing<dim>(body_, found.node->node).isAgainst(contact.normal))
			return false;
		if (!isBeyond && isAside(x, other_, found.place(), contact, reach_)) return false;
		if (contact.gap >= (found.faces ? reach_ : -deep_)) return false;
		if (isFarther(contact.gap, found.place()) && isNotInside(x, found)) return false;
		// behind the line of a side that has been bent, and outside all the same
		const bool doubtful = contact.gap < -trustedDepth * other_.pointSpacing;
		return !doubtful || other_.mesh->irregular || other_.encloses(x);
	}
	const Vec<dim>& positionOf(const Node& node) const { return body_.position[node.node]; }
	const ContactOutline<dim>& body() const { return body_; }
	const ContactOutline<dim>& other() const { return other_; }

private:
	/// Only facets count that the node faces. One that is outside must be before them, not
	/// behind the far side of a thin arm.
	bool findPlaceThatBears(NodeAtPlace<dim>& found)
	{
		const Node& node = *found.node;
		const Vec<dim>& x = positionOf(node);
		const bool irregular = other_.mesh->irregular;
		std::optional<bool> enclosed; // once it is asked for
		auto mayBeInside = [&] {
			if (!enclosed) enclosed = !irregular || other_.encloses(x);
			return *enclosed;
		};
		const NodeFacing<dim> facing(body_, node.node);
		auto bears = [&](int f) {
			return facing.isAgainst(other_.normalOfFacet(f)) &&
			       ((irregular && isBefore(x, other_, f)) || mayBeInside());
		};
		found.isNearest = isNear(found.nearest) && bears(found.nearest.facet);
		found.faces = found.isNearest || findBeside(bears, found);
		if (found.faces && !found.isNearest && hasComeInHere(found)) found.isNearest = true;
		if (found.faces) return true;
		// None near: the node lies against no side of the grain, but it may be inside.
		found.isNearest = true;
		return found.nearest.squaredDistance >= shallow_ * shallow_ && mayBeInside();
	}
	/// Whether a node that faces a place farther away has come in at the nearest all the same,
	/// as one of a fold may: it is inside, and the other place round a corner. (In 3D outlines
	/// do not fold.)
	bool hasComeInHere(const NodeAtPlace<dim>& found) const
	{
		return dim == 2 &&
		       std::sqrt(found.beside.squaredDistance) >
			       std::sqrt(found.nearest.squaredDistance) +
				       trustedDepth * other_.pointSpacing &&
		       other_.encloses(positionOf(*found.node));
	}
	/// (In the plane the nearest facet does not tell where the outline has crossed itself in a
	/// fold; but a node on it is in no polygon.)
	bool isNotInside(const Vec<dim>& x, const NodeAtPlace<dim>& found) const
	{
		if (isOutside(x, other_, found.nearest)) return true;
		const double onOutline = edgeWidth * other_.pointSpacing;
		return dim == 2 && found.nearest.squaredDistance > onOutline * onOutline &&
		       !other_.encloses(x);
	}
	/// No deeper than contacts are.
	bool isNear(const PlaceOnOutline<dim>& place) const
	{
		return place.squaredDistance < deep_ * deep_;
	}
	/// The nearest on a facet that bears, if it is near.
	template <class Bears> bool findBeside(Bears&& bears, NodeAtPlace<dim>& found)
	{
		if (!isNear(found.nearest)) return false;
		found.beside = { -1, {}, deep_ * deep_ };
		facets_.findNearestThat(bears, *found.node, found.beside);
		return found.beside.facet >= 0;
	}

	/// Whether a gap is less than the way to its place: a facet that is not the nearest may be
	/// one beside which a node outside lies, behind its plane.
	bool isFarther(double gap, const PlaceOnOutline<dim>& place) const
	{
		const double most = gap + lessThanDistance<dim> * other_.pointSpacing;
		const double distance = std::sqrt(place.squaredDistance);
		return most < distance && most < distance - bulgeOver(other_, place.facet);
	}
	/// What the gap of a node outside is at least, m.
	double leastGap(const typename ContactCandidates<dim>::Node& node,
			const PlaceOnOutline<dim>& nearest) const
	{
		const double distance = std::sqrt(nearest.squaredDistance) -
					lessThanDistance<dim> * other_.pointSpacing;
		if (distance < reach_) return distance - other_.bulge(); // to be measured anyway
		auto bulge = [this](int facet) { return bulgeOver(other_, facet); };
		return distance -
		       facets_.bulgeTowards(node, std::sqrt(nearest.squaredDistance), bulge);
	}

	const ContactOutline<dim>&body_, &other_;
	double reach_, deep_;
	double shallow_; ///< nothing so near is deep, m
	ContactList<dim>& list_;
	CandidateFacets<dim> facets_;
};

/// Asks for what the first candidates will need: they lie in a row, but what each is measured with
/// is read one after the other.
template <int dim>
void fetchCandidates(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		     const ContactCandidates<dim>& candidates)
{
	if (!candidates.nearby) return;
	constexpr std::size_t enough = 32; // of a pair of polygons all; then memory comes in time
	auto fetchOne = [](const auto& objects, std::size_t k) {
		if (k < objects.size()) fetchBytes(&objects[k], &objects[k] + 1);
	};
	for (std::size_t k = 0; k < std::min(candidates.nodes.size(), enough); ++k) {
		const auto& [side, node, facet, clearance] = candidates.nodes[k];
		fetchOne(*candidates.nearby, k);
		fetchOne((side == 0 ? first : second).normal, node);
		fetchOne((side == 0 ? second : first).facetNormal, facet);
	}
}

/// Those candidates that may be within reach.
template <int dim>
void measureCandidates(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
		       double reach, ContactList<dim>& list)
{
	std::array<NodesAtCorners<dim>, 2> sides { { { first, second, reach, list },
						     { second, first, reach, list } } };
	auto take = [&](const NodeAtPlace<dim>& found, const auto& measured) {
		const NodesAtCorners<dim>& side = sides[found.node->side];
		Contact<dim>& contact = list.contacts.emplace_back();
		const bool isContact = side.makeContact(found, measured, contact);
		if (!isContact || !noteAndKeep(contact.gap, side.body(), side.other(), list))
			list.contacts.pop_back();
	};
	Gaps<dim, NodeAtPlace<dim>, decltype(take)> gaps(take);
	forCandidates(reach, list.candidates, [&](auto& node) {
		NodesAtCorners<dim>& side = sides[node.side];
		NodeAtPlace<dim>& found = gaps.next();
		if (side.findPlace(node, found))
			gaps.add(side.positionOf(node), side.other(), found.place());
	});
	gaps.measure();
}

} // namespace

template <int dim>
void findContactsAtCorners(const ContactOutline<dim>& first, const ContactOutline<dim>& second,
			   double reach, ContactList<dim>& list)
{
	fetchCandidates(first, second, list.candidates);
	followBodies(first, second, reach, list.candidates);
	renewCandidates<dim>(first, second, reach, true, 0, list.candidates,
			     [&](const auto& body, const auto& other, int side, double within) {
				     findCandidates<dim>(body, other, side, within, list);
				     if constexpr (dim == 3)
					     if (side == 0)
						     findCandidateEdges(body, other, within,
									list.candidates);
			     });
	if (!list.candidates.nodes.empty()) measureCandidates(first, second, reach, list);
	if constexpr (dim == 3) findCrossingEdges(first, second, reach, list);
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template void findContactsAtCorners<dim>(const ContactOutline<dim>&,                       \
						 const ContactOutline<dim>&, double,               \
						 ContactList<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
