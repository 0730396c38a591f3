// The scenery of a recording: colliders and balls, as bodies that do not deform.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "runtime/exchange/animation.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// colliders: numbers of the recorded ones, in that order. left_out: names of colliders without
// triangles, whose file has only distances.
struct Scenery {
  std::vector<std::size_t> colliders;
  std::vector<std::string> left_out;
};

// Adds a body without coordinates. taken: names of all bodies so far; an existing name gets
// "-collider" appended.
void add_scenery(AnimatedShape shape, std::string name, std::set<std::string>& taken,
                 Animation& animation);

// Adds the colliders, with planes if requested. Planes extend over the sizes and positions of all
// shapes at rest, with a margin.
Scenery add_colliders(std::span<const SceneCollider> colliders, bool planes,
                      std::set<std::string>& taken, Animation& animation);

}  // namespace tremolo
