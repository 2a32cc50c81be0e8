// A system with its pairs and planes, driven as the host does: forces, search, step, motion of the
// planes.
#pragma once

#include "Helpers.hpp"
#include "grain/TotalLagrangian.hpp"
#include "step/System.hpp"

#include <deque>
#include <memory>

namespace softgrain::testing {

/// Of grains that many steps are made with.
template <int dim> TemplateRecipe coarse() { return recipe(dim == 2 ? 0.25 : 0.4); }

inline double stored(const EnergyBalance& e) { return e.kinetic + e.elastic; }

/// What stays constant, up to the error of the time integration.
inline double conserved(const EnergyBalance& e)
{
	return stored(e) + e.friction + e.impact + e.damping + e.sleep + e.cohesion - e.walls -
	       e.cell - e.loads;
}

template <int dim> struct Scene {
	/// Keeps its place when a scene is moved.
	std::unique_ptr<System<dim>> owned = std::make_unique<System<dim>>();
	System<dim>& system = *owned;
	std::deque<ContactList<dim>> lists; ///< planes move with their velocity
	StepSettings settings;
	double courant = 0.5; ///< time step over the critical one
	double time = 0;
	double deepest = 0;
	int steps = 0, failures = 0; ///< of the solver to reach its tolerance

	void add(std::unique_ptr<GrainSet<dim>> set)
	{
		system.add(std::move(set));
		system.updateSurfaces(1);
	}
	void add(Batch<dim> batch)
	{
		add(std::make_unique<TotalLagrangian<dim>>(std::move(batch)));
	}
	/// The others keep theirs; a sleeping grain is woken.
	void setLoad(int g, const BodyLoad<dim>& load)
	{
		system.activity().setLoads([&](int k) { return k == g ? load : system.loads()[k]; },
					   1);
	}
	/// Of a total-Lagrangian grain.
	Batch<dim>& batchOf(int g)
	{
		return dynamic_cast<TotalLagrangian<dim>&>(system.setOf(g)).batch();
	}
	const Batch<dim>& batchOf(int g) const { return const_cast<Scene*>(this)->batchOf(g); }
	int laneOf(int g) const { return system.indexInSet(g); }
	void addPairs(double friction)
	{
		addPairs(friction, [](int, int) { return true; });
	}
	/// Of those that `mayMeet`.
	template <class Chosen> void addPairs(double friction, Chosen&& mayMeet)
	{
		for (int a = 0; a < system.grains(); ++a)
			for (int b = a + 1; b < system.grains(); ++b) {
				if (!mayMeet(a, b)) continue;
				ContactList<dim> list;
				list.first = a;
				list.second = b;
				list.friction = friction;
				lists.push_back(list);
			}
	}
	ContactList<dim>& addPlane(int grain, const Vec<dim>& point, const Vec<dim>& normal,
				   const Vec<dim>& velocity = Vec<dim>::Zero(), double friction = 0)
	{
		ContactList<dim> list;
		list.first = grain;
		list.plane = { point, normal, velocity };
		list.friction = friction;
		lists.push_back(list);
		return lists.back();
	}
	StepReport advance(double dt)
	{
		settings.dt = dt;
		std::vector<ContactList<dim>*> pointers;
		for (ContactList<dim>& list : lists) {
			system.search(list, dt);
			pointers.push_back(&list);
		}
		const StepReport report = system.step(settings, pointers);
		for (ContactList<dim>& list : lists)
			if (list.second < 0) list.plane.point += dt * list.plane.velocity;
		deepest = std::max(deepest, report.deepest);
		failures += !report.solver.converged;
		time += dt;
		++steps;
		return report;
	}
	/// With the critical time step of the present deformation, times `courant`.
	StepReport advance()
	{
		system.updateForces(settings.threads);
		return advance(courant * system.presentCriticalTimeStep());
	}
	WholeGrain<dim> whole(int g) const { return system.setOf(g).whole(laneOf(g)); }
	Vec<dim> momentum() const
	{
		Vec<dim> sum = Vec<dim>::Zero();
		for (int g = 0; g < system.grains(); ++g)
			sum += whole(g).mass * whole(g).velocity;
		return sum;
	}
	/// Bits of all positions and velocities.
	std::vector<double> state() const
	{
		std::vector<double> all;
		for (int g = 0; g < system.grains(); ++g) {
			const GrainState s = system.setOf(g).state(laneOf(g));
			for (const auto* list : { &s.x, &s.v })
				all.insert(all.end(), list->begin(), list->end());
		}
		return all;
	}
};

} // namespace softgrain::testing
