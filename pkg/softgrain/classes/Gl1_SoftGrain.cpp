#include "classes/Gl1_SoftGrain.hpp"
#include "scene/DrawnOutline.hpp"

#include <GL/gl.h>
#include <GL/glu.h>

#include <array>
#include <deque>

namespace yade {

YADE_PLUGIN((Gl1_SoftGrain));

bool Gl1_SoftGrain::wire = false;

namespace {

void setColor(const Vector3r& color) { glColor3d(color[0], color[1], color[2]); }
void addVertex(const Vector3r& x) { glVertex3d(x[0], x[1], x[2]); }

void drawPoints(const DrawnOutline& outline)
{
	constexpr float pixels = 3;
	glDisable(GL_LIGHTING);
	glPointSize(pixels);
	glBegin(GL_POINTS);
	for (const Vector3r& x : outline.places)
		addVertex(x);
	glEnd();
	glEnable(GL_LIGHTING);
}

/// Unlit, as lines have no normal.
void drawEdges(const DrawnOutline& outline, int dim)
{
	const int ends = dim == 2 ? 1 : 3; // of a facet, where an edge begins
	glDisable(GL_LIGHTING);
	glBegin(GL_LINES);
	for (std::size_t k = 0; k < outline.facets.size(); k += dim)
		for (int i = 0; i < ends; ++i) {
			addVertex(outline.places[outline.facets[k + i]]);
			addVertex(outline.places[outline.facets[k + (i + 1) % dim]]);
		}
	glEnd();
	glEnable(GL_LIGHTING);
}

void drawTriangles(const DrawnOutline& outline)
{
	glBegin(GL_TRIANGLES);
	for (std::size_t k = 0; k < outline.facets.size(); k += 3) {
		const auto corner = [&](int i) -> const Vector3r& {
			return outline.places[outline.facets[k + i]];
		};
		const Vector3r n =
			(corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
		glNormal3d(n[0], n[1], n[2]);
		for (int i = 0; i < 3; ++i)
			addVertex(corner(i));
	}
	glEnd();
}

/// What OpenGL's own tessellator needs, which polygons with indentations and crossings are left to.
struct Tessellator {
	GLUtesselator* glu = gluNewTess();
	std::deque<std::array<double, 3>> vertices; ///< given, and made where sides cross

	Tessellator()
	{
		gluTessCallback(glu, GLU_TESS_BEGIN, reinterpret_cast<_GLUfuncptr>(glBegin));
		gluTessCallback(glu, GLU_TESS_VERTEX, reinterpret_cast<_GLUfuncptr>(glVertex3dv));
		gluTessCallback(glu, GLU_TESS_END, reinterpret_cast<_GLUfuncptr>(glEnd));
		gluTessCallback(glu, GLU_TESS_COMBINE_DATA,
				reinterpret_cast<_GLUfuncptr>(addCrossing));
		gluTessProperty(glu, GLU_TESS_WINDING_RULE, GLU_TESS_WINDING_NONZERO);
		gluTessNormal(glu, 0, 0, 1);
	}
	~Tessellator() { gluDeleteTess(glu); }
	Tessellator(const Tessellator&) = delete;

	double* add(const double* x)
	{
		return vertices.emplace_back(std::array<double, 3> { x[0], x[1], x[2] }).data();
	}
	static void addCrossing(double place[3], void* [4], float[4], void** made, void* self)
	{
		*made = static_cast<Tessellator*>(self)->add(place);
	}
};

/// A polygon in the plane.
void fill(const DrawnOutline& outline)
{
	Tessellator tessellator;
	glNormal3d(0, 0, 1);
	gluTessBeginPolygon(tessellator.glu, &tessellator);
	gluTessBeginContour(tessellator.glu);
	for (std::size_t k = 0; k < outline.facets.size(); k += 2) {
		double* x = tessellator.add(outline.places[outline.facets[k]].data());
		gluTessVertex(tessellator.glu, x, x);
	}
	gluTessEndContour(tessellator.glu);
	gluTessEndPolygon(tessellator.glu);
}

/// With its edge before the filling, which is as far away.
void drawPolygon(const DrawnOutline& outline, const Vector3r& color)
{
	constexpr double darker = 0.4;
	glEnable(GL_POLYGON_OFFSET_FILL);
	glPolygonOffset(1, 1);
	glColorMaterial(GL_FRONT_AND_BACK, GL_AMBIENT_AND_DIFFUSE);
	fill(outline);
	glColorMaterial(GL_FRONT, GL_AMBIENT_AND_DIFFUSE); // as the renderer has it
	glDisable(GL_POLYGON_OFFSET_FILL);
	setColor(darker * color);
	drawEdges(outline, 2);
}

} // namespace

void Gl1_SoftGrain::go(const shared_ptr<Shape>& shape, const shared_ptr<State>& state,
		       bool wireAsked, const GLViewInfo&)
{
	auto& grain = static_cast<SoftGrain&>(*shape);
	const auto outline = outlineToDraw(grain, *state);
	if (!outline) return;
	glDisable(GL_CULL_FACE); // disks are seen from behind, too
	setColor(grain.color);
	if (outline->facets.empty())
		drawPoints(*outline);
	else if (wire || wireAsked)
		drawEdges(*outline, grain.dim);
	else if (grain.dim == 3)
		drawTriangles(*outline);
	else
		drawPolygon(*outline, grain.color);
}

} // namespace yade
