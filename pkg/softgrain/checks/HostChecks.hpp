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
/// Whether the collider may have given a body that is to have one no box, or that of a shape which
/// its own is derived from.
bool mayLackBound(const Body& body);
/// Throws std::invalid_argument for the first of the bodies, from an id on, of which that is so:
/// soft grains would pass through it.
void checkBounds(const Scene& scene, int first);

} // namespace yade
