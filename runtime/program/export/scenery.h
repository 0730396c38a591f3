// The scenery of a recording: colliders and balls, as bodies that do not deform.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "runtime/exchange/animation.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// colliders: numbers of those that are in the recording, in its order. left_out: names of those
// that have no triangles, since a file holds distances alone.
struct Scenery {
  std::vector<std::size_t> colliders;
  std::vector<std::string> left_out;
};

// Adds a body without coordinates. taken: names of all bodies so far; one that is taken gets
// "-collider" behind it.
void add_scenery(AnimatedShape shape, std::string name, std::set<std::string>& taken,
                 Animation& animation);

// Adds the colliders, planes if they are asked for. Planes are drawn so far as all shapes' sizes
// and places at rest reach, and some more.
Scenery add_colliders(std::span<const SceneCollider> colliders, bool planes,
                      std::set<std::string>& taken, Animation& animation);

}  // namespace tremolo
