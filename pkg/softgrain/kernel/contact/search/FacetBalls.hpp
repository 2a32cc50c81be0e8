// Some facets of an outline, each in a ball, with balls about groups of them: which is the nearest
// to a place is found without a look at most of them.
#pragma once

#include "contact/ContactOutline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace softgrain {

/// Groups are of facets that follow one another, then of groups, until few are left: facets that
/// are numbered side by side lie side by side, but for few.
template <int dim> class FacetBalls {
public:
	FacetBalls() = default;
	FacetBalls(const ContactOutline<dim>& body, std::vector<int> facets);

	bool empty() const { return facet_.empty(); }
	const std::vector<int>& facets() const { return facet_; } ///< in their order
	/// Leaves out those that are farther from a place than `distance`.
	void leaveOutFarFrom(const Vec<dim>& place, double distance);
	/// Calls `use(facet)` for those that may be within `distance` of `x`, in their order; `use`
	/// may shorten it.
	template <class Use>
	void forNear(const Vec<dim>& x, const double& distance, Use&& use) const
	{
		if (empty()) return;
		const int top = static_cast<int>(level_.size()) - 1;
		visit(top, 0, static_cast<int>(level_[top].size()), x, distance, use);
	}

private:
	struct Ball {
		Vec<dim> centre;
		double radius;

		bool isWithin(double distance, const Vec<dim>& x) const
		{
			const double farthest = distance + radius;
			return !((x - centre).squaredNorm() > farthest * farthest);
		}
	};
	using Level = std::vector<Ball>;
	/// Balls in a group, and without one: about squares and hexagons of usual zeta there are
	/// fewer facets, and groups would save nothing.
	static constexpr int group = 8, fewEnough = 32;

	static Ball ballAbout(const ContactOutline<dim>& body, int facet);
	static Ball ballAbout(const Ball* first, const Ball* end);
	void makeGroups();
	/// The balls of a level from one to another.
	template <class Use>
	void visit(int level, int begin, int end, const Vec<dim>& x, const double& distance,
		   Use& use) const
	{
		const Level& balls = level_[level];
		for (int k = begin; k < end; ++k) {
			if (!balls[k].isWithin(distance, x)) continue;
			if (level == 0) {
				use(facet_[k]);
				continue;
			}
			const int below = static_cast<int>(level_[level - 1].size());
			visit(level - 1, group * k, std::min(group * (k + 1), below), x, distance,
			      use);
		}
	}

	std::vector<int> facet_;
	std::vector<Level> level_; ///< of the facets, of groups of them, of groups of these ...
};

template <int dim>
FacetBalls<dim>::FacetBalls(const ContactOutline<dim>& body, std::vector<int> facets)
	: facet_(std::move(facets))
{
	if (empty()) return;
	level_.resize(1);
	level_[0].reserve(facet_.size());
	for (int f : facet_)
		level_[0].push_back(ballAbout(body, f));
	makeGroups();
}

template <int dim> void FacetBalls<dim>::leaveOutFarFrom(const Vec<dim>& place, double distance)
{
	if (empty()) return;
	level_.resize(1);
	std::size_t kept = 0;
	for (std::size_t k = 0; k < facet_.size(); ++k) {
		if (!level_[0][k].isWithin(distance, place)) continue;
		facet_[kept] = facet_[k];
		level_[0][kept++] = level_[0][k];
	}
	facet_.resize(kept);
	level_[0].resize(kept);
	makeGroups();
}

template <int dim> void FacetBalls<dim>::makeGroups()
{
	while (level_.back().size() > fewEnough) {
		const Level& last = level_.back();
		Level groups;
		for (std::size_t k = 0; k < last.size(); k += group)
			groups.push_back(
				ballAbout(&last[k], &last[0] + std::min(k + group, last.size())));
		level_.push_back(std::move(groups));
	}
}

template <int dim>
auto FacetBalls<dim>::ballAbout(const ContactOutline<dim>& body, int facet) -> Ball
{
	const auto& vertex = body.mesh->facet[facet];
	Ball ball { Vec<dim>::Zero(), 0 };
	for (int i : vertex)
		ball.centre += body.position[i] / dim;
	double squared = 0;
	for (int i : vertex)
		squared = std::max(squared, (body.position[i] - ball.centre).squaredNorm());
	ball.radius = std::sqrt(squared);
	return ball;
}

/// (Wider by some rounding: of places as near as each other none may be missed.)
template <int dim> auto FacetBalls<dim>::ballAbout(const Ball* first, const Ball* end) -> Ball
{
	constexpr double rounding = 1 + 1e-12;
	Ball about { Vec<dim>::Zero(), 0 };
	for (const Ball* ball = first; ball != end; ++ball)
		about.centre += ball->centre / static_cast<double>(end - first);
	for (const Ball* ball = first; ball != end; ++ball)
		about.radius =
			std::max(about.radius, (ball->centre - about.centre).norm() + ball->radius);
	about.radius *= rounding;
	return about;
}

} // namespace softgrain
