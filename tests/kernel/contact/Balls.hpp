// Round bodies with the exact gaps between them.
#pragma once

#include "Helpers.hpp"
#include "contact/ContactBody.hpp"

#include <vector>

namespace softgrain::testing {

/// Balls and the meshes they stand on; the tables that only the solver needs are left out.
template <int dim> struct Balls {
	std::vector<OutlineMesh<dim>> mesh;
	std::vector<ContactBody<dim>> body;
	std::vector<Vec<dim>> centre;
	std::vector<double> radius;

	Balls() { mesh.reserve(10); }
	void add(double R, const Vec<dim>& c, const Mat<dim>& Q, double spacing)
	{
		mesh.push_back(UnitBall<dim>().mesh(spacing / R));
		ContactBody<dim> b;
		b.mesh = &mesh.back();
		b.pointSpacing = spacing;
		b.inradius = R;
		for (const Vec<dim>& X : mesh.back().vertex)
			b.position.push_back(c + R * (Q * X));
		b.updateGeometry();
		body.push_back(b);
		centre.push_back(c);
		radius.push_back(R);
	}
	/// Exact gap of a node to the other ball.
	double gap(int from, int node, int to) const
	{
		return (body[from].position[node] - centre[to]).norm() - radius[to];
	}
};

/// A ball of radius 1 and one of radius 0.7, `gap` apart in any direction, turned anyhow.
template <int dim> Balls<dim> twoBalls(double gap, double spacing, unsigned seed)
{
	Random random(seed);
	Balls<dim> balls;
	const Vec<dim> start = random.vector<dim>(3), way = random.direction<dim>();
	balls.add(1, start, random.rotation<dim>(), spacing);
	balls.add(0.7, start + (1.7 + gap) * way, random.rotation<dim>(), spacing);
	return balls;
}

} // namespace softgrain::testing
