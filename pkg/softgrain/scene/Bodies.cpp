#include "scene/Bodies.hpp"
#include "classes/SoftGrain.hpp"
#include "classes/SoftMat.hpp"

namespace yade {

bool isSoftGrain(const Body& body) { return isA<SoftGrain>(body.shape); }

bool isPlate(const Shape& shape)
{
	const int kind = shape.getClassIndex();
	return kind == Box::getClassIndexStatic() || kind == Facet::getClassIndexStatic();
}

bool hasFriction(const Body& body) { return bool(YADE_PTR_DYN_CAST<FrictMat>(body.material)); }

SoftGrain& grainOf(const Scene& scene, int id)
{
	return static_cast<SoftGrain&>(*(*scene.bodies)[id]->shape);
}

const SoftMat& materialOf(const Scene& scene, int id)
{
	return static_cast<const SoftMat&>(*(*scene.bodies)[id]->material);
}

std::string nameOf(const Body& body) { return "body #" + std::to_string(body.getId()); }

std::string namesOf(const Interaction& I)
{
	return "bodies #" + std::to_string(I.getId1()) + " and #" + std::to_string(I.getId2());
}

bool isMoved(const Body& body, const NewtonIntegrator& newton)
{
	return newton.mask <= 0 || body.maskCompatible(newton.mask);
}

Vector3r motionOf(const Body& body, const NewtonIntegrator& newton)
{
	return isMoved(body, newton) ? body.state->vel : Vector3r(Vector3r::Zero());
}

} // namespace yade
