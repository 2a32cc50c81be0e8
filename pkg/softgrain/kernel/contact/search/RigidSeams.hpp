// Where a rigid surface goes on as one beside it: floors of facets and boxes.
#pragma once

#include "contact/ContactOutline.hpp"
#include "contact/RigidSide.hpp"
#include "contact/search/PlaceOnRigid.hpp"
#include "contact/search/RigidTips.hpp"

#include <vector>

namespace softgrain {

/// The surfaces beside a rigid one, of which an edge may be a seam: where a floor goes on, what
/// lies before the edge is nearer to the next side than to the edge, and must not meet it head-on;
/// and what both bear is to count once (doc/decisions/0019-rigid-partners.md). For one search.
template <int dim> class RigidSeams {
public:
	RigidSeams(const ContactOutline<dim>& body, const RigidSide<dim>& rigid);
	/// Whether the place that `x` would touch is none: an edge, or a side of a block so near to
	/// one that `x` may be beneath the next side, at which the surface goes on, or beyond its
	/// end by more than a step that is felt, or by less, far beneath, and covered there.
	bool hides(const Vec<dim>& x, const SurfacePlace<dim>& place);
	/// Whether another surface bears the same place, on the seam of both: one that comes first,
	/// or any if the place lies beside this surface.
	bool isAnothers(const Vec<dim>& x, const SurfacePlace<dim>& place,
			const Facing<dim>& facing);
	/// Of a tip that the outline touches with this normal (unit, outwards): whether another
	/// surface hides or bears it; or whether the sides beside the tip bear the outline, by its
	/// nodes, since it lies along them within `turn`, rad.
	bool hides(const Tip<dim>& tip, const Vec<dim>& normal, double turn);
	/// The same of a place on an edge.
	bool hidesOnEdge(const Vec<dim>& place, const Vec<dim>& normal, double turn);
	/// Steps from surface to surface that are lower are not felt, m.
	double tolerance() const { return distance_; }
	/// Whether a place lies on the surface or on another.
	bool isOnFloor(const Vec<dim>& place);
	/// GoesOn of the other surfaces.
	bool goesOnFrom(const Vec<dim>& edge, const Vec<dim>& way);

private:
	/// Whether a surface goes on from an edge in a direction.
	bool leaves(const RigidSurface<dim>& surface, const Vec<dim>& edge,
		    const Vec<dim>& way) const;
	/// Whether a place lies in another block, or before it by less than a step that is felt.
	bool isInAnotherBlock(const Vec<dim>& place);
	/// Whether another surface goes on before a place on a side of a block, and all about it.
	bool isCovered(const Vec<dim>& before, const SurfacePlace<dim>& place);
	/// The same of a place a little further across each edge, inwards, or outwards where `way`
	/// has the bit of the edge.
	bool isCoveredTowards(const Vec<dim>& before, const SurfacePlace<dim>& place, unsigned way);
	/// What hides a tip and hidesOnEdge have in common: `has` tells whether another surface has
	/// the same tip or edge.
	template <class Has>
	bool hidesEnd(const Vec<dim>& place, const Vec<dim>& normal, double turn, Has&& has);
	/// Whether such an outline lies along a side of a surface that ends at the place, and the
	/// floor goes on there all around: past the end of one nodes hold nothing up.
	bool isBorneBeside(const RigidSurface<dim>& surface, const Vec<dim>& place,
			   const Vec<dim>& normal, double turn);
	/// Whether no surface goes on from an edge of a side in a direction along it: over the same
	/// plane, inclined, or rising.
	bool endsTowards(const Vec<dim>& edge, const Vec<dim>& way, const Vec<dim>& normal);
	/// Whether a side of its own, or another surface, is nearer than an edge to what lies
	/// before it. In space the direction there may lean along the edge.
	bool goesOnBefore(const Vec<dim>& before);
	/// Whether another surface lies beneath the same place of the outline, and keeps it.
	bool bearsToo(const RigidSurface<dim>& surface, const Vec<dim>& x,
		      const SurfacePlace<dim>& place, const Facing<dim>& facing);
	/// Whether another surface is nearer to a place than this one.
	bool isNearer(const RigidSurface<dim>& surface, const Vec<dim>& place) const;
	/// Whether this surface is nearer to what lies before another one.
	bool isNearerBefore(const RigidSurface<dim>& surface, const Vec<dim>& before) const;
	bool hasTip(const RigidSurface<dim>& surface, const Vec<dim>& place) const;
	bool hasEdge(const RigidSurface<dim>& surface, const Vec<dim>& place) const;
	Vec<dim> before(const Vec<dim>& x, const SurfacePlace<dim>& place) const
	{
		return x + (distance_ - place.gap) * place.normal;
	}
	template <class Is> bool anyOther(Is&& is);

	const RigidSide<dim>& rigid_;
	double spacing_;          ///< dr of the grain, m
	double distance_, depth_; ///< m
	double alike_;            ///< between places that are one, m
	std::vector<SurfaceBeside<dim>> others_;
	bool hasAsked_ = false; ///< for them (of an optional GCC warns wrongly)
};

} // namespace softgrain
