// Bodies of tetrahedra in a SceneWorld.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/mixed/tet_guests.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

struct WorldTets {
  std::vector<TetsKind> kinds;
  std::vector<std::size_t> kind_of;  // one per body
  TetGuests* guests = nullptr;       // the bodies; the world owns them

  const TetsKind& kind(std::size_t body) const { return kinds[kind_of[body]]; }
};

// Reads the files, moves the bodies to their positions and adds them to a world that was created
// for guests. path: of the scene, for errors. Errors: those of make_tets_bodies() and
// TetGuests::add(); kContent for a body that begins inside a collider or another body by more than
// its margin.
Result<WorldTets> add_tets(std::span<const TetSceneBody> bodies, const std::string& path,
                           SceneWorld& world);

}  // namespace tremolo
