// The objects behind the handles of runtime/tremolo_scene.h, and C structs to values of a scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/c/c_api.h"
#include "runtime/scene/scene.h"
#include "runtime/tremolo_scene.h"
#include "runtime/world/world.h"

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
// models, around: those of the scene, for bodies that follow.
struct tremolo_world {
  std::unique_ptr<tremolo::World> world;
  std::vector<tremolo::Model::Pointer> models;
  tremolo::ClothScene around;
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// Bodies, colliders and joints of a scene. Errors kUsage: no name, a quaternion of another length;
// errors of the options. models: receives the model of a reduced body, which is named there.
Result<SceneBody> reduced_body(const tremolo_scene_body* place, const tremolo_model& model,
                               const tremolo_body_options* method, const tremolo_collider* shape,
                               std::vector<Model::Pointer>& models);
Result<SceneBody> rigid_body(const tremolo_scene_body* place, const tremolo_collider& shape,
                             double mass);
Result<TetSceneBody> tets_body(const tremolo_scene_body* place,
                               const tremolo_tets_options* options);
Result<ClothSceneBody> cloth_body(const ClothScene& around, const tremolo_scene_body* place,
                                  const char* method, const tremolo_cloth_options* options,
                                  const size_t* pins, size_t count);
// number: of the colliders before it.
Result<SceneCollider> scene_collider(const tremolo_placed_collider& collider, std::size_t number);
Result<SceneJoint> scene_joint(const tremolo_joint& joint);
Result<SceneLoad> scene_load(const tremolo_load& load);

// The model of a body: one of those that calls gave, or of its file.
Result<Model::Pointer> model_of(const std::vector<Model::Pointer>& models, const SceneBody& body);

}  // namespace tremolo::c_api
