// What several tests of the kernel need: repeatable random numbers and small builders.
#pragma once

#include "Vector.hpp"
#include "contact/ContactBody.hpp"
#include "contact/ContactList.hpp"
#include "grain/Batch.hpp"
#include "reference/GrainTemplate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace softgrain::testing {

/// Random numbers that are the same in every run and with every standard library.
class Random {
public:
	explicit Random(unsigned seed)
		: generator_(seed)
	{
	}
	double uniform(double low, double high)
	{
		return low +
		       (high - low) * (generator_() / static_cast<double>(std::mt19937::max()));
	}
	int index(int count)
	{
		return static_cast<int>(generator_() % static_cast<unsigned>(count));
	}
	template <int dim> Vec<dim> vector(double size = 1)
	{
		Vec<dim> value;
		for (int a = 0; a < dim; ++a)
			value[a] = uniform(-size, size);
		return value;
	}
	template <int dim> Vec<dim> direction() { return vector<dim>().normalized(); }
	template <int dim> Mat<dim> matrix(double size = 1)
	{
		Mat<dim> value;
		for (int a = 0; a < dim; ++a)
			value.col(a) = vector<dim>(size);
		return value;
	}
	/// Deformation gradient with det F > 0.2.
	template <int dim> Mat<dim> deformation(double size)
	{
		for (;;) {
			const Mat<dim> F = Mat<dim>::Identity() + matrix<dim>(size);
			if (F.determinant() > 0.2) return F;
		}
	}
	template <int dim> Mat<dim> rotation()
	{
		if constexpr (dim == 2)
			return Eigen::Rotation2Dd(uniform(-3, 3)).toRotationMatrix();
		else
			return Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1),
						  uniform(-1, 1))
				.normalized()
				.toRotationMatrix();
	}

private:
	std::mt19937 generator_;
};

/// Of the first two bodies, empty.
template <int dim> ContactList<dim> pairList()
{
	ContactList<dim> list;
	list.first = 0;
	list.second = 1;
	return list;
}

/// Message of the std::invalid_argument that `call` throws, or "" where it throws none.
inline std::string complaintOf(const std::function<void()>& call)
{
	try {
		call();
	} catch (const std::invalid_argument& error) {
		return error.what();
	}
	return "";
}

/// Condition that a test without interest in it uses.
template <int dim>
constexpr Condition usualCondition = dim == 2 ? Condition::planeStrain : Condition::solid;

/// The grain of the paper: R = 10 mm, E = 1 MPa, nu = 0.45, rho = 1000 kg/m^3.
template <int dim> GrainParameters<dim> paperGrain()
{
	GrainParameters<dim> grain;
	grain.radius = 0.01;
	grain.constants = { 1e6, 0.45, 1000 };
	return grain;
}

inline TemplateRecipe recipe(double zeta, int order = 3, double nodeSpacing = 2)
{
	TemplateRecipe r;
	r.zeta = zeta;
	r.order = order;
	r.nodeSpacing = nodeSpacing;
	return r;
}

inline TemplateRecipe projectedRecipe(double zeta, int order = 3)
{
	TemplateRecipe r = recipe(zeta, order);
	r.volumetric = VolumetricStrain::projected;
	return r;
}

/// Of a polygon, which is moved about its centroid.
inline TemplateRecipe polygonRecipe(double zeta, Ring ring, int order = 3, double nodeSpacing = 2)
{
	const Vec<2> centroid = ring.centroid();
	for (Vec<2>& X : ring.vertex)
		X -= centroid;
	TemplateRecipe r = recipe(zeta, order, nodeSpacing);
	r.form.form = Form::polygon;
	r.form.ring = std::make_shared<const Ring>(std::move(ring));
	return r;
}

template <int dim>
Batch<dim> singleGrain(const TemplateRecipe& r,
		       const GrainParameters<dim>& grain = paperGrain<dim>(),
		       Condition condition = usualCondition<dim>)
{
	return Batch<dim>(makeGrainTemplate<dim>(r), Law::neoHookean, condition, { grain });
}

/// Homogeneous deformation F of grain g about its centre.
template <int dim> void deform(Batch<dim>& batch, int g, const Mat<dim>& F)
{
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.x.set(g, I, batch.grain[g].radius * (F * batch.reference->nodePosition[I]));
}

/// Makes the first grain deformed, noisy, spinning and flying.
template <int dim> void makeNoisy(Batch<dim>& batch, Random& random)
{
	deform<dim>(batch, 0, random.deformation<dim>(0.1));
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.v.set(0, I, random.vector<dim>(0.5));
	const Mat<dim> A = random.matrix<dim>(20);
	batch.moveRigidly(0, Vec<dim>::Zero(), Mat<dim>::Identity(), Vec<dim>::Zero(),
			  random.vector<dim>(), A - A.transpose());
}

/// Adds noise to the nodal positions, up to `size` radii.
template <int dim> void shake(Batch<dim>& batch, int g, double size, Random& random)
{
	for (int I = 0; I < batch.reference->nodes(); ++I)
		batch.x.set(g, I,
			    batch.x.get(g, I) + random.vector<dim>(size * batch.grain[g].radius));
}

/// The contact nodes of an undeformed grain anywhere in space. `reference` must outlive it.
template <int dim>
ContactBody<dim> contactBody(const GrainTemplate<dim>& reference, double radius,
			     const Vec<dim>& centre,
			     const Mat<dim>& rotation = Mat<dim>::Identity())
{
	ContactBody<dim> body;
	body.mesh = &reference.contactMesh;
	body.delassus = &reference.delassus;
	body.overlap = &reference.overlap;
	body.delassusScale = 1 / (1000 * std::pow(radius, dim));
	body.nodeRadius = radius * reference.contactRadius;
	body.pointSpacing = radius * reference.pointSpacing();
	body.inradius = radius * reference.inradius;
	for (const Vec<dim>& X : reference.contactMesh.vertex)
		body.position.push_back(centre + radius * (rotation * X));
	body.velocity.assign(body.position.size(), Vec<dim>::Zero());
	body.impulse = body.velocity;
	body.updateGeometry();
	return body;
}

/// Notes the way of the nodes of an outline that were at `from` when its box was about `centre`.
template <int dim>
void noteWays(ContactOutline<dim>& body, const std::vector<Vec<dim>>& from, const Vec<dim>& centre)
{
	const Vec<dim> together = body.box.centre() - centre;
	double farthest = 0;
	for (std::size_t s = 0; s < from.size(); ++s)
		farthest = std::max(farthest, (body.position[s] - from[s] - together).norm());
	body.carried += together;
	body.travelled += farthest;
}

} // namespace softgrain::testing
