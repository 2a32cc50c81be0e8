// What contact sees of a grain: positions and velocities of its contact nodes, and the constant
// table that turns impulses on them into velocities of them. Nothing of the background grid.
#pragma once

#include "Vector.hpp"
#include "reference/Outline.hpp"
#include "reference/SparseRows.hpp"

#include <vector>

namespace softgrain {

template <int dim> struct Box {
	Vec<dim> low = Vec<dim>::Zero(), high = Vec<dim>::Zero();

	bool overlaps(const Box& other) const
	{
		return (low.array() <= other.high.array()).all() &&
		       (other.low.array() <= high.array()).all();
	}
	bool contains(const Vec<dim>& x) const
	{
		return (low.array() <= x.array()).all() && (x.array() <= high.array()).all();
	}
	Box grown(double margin) const { return { low.array() - margin, high.array() + margin }; }
	Vec<dim> centre() const { return 0.5 * (low + high); }
};

template <int dim> struct ContactBody {
	const OutlineMesh<dim>* mesh =
		nullptr; ///< facets; without any the contact nodes are disks (spheres)
	const SparseRows<double>* delassus = nullptr;
	double delassusScale = 0; ///< 1/(rho R^dim); table times this is W_ss', 1/kg
	double nodeRadius = 0;    ///< of the disk about a contact node, m; 0 on a surface
	double pointSpacing = 0;  ///< dr, m: the measure of overlaps

	std::vector<Vec<dim>> position; ///< xs at t_n, m
	std::vector<Vec<dim>>
		normal; ///< outward unit normals at the contact nodes; empty without facets
	std::vector<Vec<dim>> velocity; ///< vs at t_n + dt/2, being solved, m/s
	std::vector<Vec<dim>>
		velocityBefore;        ///< vs at t_n - dt/2, m/s; empty unless energies are tracked
	std::vector<Vec<dim>> impulse; ///< sum of the reactions on each node, N s
	Box<dim> box;                  ///< of the positions, node radii included
	double fastest = 0;            ///< largest speed of a node, m/s

	int nodes() const { return static_cast<int>(position.size()); }
	bool isSurface() const { return !mesh->facet.empty(); }

	/// Renews normals and box after `position` was set.
	void updateGeometry();
	/// Adds W_ss' J to the velocities of all nodes s that feel an impulse J on node s'.
	void push(int node, const Vec<dim>& J)
	{
		for (int k = delassus->begin(node); k < delassus->end(node); ++k)
			velocity[delassus->column[k]] += delassusScale * delassus->value[k] * J;
	}
	/// W_ss', 1/kg; 0 for nodes that do not feel each other.
	double mobility(int node, int other) const;
};

} // namespace softgrain
