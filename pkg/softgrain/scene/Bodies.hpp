// What a body is: its kind, its name in messages, the parts of a soft grain, how YADE moves it.
#pragma once

#include "Yade.hpp"

#include <string>
#include <typeinfo>

namespace yade {
class SoftGrain;
class SoftMat;

/// Whether an object is of a class itself, not of one derived from it.
template <class Class, class Base> bool isA(const shared_ptr<Base>& object)
{
	return object && typeid(*object) == typeid(Class);
}

bool isSoftGrain(const Body& body);
bool isPlate(const Shape& shape); ///< a Box or a Facet
/// Whether a rigid body has a material that contact with soft grains goes by.
bool hasFriction(const Body& body);

/// Shape of a body that is a soft grain.
SoftGrain& grainOf(const Scene& scene, int id);
/// Material of the same.
const SoftMat& materialOf(const Scene& scene, int id);

/// "body #1", for messages.
std::string nameOf(const Body& body);
/// "bodies #1 and #2".
std::string namesOf(const Interaction& I);

/// Whether it moves a body (NewtonIntegrator.mask).
bool isMoved(const Body& body, const NewtonIntegrator& newton);
/// Velocity with which it does, m/s; of others, whose State may have one, zero.
Vector3r motionOf(const Body& body, const NewtonIntegrator& newton);

} // namespace yade
