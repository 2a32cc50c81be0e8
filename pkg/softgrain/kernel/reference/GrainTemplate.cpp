#include "reference/GrainTemplate.hpp"
#include "Require.hpp"
#include "reference/BSpline.hpp"
#include "reference/BackgroundGrid.hpp"
#include "reference/TriangleMesh.hpp"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>

namespace softgrain {

namespace {

/// (A bar folded in the middle has arms twice as long as it is wide, and a bend. Crushed blocks
/// cross themselves at corners, too, which is no reason to stop.)
bool mayMeetItself(const GrainForm& form)
{
	constexpr double slender = 5;
	return form.form == Form::polygon || std::max(form.aspect[0], form.aspect[1]) > slender;
}

template <int dim> void layContactNodes(const Outline<dim>& outline, GrainTemplate<dim>& grain)
{
	const double dr = grain.recipe.zeta;
	if (grain.recipe.contact != ContactGeometry::points) {
		grain.contactMesh = outline.mesh(grain.recipe.contactSpacing());
		grain.contactMesh.mayMeetItself = mayMeetItself(grain.recipe.form);
		findFacetsAbout(grain.contactMesh);
		if (grain.recipe.contact == ContactGeometry::nodes)
			grain.contactRadius = grain.recipe.nodeSpacing * dr;
		return;
	}
	grain.contactRadius = 0.5 * dr;
	grain.contactMesh.irregular = grain.recipe.form.form == Form::polygon;
	grain.contactMesh.vertex = boundaryPoints<dim>(grain.recipe.quadrature, dr, outline);
}

} // namespace

SparseRows<double> delassusTable(const SparseRows<double>& shapes,
				 const std::vector<double>& nodeMass)
{
	std::vector<std::vector<std::pair<int, double>>> seenBy(
		nodeMass.size()); // node I: (s, N_I(Xs))
	for (int s = 0; s < shapes.rows(); ++s)
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			seenBy[shapes.column[k]].emplace_back(s, shapes.value[k]);

	SparseRows<double> table;
	std::vector<double> row(shapes.rows(), 0.);
	std::vector<char> isMet(shapes.rows(), 0);
	std::vector<int> met;
	for (int s = 0; s < shapes.rows(); ++s) {
		met.clear();
		for (int k = shapes.begin(s); k < shapes.end(s); ++k) {
			const int node = shapes.column[k];
			for (const auto& [other, N] : seenBy[node]) {
				if (!isMet[other]) met.push_back(other);
				isMet[other] = 1;
				row[other] += shapes.value[k] * N / nodeMass[node];
			}
		}
		std::sort(met.begin(), met.end());
		for (int other : met) {
			table.append(other, row[other]);
			row[other] = 0;
			isMet[other] = 0;
		}
		table.closeRow();
	}
	return table;
}

template <int dim>
NodeRows<dim> kickRows(SparseRows<double> shapes, const std::vector<double>& inverseNodeMass)
{
	for (std::size_t k = 0; k < shapes.value.size(); ++k)
		shapes.value[k] *= inverseNodeMass[shapes.column[k]];
	return NodeRows<dim>(shapes, static_cast<int>(inverseNodeMass.size()));
}

double TemplateRecipe::contactSpacing() const
{
	if (basis == Basis::triangles) return surfaceSpacing * zeta;
	const double h = nodeSpacing * zeta;
	return surfaceSpacing * zeta * std::min(1., nodeSpacing / (1 + h));
}

void TemplateRecipe::validate() const
{
	require(zeta >= 1e-3 && zeta <= 0.5, "zeta", zeta, "[0.001, 0.5]");
	require(order >= minSplineOrder && order <= maxSplineOrder, "order", order, "1, 2, 3");
	require(nodeSpacing >= 1.25 && nodeSpacing <= 4, "nodeSpacing", nodeSpacing, "[1.25, 4]");
	require(surfaceSpacing >= 0.5 && surfaceSpacing <= 4, "surfaceSpacing", surfaceSpacing,
		"[0.5, 4]");
	form.validate();
	if (form.form == Form::polygon && quadrature == QuadratureRule::lattice)
		throw std::invalid_argument(
			"quadrature = 'lattice' is not for polygons, whose uniform points have "
			"another centre of mass than the outline; admissible: 'cutCell'");
	if (basis == Basis::triangles &&
	    (form.form != Form::ball || contact != ContactGeometry::surface))
		throw std::invalid_argument("basis = 'triangles' is for form = 'ball' and contact "
					    "= 'surface' only");
}

namespace {

/// More points a grain do not fit into the memory of usual machines.
void requireFewPoints(double points, double zeta)
{
	constexpr double mostPoints = 2e7; // some 2 kB each with cubic splines in 3D: 40 GB
	require(points <= mostPoints, "zeta", zeta,
		"what gives the grain at most 2e7 material points (it would have " +
			std::to_string(std::lround(points)) + ")");
}

/// Uniform points leave out cells at the rim, and nodes there that no point feels could move
/// without strain. (Held are those of second and third order in 3D and with projected volumes.)
template <int dim>
void requirePointsForNodes(const TemplateRecipe& recipe, std::size_t points, std::size_t nodes)
{
	const bool isProjected = recipe.volumetric == VolumetricStrain::projected;
	const bool areHeld = recipe.order > 1 && hourglassStiffness<dim>(isProjected) > 0;
	if (recipe.quadrature == QuadratureRule::cutCell || areHeld || points >= nodes) return;
	std::ostringstream message;
	message << "quadrature = 'lattice' gives " << points << " material points for " << nodes
		<< " background nodes, which could move without strain; admissible are as many "
		   "points as nodes: a larger nodeSpacing ("
		<< recipe.nodeSpacing << "), a smaller zeta (" << recipe.zeta << "), or 'cutCell'";
	throw std::invalid_argument(message.str());
}

template <int dim> void requireResolved(bool isResolved, const GrainTemplate<dim>& grain)
{
	if (isResolved) return;
	const bool isCut = grain.recipe.quadrature == QuadratureRule::cutCell;
	refuse("zeta", grain.recipe.zeta,
	       std::string("that resolves all parts of the outline: give a smaller one, or ") +
		       (isCut ? "thicken the thinnest" : "quadrature = 'cutCell'"));
}

/// Along hairs far thinner than a point, nodes are tied to the rest from so far that they take mass
/// from it.
template <int dim> void requirePositiveMasses(const GrainTemplate<dim>& grain)
{
	for (double mass : grain.nodeMass)
		requireResolved(mass > 0, grain);
}

/// At rest a contact node is where its background nodes carry it.
template <int dim> void requireCarriedOutline(const GrainTemplate<dim>& grain)
{
	constexpr double rounding = 1e-6;
	for (int s = 0; s < grain.contactNodes(); ++s) {
		Vec<dim> X = Vec<dim>::Zero();
		const auto& shapes = grain.contactShapes;
		for (int k = shapes.begin(s); k < shapes.end(s); ++k)
			X += shapes.value[k] * grain.nodePosition[shapes.column[k]];
		requireResolved((X - grain.contactMesh.vertex[s]).norm() < rounding, grain);
	}
}

/// Nodes, points and shape functions of B-splines.
template <int dim> void layGrid(const Outline<dim>& outline, GrainTemplate<dim>& grain)
{
	const TemplateRecipe& recipe = grain.recipe;
	const double dr = recipe.zeta;
	const Quadrature<dim> quadrature = makeQuadrature<dim>(recipe.quadrature, dr, outline);
	const BackgroundGrid<dim> grid(recipe.order, outline.gridSteps(dr, recipe.nodeSpacing),
				       quadrature);
	grain.volume = outline.volume();
	grain.gridSteps = grid.spacing();
	requirePointsForNodes<dim>(recipe, quadrature.point.size(), grid.position().size());
	grain.nodePosition = grid.position();
	grain.pointPosition = quadrature.point;
	grain.pointVolume = quadrature.weight;
	for (const Vec<dim>& X : quadrature.point)
		grid.appendShapes(X, grain.pointShapes);
	grain.pointLines = makePointLines(grid, quadrature);
	grain.nodeMass = recipe.lumping == Lumping::balanced
				 ? balancedNodeMass<dim>(grid.position(), grid.mass(), quadrature,
							 grain.pointShapes)
				 : grid.mass();
	requirePositiveMasses(grain);
	const bool isProjected = recipe.volumetric == VolumetricStrain::projected;
	grain.hourglass = hourglassStencils<dim>(grid, grain.pointLines, grain.nodeMass,
						 hourglassStiffness<dim>(isProjected));

	SparseRows<ShapeFunction<dim>> shapes;
	for (const Vec<dim>& X : grain.contactMesh.vertex)
		grid.appendShapes(X, shapes);
	grain.contactShapes.offset = shapes.offset;
	grain.contactShapes.column = shapes.column;
	for (const ShapeFunction<dim>& shape : shapes.value)
		grain.contactShapes.value.push_back(shape.N);
	requireCarriedOutline(grain);
}

/// The same of linear triangles, whose first nodes are the contact nodes.
void layTriangles(GrainTemplate<2>& grain)
{
	const TriangleMesh mesh = meshOfDisk(grain.contactMesh, grain.recipe.zeta);
	const Quadrature<2> quadrature = mesh.quadrature();
	grain.nodePosition = mesh.node;
	grain.nodeMass = mesh.nodeMass();
	grain.volume = std::accumulate(grain.nodeMass.begin(), grain.nodeMass.end(), 0.);
	grain.pointPosition = quadrature.point;
	grain.pointVolume = quadrature.weight;
	grain.pointShapes = mesh.shapes();
	grain.pointLines = makePointTable<2>(grain.nodes(), quadrature);
	for (int s = 0; s < grain.contactNodes(); ++s) {
		grain.contactShapes.append(s, 1);
		grain.contactShapes.closeRow();
	}
}

void layTriangles(GrainTemplate<3>&)
{
	throw std::invalid_argument("basis = 'triangles' is for disks (dim = 2)");
}

} // namespace

template <int dim>
std::shared_ptr<const GrainTemplate<dim>> makeGrainTemplate(const TemplateRecipe& recipe)
{
	recipe.validate();
	const auto outline = makeOutline<dim>(recipe.form);
	requireFewPoints(outline->volume() / std::pow(recipe.zeta, dim), recipe.zeta);
	auto grain = std::make_shared<GrainTemplate<dim>>();
	grain->recipe = recipe;
	grain->inradius = outline->inradius();
	layContactNodes(*outline, *grain);
	if (recipe.basis == Basis::triangles)
		layTriangles(*grain);
	else
		layGrid(*outline, *grain);
	for (double mass : grain->nodeMass)
		grain->inverseNodeMass.push_back(1 / mass);
	if (recipe.volumetric == VolumetricStrain::projected)
		grain->pressureSpace =
			makePressureSpace<dim>({ grain->pointPosition, grain->pointVolume },
					       2 * recipe.nodeSpacing * recipe.zeta);
	grain->contactValues = NodeRows<dim>(grain->contactShapes, grain->nodes());
	grain->contactKicks = kickRows<dim>(grain->contactShapes, grain->inverseNodeMass);
	grain->delassus = delassusTable(grain->contactShapes, grain->nodeMass);
	if (!grain->contactMesh.facet.empty())
		grain->surfaceMobility = SurfaceMobility<dim>(grain->contactMesh, grain->delassus);
	grain->overlap = delassusTable(grain->contactShapes,
				       std::vector<double>(grain->nodeMass.size(), 1.));
	return grain;
}

template NodeRows<2> kickRows<2>(SparseRows<double>, const std::vector<double>&);
template NodeRows<3> kickRows<3>(SparseRows<double>, const std::vector<double>&);
template std::shared_ptr<const GrainTemplate<2>> makeGrainTemplate<2>(const TemplateRecipe&);
template std::shared_ptr<const GrainTemplate<3>> makeGrainTemplate<3>(const TemplateRecipe&);

} // namespace softgrain
