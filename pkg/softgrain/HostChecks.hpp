// What YADE offers and soft grains do not get along with.
#pragma once

namespace yade {
class Body;
class Scene;

/// Throws std::invalid_argument naming the engine or setting of the scene that would act wrongly on
/// soft grains, or end the process, and what to do instead.
void checkHost(const Scene& scene);
/// The same if the body is divided among processes.
void checkSubdomain(const Body& body);
/// The same if no collider of the scene has a functor for the shape of the body: nothing would ever
/// touch it.
void checkBound(const Scene& scene, const Body& body);

} // namespace yade
