#include "scene/TouchedBodies.hpp"
#include "classes/SoftGrain.hpp"
#include "scene/Bodies.hpp"

#include <typeinfo>

namespace yade {

/// Functors for a shape are called for those derived from it too, as a Cylinder is from Sphere.
bool isTouched(const Shape& shape)
{
	const auto& type = typeid(shape);
	return type == typeid(SoftGrain) || type == typeid(Wall) || type == typeid(Sphere) ||
	       type == typeid(Facet) || type == typeid(Box);
}

namespace {

bool isTouched(const Body& body)
{
	return isTouched(*body.shape) && (isSoftGrain(body) || hasFriction(body));
}

string whyNotTouched(const Body& body)
{
	const string shape = body.shape->getClassName();
	if (!isTouched(*body.shape))
		return "of shape " + shape +
		       ". Soft grains touch SoftGrain, Wall, Sphere, Facet and Box only";
	if (!isTouched(body))
		return "of material " +
		       (body.material ? body.material->getClassName() : string("None")) +
		       ". Rigid bodies that soft grains touch need a FrictMat, or one derived from "
		       "it";
	return "of shape " + shape +
	       ", for which the InteractionLoop (the first one, if there are several) has no Ig2 "
	       "functor: add "
	       "Ig2_SoftGrain_SoftGrain_SoftGeom, Ig2_Wall_SoftGrain_SoftGeom, "
	       "Ig2_Sphere_SoftGrain_SoftGeom ..., or see sg.engines()";
}

Kind kindOf(const Body* body)
{
	if (!body || !body->shape) return Kind::none;
	return isTouched(*body) ? Kind::touched : Kind::refused;
}

} // namespace

void refusePair(const Body& grain, const Body& other)
{
	throw std::runtime_error("soft grain #" + std::to_string(grain.getId()) +
				 " comes near body #" + std::to_string(other.getId()) + " " +
				 whyNotTouched(other));
}

Kinds::Kinds(const BodyContainer& bodies, const softgrain::GrainAssembly& assembly)
	: bodies_(bodies)
	, kind_(bodies.size(), Kind::unknown)
{
	for (int g = 0; g < assembly.grains(); ++g)
		kind_[assembly.idOf(g)] = Kind::grain;
}

Kind Kinds::operator[](int id)
{
	if (!isId(id)) return Kind::none;
	if (kind_[id] == Kind::unknown) kind_[id] = kindOf(bodies_[id].get());
	return kind_[id];
}

} // namespace yade
