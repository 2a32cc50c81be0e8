// Everything about a grain that never changes, computed once and shared by all congruent grains.
#pragma once

#include "Vector.hpp"
#include "reference/Hourglass.hpp"
#include "reference/NodeMass.hpp"
#include "reference/NodeRows.hpp"
#include "reference/Outline.hpp"
#include "reference/PointLines.hpp"
#include "reference/PressureSpace.hpp"
#include "reference/Quadrature.hpp"
#include "reference/ShapeFunction.hpp"
#include "reference/SparseRows.hpp"
#include "reference/SurfaceMobility.hpp"

#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace softgrain {

/// What a grain shows to others (method: section 3).
enum class ContactGeometry {
	surface, ///< nodes on the true outline against the other grain's outline
	points,  ///< every boundary material point is a disk (sphere) of diameter dr (the paper)
	nodes ///< nodes of a grid in space that get mass from two bodies (contact/CommonGrid.hpp)
};

/// What the displacements of a grain are made of.
enum class Basis {
	splines,  ///< B-splines on a grid that knows nothing of the outline (TLMPM)
	triangles ///< linear triangles up to the outline (finite elements): 2D disks, to compare
};

/// How the volumetric part of the law sees ln J.
enum class VolumetricStrain {
	pointwise, ///< at every material point
	projected  ///< on a coarser space of pressures: for nearly incompressible grains
};

/// How a grain is discretised. Grains with equal recipes are congruent and share one template.
struct TemplateRecipe {
	double zeta = 0.11; ///< 2 dr / D, dimensionless, in [0.001, 0.5]
	int order = 3;      ///< of the B-splines: 1, 2 or 3
	/// h / dr, in [1.25, 4]. At 1 cubic splines have zero-energy modes; why 1.25:
	/// doc/decisions/0008-node-spacing.md.
	double nodeSpacing = 1.25;
	double surfaceSpacing = 1; ///< distance of surface nodes over dr, in [0.5, 4]
	QuadratureRule quadrature = QuadratureRule::cutCell;
	ContactGeometry contact = ContactGeometry::surface;
	GrainForm form;
	VolumetricStrain volumetric = VolumetricStrain::pointwise;
	/// Triangles have sides of about dr and a point each; `order`, `nodeSpacing`, `quadrature`
	/// and `lumping` say nothing of them.
	Basis basis = Basis::splines;
	Lumping lumping = Lumping::balanced;

	/// Distance of surface nodes, in radii. In coarse grains (h = nodeSpacing zeta above
	/// nodeSpacing - 1) they are denser than surfaceSpacing says: of the rows of background
	/// nodes about an outline of radius 1 the outer ones are 1 + h times as long, and what
	/// moves between contact nodes lets them sink in.
	double contactSpacing() const;
	/// Throws std::invalid_argument naming the parameter, its value and the admissible range.
	void validate() const;
	bool operator<(const TemplateRecipe& o) const
	{
		return std::tie(zeta, order, nodeSpacing, surfaceSpacing, quadrature, contact, form,
				volumetric, basis, lumping) <
		       std::tie(o.zeta, o.order, o.nodeSpacing, o.surfaceSpacing, o.quadrature,
				o.contact, o.form, o.volumetric, o.basis, o.lumping);
	}
};

/// A grain of radius 1 and density 1 with its background grid laid on the centre. A grain of
/// radius R and density rho has nodes at R XI, G/R, R^dim Vp, rho R^dim mI and W/(rho R^dim).
template <int dim> struct GrainTemplate {
	TemplateRecipe recipe;
	double volume = 0;   ///< of the undeformed grain, in radii^dim
	double inradius = 0; ///< of the largest ball inside, in radii

	Vec<dim> gridSteps =
		Vec<dim>::Zero();           ///< h of the background grid, in radii; if there is one
	std::vector<Vec<dim>> nodePosition; ///< XI, in radii
	std::vector<double> nodeMass;       ///< lumped; their sum is the volume
	std::vector<double> inverseNodeMass; ///< 1/mI

	std::vector<Vec<dim>> pointPosition;        ///< Xp, in radii
	std::vector<double> pointVolume;            ///< Vp0, in radii^dim
	SparseRows<ShapeFunction<dim>> pointShapes; ///< row p: nodes I with N_I(Xp), G_I(Xp)
	PointLines<dim> pointLines;                 ///< the same for the bulk pass
	std::vector<HourglassStencil> hourglass;    ///< in the box of pointLines

	PressureSpace pressureSpace; ///< of the volumetric strain; empty where it is pointwise

	OutlineMesh<dim> contactMesh; ///< contact nodes; without facets for ContactGeometry::points
	double contactRadius =
		0; ///< of the disk about a contact node, in radii; 0 on a surface;
		   ///< ContactGeometry::nodes: what a contact may lie off the outline
	SparseRows<double> contactShapes; ///< row s: nodes I with N_I(Xs)
	NodeRows<dim> contactValues;      ///< the same for fields: N_I(Xs)
	NodeRows<dim> contactKicks;       ///< for impulses on contact nodes: N_I(Xs)/mI
	SparseRows<double> delassus;      ///< W_ss' = sum_I N_I(Xs) N_I(Xs') / mI, a banded table
	SurfaceMobility<dim> surfaceMobility; ///< W for the sweeps; only where there are facets
	SparseRows<double> overlap;           ///< as W, without the masses

	/// What grain/CriticalTimeStep.hpp has found so far, by condition and Poisson's ratio: a
	/// new assembly of the same grains need not find it again. For one thread at a time.
	mutable std::map<std::pair<int, double>, double> highestFrequency;

	int nodes() const { return static_cast<int>(nodePosition.size()); }
	int points() const { return static_cast<int>(pointPosition.size()); }
	int contactNodes() const { return static_cast<int>(contactMesh.vertex.size()); }
	double pointSpacing() const { return recipe.zeta; } ///< dr, in radii
};

/// W_ss' = sum_I N_I(Xs) N_I(Xs') / mI from the rows of N.
SparseRows<double> delassusTable(const SparseRows<double>& shapes,
				 const std::vector<double>& nodeMass);

/// N_I(Xs)/mI from the rows of N.
template <int dim>
NodeRows<dim> kickRows(SparseRows<double> shapes, const std::vector<double>& inverseNodeMass);

/// Validates the recipe and builds the template.
template <int dim>
std::shared_ptr<const GrainTemplate<dim>> makeGrainTemplate(const TemplateRecipe& recipe);

} // namespace softgrain
