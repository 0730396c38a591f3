// The objects behind the handles of runtime/tremolo_scene.h.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/c/c_api.h"
#include "runtime/scene/scene.h"
#include "runtime/tremolo_scene.h"
#include "runtime/world/guest_bound.h"
#include "runtime/world/scene_world.h"
#include "runtime/world/world_guests.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
// path: of the file, for errors; empty: none. models: of the reduced bodies that calls added, whose
// SceneBody::model is the model's number there. around: gravity, wind and step of cloths that
// follow.
struct tremolo_scene {
  std::string path;
  tremolo::Scene scene;
  std::vector<tremolo::TetSceneBody> tets;
  std::vector<tremolo::ClothSceneBody> cloths;
  std::vector<tremolo::Model::Pointer> models;
  tremolo::ClothScene around;
};
struct tremolo_world {
  // Of a body that is not one of the SceneWorld's.
  struct Guest {
    tremolo::GuestBound bound;
    bool driven = false;                    // wind or pins put in energy that the bound misses
    bool over = false;                      // it has failed, which was reported
    std::vector<Eigen::Index> particles{};  // of each drawn vertex of a cloth
  };

  tremolo::SceneWorld world;
  tremolo::WorldGuests made = {};
  std::vector<Guest> guests = {};
  // Buffers of a call.
  mutable std::vector<Eigen::Vector3d> vertices = {};
  mutable std::vector<Eigen::Vector3f> normals = {};
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// True while the energy of a guest is compatible with what was put into it.
bool look_at(const tremolo_world& world, std::size_t guest, GuestBound& bound);

}  // namespace tremolo::c_api
