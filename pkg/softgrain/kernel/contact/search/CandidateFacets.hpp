// The facets that candidates may lie against: the nearest to each is found among those noted with
// it, and a look at all nearby is the exception.
#pragma once

#include "contact/search/Candidates.hpp"
#include "contact/search/PlaceOnOutline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace softgrain {

/// Of the candidates of one body at the outline of the other, in one step.
template <int dim> class CandidateFacets {
public:
	using Node = typename ContactCandidates<dim>::Node;

	/// `within`: facets that are farther now than this do not matter until candidates are
	/// renewed, m.
	CandidateFacets(const ContactOutline<dim>& body, const ContactOutline<dim>& other,
			double within, ContactCandidates<dim>& candidates)
		: body_(body)
		, other_(other)
		, within_(within)
		, candidates_(candidates)
	{
		if (!candidates.nearby) candidates.nearby.emplace();
		candidates.nearby->resize(candidates.nodes.size());
	}
	/// Finds the nearest place to a candidate; `best` is none yet.
	void findNearest(const Node& node, PlaceOnOutline<dim>& best)
	{
		if (findNoted(node, anyFacet, best)) return;
		note(node);
		if (findNoted(node, anyFacet, best)) return;
		// deep inside, where none may be near
		const Vec<dim>& x = positionOf(node);
		best = nearestPlace(x, other_, all(), anyFacet,
				    placeOnFacet(x, other_, node.facet));
	}
	/// The same on those of the facets that `admissible` lets pass; `best` stays where none
	/// comes before it.
	template <class Admissible>
	void findNearestThat(Admissible&& admissible, const Node& node, PlaceOnOutline<dim>& best)
	{
		if (findNoted(node, admissible, best)) return;
		best = nearestPlace(positionOf(node), other_, all(), admissible, best);
	}
	/// By how much, at most, the outline bulges out of its facets towards a candidate, less
	/// by what they are farther from it than the nearest, m.
	template <class BulgeOver>
	double bulgeTowards(const Node& node, double nearest, BulgeOver&& bulgeOver) const
	{
		const Noted& noted = notedWith(node);
		const double way = waySince(noted);
		double most = nearest + other_.bulge() - (noted.facets.distanceOfOthers() - way);
		for (int k = 0; k < noted.facets.count(); ++k) {
			const double farther =
				std::max(noted.facets.distance(k) - way - nearest, 0.);
			most = std::max(most, bulgeOver(noted.facets.facet(k)) - farther);
		}
		return most;
	}

private:
	/// Facets that are farther than the nearest by more than this, in dr, are not noted: many
	/// to look for, and seldom to come (doc/decisions/0028-search.md).
	static constexpr double notedBeyond = 0.6;

	using Noted = typename ContactCandidates<dim>::Nearby;

	const Vec<dim>& positionOf(const Node& node) const { return body_.position[node.node]; }
	Noted& notedWith(const Node& node) const
	{
		return (*candidates_.nearby)[&node - candidates_.nodes.data()];
	}
	/// How far a candidate and places on the other outline may have come towards each other, m.
	double waySince(const Noted& noted) const
	{
		return (candidates_.apart - noted.apart).norm() + candidates_.travelled -
		       noted.travelled;
	}
	/// Takes what is noted and comes before `best`; whether nothing else does.
	template <class Admissible>
	bool findNoted(const Node& node, Admissible&& admissible, PlaceOnOutline<dim>& best) const
	{
		const Noted& noted = notedWith(node);
		const double way = waySince(noted);
		const Vec<dim>& x = positionOf(node);
		auto isFarther = [&](double distance) {
			const double least = distance - way;
			return least > 0 && least * least > best.squaredDistance;
		};
		for (int k = 0; k < noted.facets.count(); ++k) {
			if (isFarther(noted.facets.distance(k))) return true;
			const int facet = noted.facets.facet(k);
			if (!admissible(facet)) continue;
			const PlaceOnOutline<dim> place = placeOnFacet(x, other_, facet);
			if (comesBefore(place, best)) best = place;
		}
		return isFarther(noted.facets.distanceOfOthers());
	}
	void note(const Node& node)
	{
		Noted& noted = notedWith(node);
		const Vec<dim>& x = positionOf(node);
		noted.apart = candidates_.apart;
		noted.travelled = candidates_.travelled;
		const double known = std::sqrt(placeOnFacet(x, other_, node.facet).squaredDistance);
		noted.facets.clear(std::min(complete(), known + notedBeyond * other_.pointSpacing));
		double within = noted.facets.distanceOfOthers();
		all().forNear(x, within, [&](int facet) {
			noted.facets.note(
				facet, std::sqrt(placeOnFacet(x, other_, facet).squaredDistance));
			within = noted.facets.distanceOfOthers();
		});
	}
	/// All facets that are as near as this to any node of the body are in `all`, m.
	double complete() const { return marginOf(body_, other_, within_); }
	const FacetBalls<dim>& all()
	{
		if (!all_) all_ = facetsNear(body_, other_, within_);
		return *all_;
	}

	const ContactOutline<dim>&body_, &other_;
	double within_;
	ContactCandidates<dim>& candidates_;
	std::optional<FacetBalls<dim>> all_;
};

} // namespace softgrain
