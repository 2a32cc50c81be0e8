// What contact sees of a grain where it is: its outline, as contact nodes and facets. Nothing of
// the background grid; what sweeps need besides is in ContactBody.hpp.
#pragma once

#include "Vectors.hpp"
#include "contact/CommonGrid.hpp"
#include "reference/Outline.hpp"

#include <vector>

namespace softgrain {

template <int dim> struct ContactOutline {
	const OutlineMesh<dim>* mesh =
		nullptr;         ///< facets; without any the contact nodes are disks (spheres)
	double nodeRadius = 0;   ///< of the disk about a contact node, m; 0 on a surface
	double pointSpacing = 0; ///< dr, m: the measure of overlaps
	double inradius = 0;     ///< of the largest ball in the undeformed grain, m

	std::vector<Vec<dim>> position; ///< xs at t_n, m
	std::vector<Vec<dim>>
		normal; ///< outward unit normals at the contact nodes; empty without facets
	std::vector<Vec<dim>> facetNormal; ///< the same of the facets, where nodes are sharp
	Box<dim> box;                      ///< of the positions, node radii included
	double longestEdge = 0;            ///< of a facet, m
	/// 2D: the outline turns inwards so sharply somewhere that to a node close by two places on
	/// it may be nearest, each of those around.
	bool folded = false;
	/// 2D: at some node that is not sharp it turns by so much that its normal there says little
	/// of either side.
	bool bent = false;
	double circumradius = 0;     ///< of the positions about the centre of the box, m
	VectorRange<dim> velocities; ///< of the nodes, m/s
	/// Way of the nodes together since the start, m, and the most that one may have come
	/// besides.
	Vec<dim> carried = Vec<dim>::Zero();
	double travelled = 0;

	/// Contact on background nodes: step of the common grid, m (0: another geometry), and what
	/// the body gives to its nodes. These are the contact nodes then: what is solved
	/// (ContactBody) is theirs, while position, normal and mesh remain those of the outline.
	double gridSpacing = 0;
	std::vector<GridNode<dim>> gridNode;

	int nodes() const { return static_cast<int>(position.size()); }
	/// Of the outline (without facets: of the disks).
	bool hasFacets() const { return !mesh->facet.empty(); }
	bool isOnGrid() const { return gridSpacing > 0; }
	bool isSurface() const { return hasFacets() && !isOnGrid(); }
	const Vec<dim>& contactPoint(int node) const
	{
		return isOnGrid() ? gridNode[node].centre : position[node];
	}
	/// Where it touches what lies across this gap along this normal (unit, towards the node):
	/// of a disk about the node half-way to that.
	Vec<dim> touchedPoint(int node, const Vec<dim>& normal, double gap) const
	{
		if (nodeRadius == 0) return contactPoint(node);
		const double radius =
			isOnGrid() ? 0.5 * gridContactDistance * gridSpacing : nodeRadius;
		return contactPoint(node) - (radius + 0.5 * gap) * normal;
	}
	bool isSharp(int node) const { return mesh->isSharp(node); }
	/// Whether it is `bent` at this node.
	bool isBent(int node) const;

	/// Nodes in a region, in their order.
	std::vector<int> nodesIn(const Box<dim>& region) const;
	/// Outward normal of a facet; its length is the area (2D: length) of the facet.
	Vec<dim> areaOfFacet(int facet) const;
	/// The same, of unit length.
	Vec<dim> normalOfFacet(int facet) const
	{
		return facetNormal.empty() ? Vec<dim>(areaOfFacet(facet).normalized())
					   : facetNormal[facet];
	}
	/// Outward unit normal at a node of a facet: that of the smooth outline, at a sharp node
	/// that of the facet itself.
	Vec<dim> normalAt(int facet, int node) const
	{
		return isSharp(node) ? normalOfFacet(facet) : normal[node];
	}
	/// Whether a place is inside the polygon (3D: polyhedron) of the nodes; without facets
	/// never.
	bool encloses(const Vec<dim>& x) const;
	/// Whether the straight way there from a node is inside of it as well.
	bool encloses(int fromNode, const Vec<dim>& x) const;
	/// Of the largest ball that the grain may hold as it is now, m.
	double innerRadius() const
	{
		return std::min(inradius, 0.5 * (box.high - box.low).minCoeff());
	}
	/// The outline bulges out of its facets by less, m: up to a quarter of the longest edge
	/// (3D: 0.29 of it).
	double bulge() const { return 0.3 * longestEdge; }
	/// Of a ball about the centre of the box that holds the outline, m.
	double outerRadius() const { return circumradius + nodeRadius + bulge(); }
	/// Whether a ball (or a grain that may hold one) lies inside this grain, or about the same
	/// centre, so that no node is near an outline. For grains whose box has its centre inside
	/// them.
	bool holds(const Vec<dim>& centre, double radius) const;
	/// Outward area vectors of the nodes: of the adjacent facets, an equal share each,
	/// m^(dim-1).
	std::vector<Vec<dim>> nodeAreas() const;
	Vec<dim> nodeArea(int node) const; ///< of one of them

	/// Renews normals and box after `position` was set.
	void updateGeometry();
	/// Makes this a displaced copy.
	void becomeImage(const ContactOutline& of, const Vec<dim>& shift);
};

/// How an outline faces at one of its nodes, to be asked for many directions: cosines of the angle
/// by which it faces against a direction (unit), 1 where it faces it head-on, below 0 where it
/// turns away.
template <int dim> class NodeFacing {
public:
	NodeFacing(const ContactOutline<dim>& body, int node)
		: body_(body)
		, normal_(body.normal[node])
		, isSharp_(body.isSharp(node))
	{
		if (isSharp_ || body.isBent(node)) sides_ = &body.mesh->facetsAbout[node];
	}
	/// By its normal, at a corner by the side that faces it most. In the plane 1/2 at least
	/// between the sides: those of a needle face nothing that is before its tip.
	double operator()(const Vec<dim>& direction) const
	{
		return sides_ ? ofCorner(direction) : -normal_.dot(direction);
	}
	/// The same, but where the outline is bent by the side that faces it most, too.
	double ofSides(const Vec<dim>& direction) const
	{
		return sides_ ? mostOfSides(direction) : -normal_.dot(direction);
	}
	/// Whether one of its sides does, within 84 degrees.
	bool isAgainst(const Vec<dim>& direction) const
	{
		constexpr double leastCosine = 0.1;
		return ofSides(direction) > leastCosine;
	}

private:
	double ofCorner(const Vec<dim>& direction) const;
	double mostOfSides(const Vec<dim>& direction) const;
	bool isBetweenSides(const Vec<dim>& direction) const;

	const ContactOutline<dim>& body_;
	const Vec<dim>& normal_;
	bool isSharp_;
	const std::vector<int>* sides_ = nullptr; ///< facets that meet at a corner or a bend
};

/// How deep a node may lie in the other grain and still be a contact, m: from deeper it would be
/// pushed to whichever side is nearest.
template <int dim> double contactDepth(const ContactOutline<dim>& a, const ContactOutline<dim>& b)
{
	constexpr double deepestContact = 1.5; // in dr
	return deepestContact * std::max(a.pointSpacing, b.pointSpacing);
}

/// Mean dr of two grains, m.
template <int dim> double meanSpacing(const ContactOutline<dim>& a, const ContactOutline<dim>& b)
{
	return 0.5 * (a.pointSpacing + b.pointSpacing);
}

} // namespace softgrain
