// What of a body is wrong for a scene with soft grains.
#pragma once

namespace yade {
class Body;
class Scene;

/// Throws std::invalid_argument naming the body, its value that is not admissible, and what is.
void checkBody(const Body& body, const Scene& scene);

} // namespace yade
