// The true boundary of a grain in its reference configuration, at unit size.
#pragma once

#include "Vector.hpp"
#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace softgrain {

/// Most nodes that a place on an outline leans on.
template <int dim> constexpr int mostPartners = dim == 2 ? 4 : 3;

/// In 3D, where two sides of an outline meet at an angle: an edge of two facets.
struct SharpEdge {
	int from, to;                       ///< vertices
	std::array<int, 2> facet;           ///< those that it belongs to
	std::array<int, 2> opposite;        ///< their third vertices
	std::array<int, 2> next { -1, -1 }; ///< the piece that goes on from either end, if any
};

/// Closed piecewise linear outline: segments in 2D, triangles in 3D, oriented so that the
/// right-hand (2D: right of the direction of travel, counter-clockwise) normal points outwards.
template <int dim> struct OutlineMesh {
	std::vector<Vec<dim>> vertex;            ///< on the true boundary
	std::vector<std::array<int, dim>> facet; ///< vertex indices; in 2D in order around it
	/// By vertex, whether the outline has no single normal there; empty where it has one
	/// everywhere. About any other vertex the facets approximate one smooth surface.
	std::vector<char> sharp;
	std::vector<std::vector<int>> facetsAbout; ///< those that meet at a vertex, in order
	std::vector<SharpEdge> sharpEdge;
	/// The centre of its box may lie outside, and far pieces of it may be equally near to a
	/// place: searches take no short cuts.
	bool irregular = false;
	/// In 2D: so long that it may be bent until it meets itself, or any polygon.
	bool mayMeetItself = false;

	bool hasCorners() const { return !sharp.empty(); }
	bool isSharp(int v) const { return hasCorners() && sharp[v]; }
	/// The vertices that carry the outline over a facet: in 2D its ends between their
	/// neighbours (contact/search/OutlineCurve.hpp), in 3D its corners.
	std::array<int, mostPartners<dim>> carriers(int f) const
	{
		if constexpr (dim == 2) {
			const int last = static_cast<int>(facet.size()) - 1;
			return { facet[f > 0 ? f - 1 : last][0], facet[f][0], facet[f][1],
				 facet[f < last ? f + 1 : 0][1] };
		} else
			return facet[f];
	}
};

/// OutlineMesh::facetsAbout of the facets that there are.
template <int dim> void findFacetsAbout(OutlineMesh<dim>& mesh)
{
	mesh.facetsAbout.assign(mesh.vertex.size(), {});
	for (int f = 0; f < static_cast<int>(mesh.facet.size()); ++f)
		for (int node : mesh.facet[f])
			mesh.facetsAbout[node].push_back(f);
}

/// Joins the vertices of a 2D outline by facets in their order; sharp where two sides meet.
void closeOutline(OutlineMesh<2>& mesh, const std::vector<int>& corners);

/// Area (2D) or volume (3D) of a piece of a grain, and its first moment.
template <int dim> struct Moments {
	double volume = 0;
	Vec<dim> first = Vec<dim>::Zero();
};

/// What quadrature and contact nodes need to know of a boundary. Lengths are in radii of the grain.
template <int dim> class Outline {
public:
	virtual ~Outline() = default;

	/// Distance to the boundary, negative inside.
	virtual double signedDistance(const Vec<dim>& X) const = 0;

	/// Area (2D) or volume (3D).
	virtual double volume() const = 0;

	/// Half sides of the box about it; its centre is the origin.
	virtual Vec<dim> halfSides() const = 0;

	/// Radius of the largest ball inside.
	virtual double inradius() const = 0;

	/// Sides of the cells of the lattice of material points: near `spacing`, and such that the
	/// lattice ends on the boundary where that is straight along the axes.
	virtual Vec<dim> cellSides(double spacing) const = 0;

	/// Steps of the background grid, `ratio` sides of cells `spacing` wide or more, and such
	/// that boundaries straight along the axes lie on its nodes: of a row of nodes that reaches
	/// less far into the grain the material points see too little, and contacts sink in.
	virtual Vec<dim> gridSteps(double spacing, double ratio) const
	{
		return Vec<dim>::Constant(ratio * spacing);
	}

	/// Exactly what lies inside of a cell, where there is a closed form; else cells are
	/// divided.
	virtual std::optional<Moments<dim>> cut(const Vec<dim>& centre,
						const Vec<dim>& sides) const = 0;

	/// Vertices on the boundary about `spacing` apart.
	virtual OutlineMesh<dim> mesh(double spacing) const = 0;
};

/// Disk (dim = 2) or ball (dim = 3) of radius 1 about the origin.
template <int dim> class UnitBall : public Outline<dim> {
public:
	double signedDistance(const Vec<dim>& X) const override { return X.norm() - 1; }
	double volume() const override;
	Vec<dim> halfSides() const override { return Vec<dim>::Ones(); }
	double inradius() const override { return 1; }
	Vec<dim> cellSides(double spacing) const override { return Vec<dim>::Constant(spacing); }
	std::optional<Moments<dim>> cut(const Vec<dim>&, const Vec<dim>&) const override
	{
		return std::nullopt;
	}

	/// At least 11 vertices on a disk, equally spaced, their number without a divisor 2 or 3;
	/// on a ball a subdivided icosahedron whose mean edge is nearest to `spacing`, of at least
	/// 162 vertices.
	OutlineMesh<dim> mesh(double spacing) const override;
};

/// Rectangle (dim = 2) or cuboid (dim = 3) about the origin, its sides along the axes.
template <int dim> class Block : public Outline<dim> {
public:
	explicit Block(const Vec<dim>& halfSides)
		: half_(halfSides)
	{
	}
	double signedDistance(const Vec<dim>& X) const override;
	double volume() const override { return (2 * half_).prod(); }
	Vec<dim> halfSides() const override { return half_; }
	double inradius() const override { return half_.minCoeff(); }
	Vec<dim> cellSides(double spacing) const override;
	Vec<dim> gridSteps(double spacing, double ratio) const override;
	std::optional<Moments<dim>> cut(const Vec<dim>& centre,
					const Vec<dim>& sides) const override;

	/// Vertices in the corners and, equally spaced, on the sides, each of which has at least
	/// two edges; in 2D counter-clockwise from the lower left corner. Corners (3D: edges) are
	/// sharp.
	OutlineMesh<dim> mesh(double spacing) const override;

private:
	Vec<dim> half_;
};

/// Closed polyline in the plane, counter-clockwise, without crossings, in radii of the grain. At a
/// corner the outline has a kink; through the other vertices it runs smoothly.
struct Ring {
	std::vector<Vec<2>> vertex;
	std::vector<int> corner; ///< indices of vertices, ascending

	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate() const;
	bool operator<(const Ring& o) const;
	double area() const;
	Vec<2> centroid() const;
};

/// Kinds of outlines a grain may have.
enum class Form {
	ball,      ///< disk in 2D
	block,     ///< rectangle in 2D
	superdisk, ///< |x/a|^n + |y/b|^n = 1, in 2D
	polygon    ///< a ring, in 2D
};

/// Outline of a grain over its radius.
struct GrainForm {
	Form form = Form::ball;
	/// Half sides of a block, half axes of a superdisk over the radius of the grain, which is
	/// the shortest of them.
	std::array<double, 3> aspect { 1, 1, 1 };
	double exponent = 2; ///< n of a superdisk, in [1.25, 20]
	/// Outline of a polygon about its centroid; the largest circle inside has radius 1.
	std::shared_ptr<const Ring> ring;

	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate() const;
	bool operator<(const GrainForm& o) const;
};

template <int dim> std::unique_ptr<const Outline<dim>> makeOutline(const GrainForm& form);

} // namespace softgrain
