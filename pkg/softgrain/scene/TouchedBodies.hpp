// What bodies are to soft grains: which they touch.
#pragma once

#include "Yade.hpp"
#include "assembly/GrainAssembly.hpp"

#include <vector>

namespace yade {

/// Whether soft grains touch bodies of this shape; those derived from one are not of it.
bool isTouched(const Shape& shape);

/// Throws std::runtime_error saying why the grain cannot touch the body that it comes near to.
[[noreturn]] void refusePair(const Body& grain, const Body& other);

/// What a body is to soft grains.
enum class Kind : char { unknown, none, grain, touched, refused };

/// Of all bodies of a scene. Bodies and their shapes lie far from interactions in memory, so each
/// is looked at once, however many interactions it has, and grains not at all.
class Kinds {
public:
	Kinds(const BodyContainer& bodies, const softgrain::GrainAssembly& assembly);
	Kind operator[](int id);
	/// Looks at no body.
	bool isGrain(int id) const { return isId(id) && kind_[id] == Kind::grain; }

private:
	/// (O.bodies.clear() leaves interactions of bodies behind that are no longer there.)
	bool isId(int id) const { return id >= 0 && std::size_t(id) < kind_.size(); }

	const BodyContainer& bodies_;
	std::vector<Kind> kind_;
};

} // namespace yade
